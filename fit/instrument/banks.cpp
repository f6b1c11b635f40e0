#include "fit/instrument/banks.hpp"

#include <nlohmann/json.hpp>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/modal/damping/assumed_damping.hpp"
#include "fit/instrument/fitted_body.hpp"

namespace klang::fit {

AnalysisDocument read_analysis_document(const std::filesystem::path& path) {
  const nlohmann::json json = read_result_json(path);
  if (const std::string kind = text_under(json, "kind"); kind != "analysis")
    throw InputError(path.string(), "is no result of klang analyze", kind, "analysis");
  return read_fields<AnalysisDocument>(json, path.string());
}

ReadBanks bank_of(const AnalysisDocument& analysis) {
  instrument::ModalBank bank;
  bank.name = analysis.name.empty() ? "recording" : analysis.name;
  int n_undamped = 0;
  for (const Partial& partial : analysis.partials) {
    if (!partial.is_ring() || !partial.amplitude || !(*partial.amplitude > 0.0)) continue;
    if (!partial.decay_per_s) ++n_undamped;
    const double assumed_per_s = damping::kAssumedLossFactor * kPi * partial.frequency_hz;
    bank.partials.push_back({partial.frequency_hz, partial.decay_per_s.value_or(assumed_per_s), *partial.amplitude,
                             partial.phase_rad.value_or(0.0), partial.kind == PartialKind::kWeak});
  }
  ReadBanks result{{std::move(bank)}};
  if (n_undamped > 0)
    result.warnings.push_back(damping::assumed_damping_words(std::to_string(n_undamped) + " partial(s)"));
  return result;
}

events::Strike default_strike(const modal::ModalModel& model) {
  const Eigen::RowVector3d low = model.mesh.nodes_m.colwise().minCoeff();
  const Eigen::RowVector3d size = model.mesh.nodes_m.colwise().maxCoeff() - low;
  Eigen::Index thin = 0, along = 0;
  size.minCoeff(&thin);
  size.maxCoeff(&along);
  events::Strike strike;
  strike.shape = events::PulseShape::kGaussian;
  Eigen::Vector3d end = (low + 0.5 * size).transpose();
  end[along] = low[along] + size[along];
  strike.point_m = end;
  strike.impulse_n_s[thin] = 1.0;
  strike.duration_s = 2e-5;
  return strike;
}

ReadBanks read_banks(const std::filesystem::path& path, const std::string& specimen, double rate_hz, Monitor& monitor) {
  const std::string kind = text_under(read_result_json(path), "kind");
  ReadBanks result;
  if (kind == "analysis") {
    if (!specimen.empty()) throw option_error("specimen", "belongs to a fit.json, not to an analysis", specimen);
    result = bank_of(read_analysis_document(path));
  } else if (kind == "fit") {
    const FitDocument fit = read_fit_document(path);
    std::string undamped;
    for (const SpecimenRecord& record : fit.specimens) {
      if (!specimen.empty() && record.name != specimen) continue;
      const FittedBody body = fitted_body(fit, path, record.name, {}, monitor);
      if (!body.decay_per_s) undamped += (undamped.empty() ? "" : ", ") + record.name;
      result.banks.push_back(
          instrument::struck_bank(body.model, body.decay_per_s ? *body.decay_per_s : assumed_decay_per_s(body.model),
                                  default_strike(body.model)));
      result.banks.back().name = record.name;
    }
    if (!undamped.empty()) result.warnings.push_back(damping::assumed_damping_words(undamped));
    if (result.banks.empty()) specimen_of(fit, specimen, path);  // says which there are
  } else {
    throw InputError(path.string(), "holds nothing to play", kind, "an analysis.json or a fit.json");
  }
  for (instrument::ModalBank& bank : result.banks) {
    if (bank.partials.empty()) throw InputError(path.string(), "no partial rings", bank.name, "one or more");
    if (kind == "fit") instrument::normalise(bank, instrument::kPeak, rate_hz, instrument::kPeakWithinS);
  }
  return result;
}

}  // namespace klang::fit
