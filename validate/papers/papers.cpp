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

}  // namespace

PaperVerdict verdict_of(const PaperNumber& number) {
  const bool ours_is_right =
      !number.reference || relative(number.ours, *number.reference) <= number.reference_tolerance;
  const bool agrees = relative(number.ours, number.printed) <= number.tolerance;
  if (!std::isfinite(number.ours) || !ours_is_right || agrees == number.paper_off) return PaperVerdict::kDiffers;
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

std::string markdown(const PaperTables& tables) {
  const auto count = [&](PaperVerdict verdict) {
    return std::to_string(std::count_if(tables.numbers.begin(), tables.numbers.end(),
                                        [&](const PaperNumber& n) { return n.verdict == verdict; }));
  };
  std::string text =
      "# The papers' numbers\n\nMade by `klang validate papers --markdown docs/papers.md`; a test compares it. Each "
      "number of ours is computed when the command\n"
      "runs. *agrees*: within the tolerance of the printed one; *paper is off*: the printed number is known to be "
      "wrong or inaccurate\n"
      "([errata](errata.md)), and ours is another; *differs*: an open discrepancy, which fails the command. A "
      "reference was made outside this\n"
      "project, or follows from the paper's own law, as said. " +
      std::to_string(tables.numbers.size()) + " numbers: " + count(PaperVerdict::kAgrees) + " agree, " +
      count(PaperVerdict::kPaperOff) + " off in the paper, " + count(PaperVerdict::kDiffers) + " differ.\n";
  std::string place;
  for (const PaperNumber& n : tables.numbers) {
    if (n.paper + n.place != place) {
      place = n.paper + n.place;
      text += "\n## " + n.paper + ", " + n.place +
              "\n| quantity | printed | ours | difference | reference | tolerance | verdict |\n| --- | --- | --- | --- "
              "| --- | --- | --- |\n";
    }
    text += "| " + n.quantity + (n.note.empty() ? "" : " (" + n.note + ")") + " | " + shown(n.printed) + " | " +
            shown(n.ours, n.digits) + " | " + shown_percent(std::stod(shown(n.ours, n.digits)) / n.printed - 1.0) +
            " | " + (n.reference ? shown(*n.reference) + " (" + n.reference_source + ")" : "-") + " | " +
            shown(100.0 * n.tolerance, 2) + " %: " + n.tolerance_source + " | " + to_text(n.verdict) + " |\n";
  }
  text +=
      "\n## Scenes, run by hand\nSizes, strengths and falls that a paper does not give are ours, and a machine is "
      "another: these are no part of the "
      "verdict. *agrees*: within a tenth;\n*same order*: within a factor of two. `klang validate papers --scenes RUNS` "
      "reads "
      "them from folders of `klang scene run`\n(RUNS/sb_tile for scenes/sb/tile.toml).\n\n"
      "| paper | where | scene | quantity | printed | ours | verdict | made by |\n| --- | --- | --- | --- | --- | --- "
      "| --- | --- |\n";
  for (const PaperScene& scene : tables.scenes) {
    text += "| " + scene.paper + " | " + scene.place + " | `" + scene.scene + "` | " + scene.quantity +
            (scene.note.empty() ? "" : " (" + scene.note + ")") + " | " +
            (scene.printed ? shown(*scene.printed, 4) : "-") + " | " +
            (scene.ours ? shown(*scene.ours, 4) : "not run") + " | " + to_text(scene.verdict) + " | " +
            (scene.ours ? "`" + scene.command + "`, " + scene.version : "-") + " |\n";
  }
  text += "\n## Not computed\n| paper | where | why |\n| --- | --- | --- |\n";
  for (const PaperGap& gap : tables.gaps) text += "| " + gap.paper + " | " + gap.place + " | " + gap.reason + " |\n";
  return text;
}

}  // namespace klang::validate
