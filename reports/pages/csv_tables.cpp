#include "core/foundation/base/errors.hpp"
#include "reports/pages/page.hpp"

namespace klang::reports::detail {
namespace {

/// Quoted where needed (RFC 4180). A cell that a spreadsheet would take for a formula is text already: names
/// only.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}
std::string cell(const Number& value) { return value ? to_text(*value) : std::string(); }
std::string cell(double value) { return to_text(value); }
std::string cell(int value) { return std::to_string(value); }
std::string cell(const std::optional<int>& value) { return value ? std::to_string(*value) : std::string(); }
std::string cell(bool value) { return value ? "true" : "false"; }

template <class First, class... Rest>
std::string row(const First& first, const Rest&... rest) {
  std::string text = cell(first);
  ((text += "," + cell(rest)), ...);
  return text + "\n";
}

std::string estimate_row(const std::string& model, const Estimate& e) {
  const Number low = e.ci95 ? Number((*e.ci95)[0]) : Number(), high = e.ci95 ? Number((*e.ci95)[1]) : Number();
  std::string text = row(e.name, e.value, e.std, low, high, e.identifiable, e.start_value, e.derived, e.why);
  return model.empty() ? text : cell(model) + "," + text;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> csv_tables(const ResultData& data) {
  std::vector<std::pair<std::string, std::string>> tables;
  if (data.kind == "modes") {
    std::string text = "index,frequency_hz,relative_residual\n";
    for (const Mode& mode : data.specimens.front().modes)
      text += row(mode.index, mode.frequency_hz, mode.relative_residual);
    tables.emplace_back("modes.csv", std::move(text));
    return tables;
  }
  std::string partials =
      "specimen,frequency_hz,frequency_std_hz,decay_per_s,decay_std_per_s,amplitude,amplitude_std,phase_rad,"
      "phase_std_rad,"
      "matched_mode\n";
  for (const Specimen& specimen : data.specimens) {
    for (const Partial& p : specimen.partials) {
      partials += row(specimen.name, p.frequency_hz, p.frequency_std_hz, p.decay_per_s, p.decay_std_per_s, p.amplitude,
                      p.amplitude_std, p.phase_rad, p.phase_std_rad, p.matched_mode);
    }
  }
  tables.emplace_back("partials.csv", std::move(partials));
  if (data.kind != "fit") return tables;

  std::string parameters = "name,value,std,ci95_low,ci95_high,identifiable,start_value,derived,why\n";
  for (const Estimate& e : data.parameters) parameters += estimate_row("", e);
  tables.emplace_back("parameters.csv", std::move(parameters));

  std::string matches =
      "specimen,mode_index,frequency_hz,frequency_std_hz,model_frequency_hz,deviation_cents,decay_per_s,"
      "decay_std_per_s,"
      "model_decay_per_s,radiation_decay_per_s,mount_decay_per_kg,model_frequency_std_hz\n";
  for (const Match& m : data.matches) {
    matches += row(m.specimen, m.mode_index, m.frequency_hz, m.frequency_std_hz, m.model_frequency_hz,
                   m.deviation_cents, m.decay_per_s, m.decay_std_per_s, m.model_decay_per_s, m.radiation_decay_per_s,
                   m.mount_decay_per_kg, m.model_frequency_std_hz);
  }
  tables.emplace_back("matches.csv", std::move(matches));

  std::string predicted = "specimen,mode_index,frequency_hz,decay_per_s\n";
  for (const Predicted& p : data.predicted) predicted += row(p.specimen, p.mode_index, p.frequency_hz, p.decay_per_s);
  tables.emplace_back("predicted.csv", std::move(predicted));

  std::string damping =
      "model,name,value,std,ci95_low,ci95_high,identifiable,start_value,derived,why,aicc,aicc_weight,rms_"
      "relative_residual\n";
  for (const DampingModel& model : data.damping) {
    for (const Estimate& e : model.parameters) {
      std::string text = estimate_row(model.model, e);
      text.pop_back();
      damping += text + "," + row(model.aicc, model.aicc_weight, model.rms_relative_residual);
    }
  }
  tables.emplace_back("damping.csv", std::move(damping));
  return tables;
}

}  // namespace klang::reports::detail
