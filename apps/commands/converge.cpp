#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"
#include "reports/scenes/field_files.hpp"
#include "validate/studies/study_document.hpp"

namespace klang::apps {
namespace {

struct ConvergeCommand {
  std::string study;
  std::string output;
  bool no_pictures = false;
  validate::StudyOptions options;
};

void print_series(const validate::Study& study, const CommonOptions& common) {
  for (const validate::Series& series : study.series) {
    say(common, "%s %-20s %s\n",
        !series.counts  ? "        "
        : series.passed ? "passed  "
                        : "NOT MET ",
        series.id.c_str(), series.verdict.c_str());
  }
  for (const validate::Claim& claim : study.claims) {
    say(common, "%s %-20s %.6g", claim.passed ? "passed  " : "NOT MET ", claim.name.c_str(), claim.measured);
    if (claim.reference) say(common, " (reference %.6g)", *claim.reference);
    say(common, ", tolerance %.2g\n", claim.tolerance);
  }
}

int run_converge(const ConvergeCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  OutputDirectory out(command.output);
  const validate::StudyOptions& options = command.options;
  const validate::Study study = validate::run_study(command.study, options, monitor);

  const nlohmann::json used = {{"levels", options.levels}, {"only", options.only}, {"pictures", !command.no_pictures}};
  const nlohmann::json json = json_of(validate::study_document(
      make_header("study", study.passed() ? "passed" : "not_passed", common, used, {}), study));
  reports::write_fields(study.fields, out.staging());
  write_file(out.staging() / "study.json", json_text(json));
  write_file(out.staging() / "levels.csv", validate::levels_csv(study));
  write_file(out.staging() / "junit.xml",
             validate::junit_xml("klang converge " + study.name, validate::all_claims(study)));
  reports::ReportOptions report_options;
  report_options.pictures = !command.no_pictures;
  const auto report = reports::write_report(out.staging() / "study.json", report_options, monitor);
  monitor.throw_if_stopped();
  out.commit();
  write_json(common, json);

  for (const std::string& warning : report.warnings) warn(warning);
  print_series(study, common);
  say(common, "%s\nreport: %s\n", study.passed() ? "passed" : "NOT PASSED",
      (std::filesystem::path(command.output) / "report.html").c_str());
  return study.passed() ? kDone : kCheckNotPassed;
}

}  // namespace

Subcommand add_converge(CLI::App& program, CommonOptions& common) {
  auto command = std::make_shared<ConvergeCommand>();
  CLI::App* app = program.add_subcommand("converge", "Observed orders of convergence against exact solutions; report");
  const std::vector<std::string> names = validate::study_names();
  app->add_option("study", command->study, "One of: " + word_list(names))
      ->required()
      ->type_name("")
      ->check(CLI::Validator(
          [names](const std::string& name) {
            return std::find(names.begin(), names.end(), name) != names.end()
                       ? std::string()
                       : unknown_word("converge", "unknown study", name, name, names).what();
          },
          ""));
  app->add_option("-o,--output", command->output,
                  "Folder for study.json, report.html, junit.xml, levels.csv, VTK files")
      ->required();
  add_fields(*app, common, command->options, {{"levels"}, {"only"}});
  app->add_flag("--no-pictures", command->no_pictures, "Leave out the VTK pictures");
  app->footer(
      "Examples:\n"
      "  klang converge bem -o bem\n"
      "  klang converge synthesis -o synthesis --json -\n"
      "  klang converge fem --only block --levels 3 -o block\n"
      "Exit code 1: an observed order or an error is outside its band; the page says which.");
  return {app,
          [command, &common] { return run_converge(*command, common); },
          {result_kind<validate::StudyDocument>("study", "study.json of `klang converge`")}};
}

}  // namespace klang::apps
