#include "validate/papers/papers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/errors.hpp"
#include "validate/papers/detail/paper_groups.hpp"

namespace klang::validate {
namespace {

double relative(double value, double to) { return std::abs(value / to - 1.0); }

std::string shown(double value, int digits = 6) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string shown_percent(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) < 1e-3 ? "%+.1g %%" : "%+.1f %%", 100.0 * value);
  return text;
}

std::string reference_cell(const PaperNumber& n) {
  if (!n.reference) return "-";
  const std::string within =
      n.reference_tolerance > 1e-3 ? ", within " + shown(100.0 * n.reference_tolerance, 2) + " %" : "";
  return shown(*n.reference) + " (" + n.reference_source + within + ")";
}

}  // namespace

PaperVerdict verdict_of(const PaperNumber& number) {
  const bool ours_is_right =
      !number.reference || relative(number.ours, *number.reference) <= number.reference_tolerance;
  const bool agrees = relative(number.ours, number.printed) <= number.tolerance;
  const bool known = number.reference || !number.paper_off;
  if (!std::isfinite(number.ours) || !known || !ours_is_right || agrees == number.paper_off)
    return PaperVerdict::kDiffers;
  return agrees ? PaperVerdict::kAgrees : PaperVerdict::kPaperOff;
}

bool PaperTables::passed() const {
  return std::all_of(numbers.begin(), numbers.end(), [](const PaperNumber& n) {
    return n.verdict == PaperVerdict::kAgrees || n.verdict == PaperVerdict::kPaperOff;
  });
}

PaperTables run_papers(Monitor& monitor, const std::filesystem::path& runs) {
  PaperTables tables;
  tables.scenes = detail::paper_scenes(runs);
  const auto run = [&](const char* stage, double done, std::vector<PaperNumber> (*group)(Monitor&)) {
    monitor.throw_if_stopped();
    monitor.progress(stage, done);
    for (PaperNumber& number : group(monitor)) {
      number.verdict = verdict_of(number);
      tables.numbers.push_back(std::move(number));
    }
  };
  run("rigid-body sound", 0.0, detail::rigid_body_sound_numbers);
  run("fluids", 0.5, detail::harmonic_fluid_numbers);
  run("soundbanks", 0.9, detail::soundbank_numbers);
  run("fracture", 0.95, detail::fracture_numbers);
  tables.gaps = detail::paper_gaps();
  monitor.progress("papers", 1.0);
  return tables;
}

std::string verdict_words(const PaperScene& scene) {
  std::string words = to_text(scene.verdict);
  if (scene.reason.empty()) return words;
  return scene.verdict == SceneVerdict::kNotRun ? words + " (" + scene.reason + ")" : words + ": " + scene.reason;
}

std::vector<Claim> claims_of(const PaperTables& tables) {
  std::vector<Claim> claims;
  for (const PaperNumber& n : tables.numbers) {
    Claim claim;
    claim.name = n.id;
    claim.words = n.paper + ", " + n.place + ": " + n.quantity + (n.note.empty() ? "" : "; " + n.note);
    claim.measured = n.ours;
    claim.reference = n.reference && n.paper_off ? *n.reference : n.printed;
    claim.tolerance = std::abs(*claim.reference) * (n.reference && n.paper_off ? n.reference_tolerance : n.tolerance);
    claim.passed = n.verdict == PaperVerdict::kAgrees || n.verdict == PaperVerdict::kPaperOff;
    claims.push_back(std::move(claim));
  }
  return claims;
}

PapersDocument papers_document(ResultHeader header, const PaperTables& tables) {
  return {std::move(header), tables.passed(), tables.numbers, tables.scenes, tables.gaps};
}

namespace {

std::string headline(const PaperTables& tables) {
  std::string text =
      "# The papers' numbers\n\nMade by `klang validate papers --markdown docs/papers.md`; a test compares it. "
      "*agrees*: "
      "within the tolerance of the printed number;\n*paper is off*: the printed number is known to be wrong or "
      "inaccurate ([errata](errata.md)), ours is another and is what its reference says;\n*differs*: an open "
      "discrepancy, which fails the command. A reference was made outside this project, follows from the paper's own "
      "law, or is\nwhat it says. A tolerance that begins with *chosen* is ours, in sight of the numbers: neither the "
      "printed digits nor a theory give it, and\nagreement within it says no more than that.\n\n"
      "| what ours is | numbers | agree | of these within a chosen tolerance | paper is off | differ |\n"
      "| --- | --- | --- | --- | --- | --- |\n";
  constexpr std::pair<NumberSource, const char*> kSources[] = {
      {NumberSource::kProgram, "by functions of the program, when the command runs"},
      {NumberSource::kPaper, "arithmetic on the paper's other numbers: no test of the program"},
      {NumberSource::kElsewhere, "a preset or a constant of textbooks: no test of the program"}};
  for (const auto& [source, words] : kSources) {
    text += "| *" + to_text(source) + "*: " + words;
    const auto count = [&, of = source](auto counts) {
      text += " | " + std::to_string(std::count_if(tables.numbers.begin(), tables.numbers.end(),
                                                   [&](const PaperNumber& n) { return n.source == of && counts(n); }));
    };
    count([](const PaperNumber&) { return true; });
    count([](const PaperNumber& n) { return n.verdict == PaperVerdict::kAgrees; });
    count([](const PaperNumber& n) {
      return n.verdict == PaperVerdict::kAgrees && n.tolerance_source.rfind("chosen", 0) == 0;
    });
    count([](const PaperNumber& n) { return n.verdict == PaperVerdict::kPaperOff; });
    count([](const PaperNumber& n) { return n.verdict == PaperVerdict::kDiffers; });
    text += " |\n";
  }
  return text;
}

}  // namespace

std::string markdown(const PaperTables& tables) {
  std::string text = headline(tables);
  std::string place;
  for (const PaperNumber& n : tables.numbers) {
    if (n.paper + n.place != place) {
      place = n.paper + n.place;
      text +=
          "\n## " + n.paper + ", " + n.place +
          "\n| quantity | printed | ours | what ours is | difference | reference | tolerance | verdict |\n| --- | --- "
          "| --- | --- | --- | --- | --- | --- |\n";
    }
    text += "| " + n.quantity + (n.note.empty() ? "" : " (" + n.note + ")") + " | " + shown(n.printed) + " | " +
            shown(n.ours, n.digits) + " | " + to_text(n.source) + " | " +
            shown_percent(std::stod(shown(n.ours, n.digits)) / n.printed - 1.0) + " | " + reference_cell(n) + " | " +
            shown(100.0 * n.tolerance, 2) + " %: " + n.tolerance_source + " | " + to_text(n.verdict) + " |\n";
  }
  text +=
      "\n## Scenes, run by hand\nNot computed when the command runs: of the version and by the command said, or of "
      "folders of `klang scene run` that `klang validate papers\n--scenes RUNS` reads (RUNS/sb_tile for "
      "scenes/sb/tile.toml). Sizes, strengths and falls that a paper does not give are ours, and a machine "
      "is\nanother: "
      "these are no part of the verdict. *agrees*: within a tenth; *same order*: within a factor of two. Unfinished or "
      "partial runs, and\nthose of another scene file, are not judged.\n\n"
      "| paper | where | scene | quantity | printed | ours | verdict | made by |\n| --- | --- | --- | --- | --- | --- "
      "| --- | --- |\n";
  for (const PaperScene& scene : tables.scenes) {
    text += "| " + scene.paper + " | " + scene.place + " | `" + scene.scene + "` | " + scene.quantity +
            (scene.note.empty() ? "" : " (" + scene.note + ")") + " | " +
            (scene.printed ? shown(*scene.printed, 4) : "-") + " | " + (scene.ours ? shown(*scene.ours, 4) : "-") +
            " | " + verdict_words(scene) + " | " + (scene.ours ? "`" + scene.command + "`, " + scene.version : "-") +
            " |\n";
  }
  text += "\n## Not computed\n| paper | where | why |\n| --- | --- | --- |\n";
  for (const PaperGap& gap : tables.gaps) text += "| " + gap.paper + " | " + gap.place + " | " + gap.reason + " |\n";
  return text;
}

}  // namespace klang::validate
