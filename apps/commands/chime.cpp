#include <CLI/CLI.hpp>
#include <memory>
#include <sstream>

#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/modal/damping/assumed_damping.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/instrument/chime.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct ChimeCommand {
  std::string fit, notes, output, temperament = "equal";
  fit::ChimeOptions chime;
};

std::vector<std::string> words_of_notes(std::string text) {
  for (char& c : text) {
    if (c == ',') c = ' ';
  }
  std::istringstream stream(text);
  std::vector<std::string> notes;
  for (std::string note; stream >> note;) notes.push_back(note);
  return notes;
}

int run_chime(const ChimeCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  fit::ChimeOptions options = command.chime;
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  options.notes = words_of_notes(command.notes);
  options.temperament = audio::Temperament::parse(command.temperament);
  const fit::FitDocument fit = fit::read_fit_document(command.fit);
  OutputDirectory out(command.output);
  const fit::ChimeSet set = fit::chime_set(fit, command.fit, options, monitor);

  const nlohmann::json used = {{"notes", options.notes},
                               {"a4_hz", options.a4_hz},
                               {"temperament", command.temperament},
                               {"specimen", options.specimen}};
  std::vector<std::filesystem::path> inputs{command.fit};
  if (command.temperament.ends_with(".scl")) inputs.emplace_back(command.temperament);
  fit::ChimeDocument document;
  document.header = make_header("chime", "done", common, used, inputs);
  document.name = fit.name;
  document.a4_hz = options.a4_hz;
  document.temperament = options.temperament.name();
  document.damping = set.damping_is_assumed ? "assumed" : "fitted";
  document.notes = set.notes;
  document.sound = "set.wav";
  std::vector<std::string>& warnings = document.header.warnings;
  if (set.damping_is_assumed) warnings.push_back(damping::assumed_damping_words(command.fit));
  if (std::any_of(set.notes.begin(), set.notes.end(), [](const fit::ChimeNote& n) { return !n.length_std_m; }))
    warnings.emplace_back("the fit does not say how well E is known: lengths have no uncertainty");
  const nlohmann::json json = json_of(document);
  audio::write_sound(out.staging() / "set.wav", set.sound);
  write_file(out.staging() / "cut-list.csv", csv_table(set.notes));
  write_file(out.staging() / "chime.json", json_text(json));
  const auto report = reports::write_report(out.staging() / "chime.json", {}, monitor);
  monitor.throw_if_stopped();
  out.commit();
  write_json(common, json);
  for (const std::string& warning : warnings) warn(warning);
  for (const std::string& warning : report.warnings) warn(warning);
  say(common, "%-6s %12s %12s %10s %18s %12s\n", "note", "frequency_hz", "length_mm", "std_mm", "cents_per_0.1_mm",
      "node_mm");
  for (const fit::ChimeNote& note : set.notes) {
    say(common, "%-6s %12.3f %12.2f", note.note.c_str(), note.frequency_hz, 1e3 * note.length_m);
    if (note.length_std_m) {
      say(common, " %10.2f", 1e3 * *note.length_std_m);
    } else {
      say(common, " %10s", "-");
    }
    say(common, " %18.3f %12.2f%s%s\n", note.cents_per_tenth_mm, 1e3 * note.node_m,
        note.length_caveat.empty() ? "" : "  std ", note.length_caveat.c_str());
  }
  say(common, "report: %s\n", (std::filesystem::path(command.output) / "report.html").c_str());
  return kDone;
}

}  // namespace

Subcommand add_chime(CLI::App& program, CommonOptions& common) {
  auto command = std::make_shared<ChimeCommand>();
  CLI::App* app = program.add_subcommand("chime", "Lengths to cut a set of chimes or bars to, from a fitted one");
  app->add_option("fit", command->fit, "fit.json of klang fit: tubes, rods or bars")->required();
  app->add_option("--notes", command->notes, "Notes of the set: \"D5 E5 G5 A5 B5\"")->required();
  app->add_option("-o,--output", command->output, "Folder for chime.json, cut-list.csv, set.wav and report.html")
      ->required();
  app->add_option("--specimen", command->chime.specimen,
                  "Cut from this specimen's stock; default: for each note the one that sounds nearest to it");
  app->add_option("--a4-hz", command->chime.a4_hz, "Frequency of A4, 300 to 600")->capture_default_str();
  app->add_option("--temperament", command->temperament,
                  "equal, just (from C) or a Scala file of twelve degrees (.scl)")
      ->capture_default_str();
  app->footer(
      "Examples:\n"
      "  klang chime chimes/fit.json --notes \"D5 E5 G5 A5 B5\" -o set\n"
      "  klang chime chimes/fit.json --notes \"C5 E5 G5\" --temperament just --a4-hz 442 -o set");
  return {app,
          [command, &common] { return run_chime(*command, common); },
          {result_kind<fit::ChimeDocument>("chime", "chime.json of `klang chime`")}};
}

}  // namespace klang::apps
