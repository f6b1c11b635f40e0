#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/note.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/run/fit.hpp"
#include "fit/run/fit_document.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct FitCommand {
  std::string problem;
  std::string output;
  bool no_pictures = false, strict = false;
  double a4_hz = audio::kConcertPitchHz;
  fit::FitOptions fit;
};

std::vector<std::filesystem::path> input_files(const FitCommand& options, const fit::FitProblem& problem) {
  std::vector<std::filesystem::path> files{options.problem};
  files.insert(files.end(), problem.material_files.begin(), problem.material_files.end());
  for (const fit::Specimen& specimen : problem.specimens) {
    files.insert(files.end(), specimen.recordings.begin(), specimen.recordings.end());
    if (specimen.partials) files.push_back(*specimen.partials);
    if (specimen.mesh_file) files.push_back(*specimen.mesh_file);
    if (specimen.shape && !specimen.shape->profile_csv.empty()) files.push_back(specimen.shape->profile_csv);
  }
  return files;
}

/// Sounds and mode shapes of each specimen, under the names that fit.json gives them.
void write_specimen_files(const OutputDirectory& out, const fit::FitResult& result,
                          const std::string& provenance_json) {
  for (const fit::SpecimenResult& specimen : result.specimens) {
    const std::string name = fit::file_stem(specimen.name);
    if (specimen.recorded.n_frames() > 0) {
      audio::write_sound(out.staging() / ("recording-" + name + ".wav"), specimen.recorded);
    }
    if (specimen.fitted.n_frames() > 0) {
      audio::write_sound(out.staging() / ("resynthesis-" + name + ".wav"), specimen.fitted);
    }
    if (specimen.model.n_modes() > 0) {
      modal::write_modal_model(out.staging() / ("modes-" + name + ".vtu"), specimen.model, provenance_json);
    }
  }
}

/// Significant digits with which a value shows two of its standard deviation.
int digits_for(double value, double std) {
  if (!(std > 0.0) || value == 0.0) return 6;
  return std::clamp(static_cast<int>(std::floor(std::log10(std::abs(value) / std))) + 3, 3, 15);
}

/// That many significant digits, zeros at the end too.
std::string digits_text(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%#.*g", digits, value);
  std::string plain = text;
  if (const auto point = plain.find('.'); point + 1 == plain.size() || plain[point + 1] == 'e') plain.erase(point, 1);
  return plain;
}

/// Coloured where standard output is a terminal that wants it (no-color.org).
std::string verdict_words(fit::Verdict verdict) {
  std::string words(to_text(verdict));
  std::transform(words.begin(), words.end(), words.begin(), [](unsigned char c) { return std::toupper(c); });
  const char* plain = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  if (::isatty(STDOUT_FILENO) != 1 || (plain && *plain) || !terminal || std::string(terminal) == "dumb") return words;
  const char* colour = verdict == fit::Verdict::kTrusted    ? "\033[32m"
                       : verdict == fit::Verdict::kDoubtful ? "\033[33m"
                                                            : "\033[31m";
  return colour + words + "\033[0m";
}

void print_parameters(const std::vector<fit::FitParameter>& parameters, const CommonOptions& common) {
  say(common, "%-26s %14s %11s   %-28s %s\n", "parameter", "value", "std", "95 % interval", "verdict");
  for (const fit::FitParameter& p : parameters) {
    if (p.identifiable && p.std && p.ci95) {
      const int digits = digits_for(p.value, *p.std);
      const std::string interval = digits_text((*p.ci95)[0], digits) + " to " + digits_text((*p.ci95)[1], digits);
      say(common, "%-26s %14s %11.2g   %-28s %s%s%s\n", p.name.c_str(), digits_text(p.value, digits).c_str(), *p.std,
          interval.c_str(), std::string(to_text(p.verdict)).c_str(), p.caveat.empty() ? "" : ", ", p.caveat.c_str());
    } else if (p.given) {
      say(common, "%-26s %14.6g %11s   given\n", p.name.c_str(), p.value, "-");
    } else {
      say(common, "%-26s %14.6g %11s   not determined: %s\n", p.name.c_str(), p.value, "-", p.why.c_str());
    }
  }
}

/// The verdict with its evidence; what raises no doubt stands on the page and in fit.json.
void print_judgement(const fit::Judgement& judgement, const CommonOptions& common) {
  say(common, "verdict: %s\n", verdict_words(judgement.verdict).c_str());
  for (const fit::Reason& reason : judgement.reasons) {
    if (reason.weight == fit::Verdict::kTrusted) continue;
    say(common, "  %s: %s%s\n", std::string(to_text(reason.weight)).c_str(),
        reason.specimen.empty() ? "" : (reason.specimen + ": ").c_str(), reason.text.c_str());
  }
}

/// The partials' notes by another A4 than the concert's.
void name_notes(fit::FitDocument& document, double a4_hz) {
  for (fit::SpecimenRecord& specimen : document.specimens) {
    for (fit::PartialRecord& partial : specimen.partials) {
      const audio::NearestNote note = audio::nearest_note(partial.frequency_hz, a4_hz);
      partial.note = note.name;
      partial.cents = note.cents;
    }
  }
}

int run_fit_command(const FitCommand& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  options.fit.validate();
  const fit::FitProblem problem = fit::read_fit_problem(options.problem);
  OutputDirectory out(options.output);
  fit::FitOptions fit_options = options.fit;
  const fit::FitResult result = fit::run_fit(problem, fit_options, monitor);
  if (!result.usable()) throw NumericalError(options.problem + ": " + to_text(result.status) + ": " + result.message);

  const nlohmann::json used = {{"gate_cents", fit_options.gate_cents},
                               {"model_std_cents", fit_options.model_std_cents},
                               {"robust", fit_options.robust},
                               {"n_modes", fit_options.n_modes},
                               {"a4_hz", options.a4_hz}};
  fit::FitDocument document = fit::fit_document(
      problem, result, make_provenance(common.command_line, common.seed, used, input_files(options, problem)));
  name_notes(document, options.a4_hz);
  const nlohmann::json json = json_of(document);
  write_specimen_files(out, result, json["provenance"].dump());
  write_file(out.staging() / "fit.json", json_text(json));
  reports::ReportOptions report_options;
  report_options.pictures = !options.no_pictures;
  const auto report = reports::write_report(out.staging() / "fit.json", report_options, monitor);
  monitor.throw_if_stopped();
  out.commit();
  write_json(common, json);

  for (const std::string& warning : result.warnings) warn(warning);
  for (const std::string& warning : report.warnings) warn(warning);
  print_parameters(result.parameters, common);
  print_judgement(result.judgement, common);
  if (!result.damping.model.empty()) say(common, "damping: %s fits best (AICc)\n", result.damping.model.c_str());
  for (const fit::SpecimenResult& specimen : result.specimens) {
    say(common, "%s%s: rms %.2f cents, worst %.2f cents, %zu partials unmatched\n", specimen.name.c_str(),
        specimen.predicted ? " (predicted, no part of the fit)" : "", specimen.rms_deviation_cents,
        specimen.max_deviation_cents, specimen.unmatched_partials.size());
  }
  say(common, "report: %s\n", (std::filesystem::path(options.output) / "report.html").c_str());
  return options.strict && result.judgement.verdict != fit::Verdict::kTrusted ? kCheckNotPassed : kDone;
}

}  // namespace

Subcommand add_fit(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<FitCommand>();
  CLI::App* app = program.add_subcommand("fit", "Material parameters from recordings, with intervals and a report");
  app->add_option("specimen", options->problem, "What was struck, recorded and is to be found (TOML, docs/specimen.md)")
      ->required();
  app->add_option("-o,--output", options->output, "Folder for fit.json, report.html, figures, sounds and mode shapes")
      ->required();
  add_fields(*app, common, options->fit, {{"gate_cents"}, {"model_std_cents"}, {"n_modes", "--modes"}});
  app->add_flag("!--least-squares", options->fit.robust, "Plain least squares instead of a robust loss");
  app->add_option("--a4-hz", options->a4_hz, "Frequency of A4, by which the partials have their notes, 300 to 600")
      ->capture_default_str();
  app->add_flag("--strict", options->strict, "Exit code 1 unless the verdict is \"trusted\"");
  app->add_flag("--no-pictures", options->no_pictures, "Leave out the pictures of mode shapes");
  app->footer("Example:\n  klang fit specimen.toml -o result\n\n" + fit::specimen_schema_markdown());
  return {app,
          [options, &common] { return run_fit_command(*options, common); },
          {result_kind<fit::FitDocument>("fit", "fit.json of `klang fit`")}};
}

}  // namespace klang::apps
