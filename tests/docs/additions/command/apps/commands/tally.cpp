#include <CLI/CLI.hpp>
#include <memory>

#include "apps/kit/command.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"
#include "validate/claim/tally_document.hpp"

namespace klang::apps {
namespace {

struct TallyOptions {
  int n_taps = 0;
  std::string output;
};

int run_tally(const TallyOptions& options, const CommonOptions& common) {
  OutputDirectory out(options.output);
  validate::TallyDocument document;
  document.header = make_header("tally", "done", common, nlohmann::json::object(), {});
  document.n_taps = options.n_taps;
  const nlohmann::json json = json_of(document);
  write_file(out.staging() / "tally.json", json_text(json));
  reports::write_report(out.staging() / "tally.json");
  out.commit();
  write_json(common, json);
  return kDone;
}

}  // namespace

Subcommand add_tally(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<TallyOptions>();
  CLI::App* app = program.add_subcommand("tally", "Counts taps");
  app->add_option("taps", options->n_taps, "How many")->required();
  app->add_option("-o,--output", options->output, "Folder")->required();
  app->footer("Example:\n  klang tally 3 -o out");
  return {app, [options, &common] { return run_tally(*options, common); }};
}

}  // namespace klang::apps
