#include "apps/commands/analyze_responses.hpp"

#include <cmath>
#include <memory>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "fit/frf/response_analysis.hpp"
#include "fit/ringdown/analysis_document.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

fit::AnalysisDocument document_of(const fit::ResponseSet& set, const fit::ResponseAnalysis& analysis,
                                  const ResponsesCommand& options, ResultHeader header) {
  fit::AnalysisDocument document;
  document.header = std::move(header);
  document.header.warnings = analysis.warnings;
  document.name = std::filesystem::path(options.file).stem().string();
  document.n_channels = static_cast<int>(set.n_responses());
  if (set.in_time) document.duration_s = set.abscissa[set.n_lines() - 1] - set.abscissa[0];
  document.explained_energy = analysis.explained_energy;
  std::vector<fit::Partial> plain = fit::without_shapes(analysis.partials);
  fit::name_notes(plain, options.a4_hz);
  document.partials = analysis.partials;
  for (std::size_t i = 0; i < plain.size(); ++i)
    document.partials[i].note = plain[i].note, document.partials[i].cents = plain[i].cents;
  document.a4_hz = options.a4_hz;
  document.responses = analysis.record;
  return document;
}

void print(const fit::AnalysisDocument& document, const CommonOptions& common) {
  say(common, "%14s %10s %12s %10s %10s  %s\n", "frequency_hz", "std_hz", "decay_per_s", "std_per_s", "damping_%",
      document.responses->model_hz.empty() ? "note cents" : "model mode, MAC");
  for (std::size_t k = 0; k < document.partials.size(); ++k) {
    const fit::AnalysisPartial& p = document.partials[k];
    const double decay = p.decay_per_s.value_or(0.0);
    const auto shown = [](const std::optional<double>& std) {
      char text[16] = "-";
      if (std) std::snprintf(text, sizeof text, "%.2g", *std);
      return std::string(text);
    };
    say(common, "%14.4f %10s %12.4f %10s %10.4f  ", p.frequency_hz, shown(p.frequency_std_hz).c_str(), decay,
        shown(p.decay_std_per_s).c_str(), 100.0 * decay / std::hypot(decay, 2 * kPi * p.frequency_hz));
    if (p.model_mode) {
      const auto mode = static_cast<std::size_t>(*p.model_mode);
      say(common, "%d at %.2f Hz, %.3f\n", *p.model_mode, document.responses->model_hz[mode],
          document.responses->mac[k][mode]);
    } else {
      say(common, "%-4s %+5.1f\n", p.note.c_str(), p.cents.value_or(0.0));
    }
  }
}

}  // namespace

int run_analyze_responses(const ResponsesCommand& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  const fit::ResponseSet set = fit::read_responses(options.file);
  fit::ResponseOptions used;
  used.band = options.whole ? fit::whole_band(set) : options.band;
  std::vector<std::filesystem::path> inputs{options.file};
  std::optional<modal::ModalModel> model;
  if (!options.modes.empty()) {
    model = modal::read_modal_model(options.modes);
    inputs.emplace_back(options.modes);
  }
  std::unique_ptr<OutputDirectory> out;
  if (!options.output.empty()) out = std::make_unique<OutputDirectory>(options.output);
  fit::ResponseAnalysis analysis = fit::analyse_responses(set, used, monitor);
  if (!analysis.usable()) throw NumericalError(options.file + ": " + analysis.message);
  if (model) fit::compare_with_model(set, *model, analysis);
  const nlohmann::json header = {
      {"band_hz", {used.band.low_hz, used.band.high_hz}}, {"most_order", used.most_order}, {"a4_hz", options.a4_hz}};
  const fit::AnalysisDocument document =
      document_of(set, analysis, options, make_header("analysis", "ok", common, header, inputs));
  const nlohmann::json json = json_of(document);
  if (out) {
    write_file(out->staging() / "analysis.json", json_text(json));
    for (const std::string& warning : reports::write_report(out->staging() / "analysis.json", {}, monitor).warnings)
      warn(warning);
    monitor.throw_if_stopped();
    out->commit();
  }
  if (!options.csv.empty())
    write_table(options.csv, fit::partial_csv({fit::without_shapes(document.partials), options.file}));
  write_json(common, json);
  for (const std::string& warning : document.header.warnings) warn(warning);
  say(common, "%s: %d %s, %zu poles, %.2f %% explained\n", options.file.c_str(), static_cast<int>(set.n_responses()),
      set.in_time ? "free decays" : "frequency responses", document.partials.size(), 100.0 * analysis.explained_energy);
  print(document, common);
  if (out) say(common, "report: %s\n", (std::filesystem::path(options.output) / "report.html").c_str());
  return kDone;
}

}  // namespace klang::apps
