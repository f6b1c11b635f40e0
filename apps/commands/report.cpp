#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/tool_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct ReportCommand {
  std::string result;
  bool no_pictures = false;
};

int run_report(const ReportCommand& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  reports::ReportOptions report_options;
  report_options.pictures = !options.no_pictures;
  const auto report = reports::write_report(options.result, report_options, monitor);
  for (const std::string& warning : report.warnings) warn(warning);
  ReportDocument document;
  document.header = make_header("report", "done", common, nlohmann::json::object(), {options.result});
  document.page = report.page.string();
  for (const auto& file : report.files) document.files.push_back(file.string());
  document.header.warnings = report.warnings;
  write_json(common, json_of(document));
  say(common, "%s\n", report.page.c_str());
  return kDone;
}

}  // namespace

Subcommand add_report(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<ReportCommand>();
  CLI::App* app = program.add_subcommand("report", "Rebuild the page and pictures from a result's JSON");
  app->add_option("result", options->result, "fit.json or analysis.json in its folder")->required();
  app->add_flag("--no-pictures", options->no_pictures, "Leave out the pictures of mode shapes");
  app->footer("Example:\n  klang report chimes/fit.json");
  return {app,
          [options, &common] { return run_report(*options, common); },
          {result_kind<ReportDocument>("report", "the result of `klang report`")}};
}

}  // namespace klang::apps
