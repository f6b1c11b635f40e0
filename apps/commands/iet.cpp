#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>

#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "fit/elastic/budget.hpp"
#include "fit/iet/iet.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct IetOptions {
  std::string specimens, output;
};

/// Specimens whose recordings are the same bytes: a line copied and not changed.
std::vector<std::string> same_recordings(const std::vector<fit::IetSpecimen>& specimens,
                                         const std::filesystem::path& folder) {
  constexpr std::size_t kNamed = 3;
  std::map<std::string, std::vector<std::string>> names;
  for (const fit::IetSpecimen& specimen : specimens)
    names[input_file(folder / specimen.recording).sha256].push_back(specimen.specimen);
  std::vector<std::string> warnings;
  for (const auto& [hash, same] : names) {
    if (same.size() < 2) continue;
    std::string text = same[0];
    for (std::size_t i = 1; i < std::min(same.size(), kNamed); ++i) text += ", " + same[i];
    if (same.size() > kNamed) text += " and " + std::to_string(same.size() - kNamed) + " more";
    warnings.push_back(text + " have one and the same recording: their spread says nothing of specimens");
  }
  return warnings;
}

void print_summary(const fit::IetDocument& document, const CommonOptions& common) {
  for (const fit::IetRow& row : document.specimens) {
    if (row.flexural_hz) {
      say(common, "%-16s %10.2f Hz", row.given.specimen.c_str(), *row.flexural_hz);
    } else {
      say(common, "%-16s %13s", row.given.specimen.c_str(), "no frequency");
    }
    if (row.e_e1876_pa) say(common, "  E %9.5g Pa (full model %9.5g)", *row.e_e1876_pa, row.e_model_pa.value_or(0.0));
    if (row.g_e1876_pa) say(common, "  G %9.5g Pa", *row.g_e1876_pa);
    say(common, "%s%s%s\n",
        row.implausible ? "  implausible"
        : row.outlier   ? "  outlier"
                        : "",
        row.remark.empty() ? "" : "  ", row.remark.c_str());
  }
  for (const fit::IetSummary& line : document.summary) {
    say(common, "%s %-20s %.6g", to_text(line.shape).c_str(), line.quantity.c_str(), line.mean);
    if (line.std && *line.std > 0.0) say(common, " ± %.2g", *line.std);
    say(common, "  (n = %d%s%s)\n", line.n, line.std ? ", " : "", line.std ? fit::kWithoutTolerances : "");
  }
}

int run_iet(const IetOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  const std::filesystem::path path = options.specimens;
  const std::vector<fit::IetSpecimen> specimens = fit::read_iet_specimens(path);
  OutputDirectory out(options.output);
  std::vector<std::filesystem::path> inputs{path};
  for (const fit::IetSpecimen& specimen : specimens) inputs.push_back(path.parent_path() / specimen.recording);
  fit::IetDocument document;
  document.name = path.stem().string();
  document.specimens = fit::measure_specimens(specimens, path.parent_path(), monitor);
  std::size_t n_measured = 0;
  for (const fit::IetRow& row : document.specimens) n_measured += row.flexural_hz ? 1 : 0;
  if (n_measured == 0)
    throw NumericalError(options.specimens +
                         ": no specimen's frequencies were found: " + document.specimens.front().remark);
  document.summary = fit::summary_of(document.specimens);
  document.header = make_header("iet", "done", common, nlohmann::json::object(), inputs);
  document.header.warnings = same_recordings(specimens, path.parent_path());
  for (const fit::IetRow& row : document.specimens)
    if (!row.remark.empty()) document.header.warnings.push_back(row.given.specimen + ": " + row.remark);
  const nlohmann::json json = json_of(document);
  write_file(out.staging() / "iet.json", json_text(json));
  write_file(out.staging() / "iet.csv", csv_table(document.specimens));
  const auto report = reports::write_report(out.staging() / "iet.json", {}, monitor);
  monitor.throw_if_stopped();
  out.commit();
  write_json(common, json);
  for (const std::string& warning : document.header.warnings) warn(warning);
  for (const std::string& warning : report.warnings) warn(warning);
  print_summary(document, common);
  say(common, "report: %s\n", (std::filesystem::path(options.output) / "report.html").c_str());
  return kDone;
}

}  // namespace

Subcommand add_iet(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<IetOptions>();
  CLI::App* app =
      program.add_subcommand("iet", "Bars, rods and discs by impulse excitation (ASTM E1876), beside the full model");
  app->add_option("specimens", options->specimens, "CSV file, a line for each specimen (docs/iet.md)")->required();
  app->add_option("-o,--output", options->output, "Folder for iet.csv, iet.json and report.html")->required();
  app->footer("Example:\n  klang iet bars.csv -o bars-report");
  return {app,
          [options, &common] { return run_iet(*options, common); },
          {result_kind<fit::IetDocument>("iet", "iet.json of `klang iet`")}};
}

}  // namespace klang::apps
