#include "validate/regression/regression_document.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::validate {
namespace {

std::optional<ComparedPartial> compared(const std::optional<fit::Partial>& partial) {
  if (!partial) return {};
  return ComparedPartial{*partial};
}

/// Levels to a tenth of a decibel.
std::vector<std::vector<double>> rounded_rows(const Eigen::MatrixXf& levels) {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < levels.rows(); ++i) {
    rows.emplace_back();
    for (Eigen::Index t = 0; t < levels.cols(); ++t)
      rows.back().push_back(std::round(10.0 * static_cast<double>(levels(i, t))) / 10.0);
  }
  return rows;
}

}  // namespace

void RegressionDocument::check(const std::string& place) const {
  for (std::size_t i = 0; i < partials.size(); ++i) {
    if (!partials[i].reference && !partials[i].sound)
      throw InputError(place + ".partials[" + std::to_string(i) + "]", "has neither reference nor sound");
  }
  const LevelsRecord& levels = spectrogram;
  for (const auto& [list, rows] : {std::pair{"reference_db", &levels.reference_db}, {"sound_db", &levels.sound_db}}) {
    const std::string here = place + ".spectrogram." + list;
    for (std::size_t i = 0; i < rows->size(); ++i) {
      const std::string row = here + "[" + std::to_string(i) + "]";
      if ((*rows)[i].size() != levels.times_s.size()) throw InputError(row, "has the wrong length");
      for (const double level : (*rows)[i])
        if (!std::isfinite(level)) throw InputError(row, "not a number");
    }
    if (rows->size() != levels.bands_hz.size()) throw InputError(here, "has the wrong number of bands");
  }
}

RegressionDocument regression_document(ResultHeader header, const RegressionResult& result,
                                       const ReferenceSpectrum& reference) {
  RegressionDocument document;
  document.header = std::move(header);
  document.header.status = result.passed()                              ? "passed"
                           : result.status == RegressionStatus::kJudged ? "not_passed"
                                                                        : "nothing_judged";
  if (!result.reason.empty()) document.header.message = result.reason;
  document.passed = result.passed();
  document.n_failed = result.n_failed();
  document.n_not_judged = result.n_not_judged();
  document.factor = result.factor;
  document.gain_db = result.gain_db;
  document.common_s = result.common_s;
  document.ring_10db_s = result.ring_10db_s;
  document.reference_ring_10db_s = reference.ring_10db_s;
  document.log_spectral_distance_db = result.log_spectral_distance_db;
  document.reference_origin = reference.origin;
  document.reference_takes = reference.n_takes;
  document.claims = result.claims;
  for (const PartialComparison& p : result.partials)
    document.partials.push_back({compared(p.reference), compared(p.sound), p.cents, p.cents_tolerance, p.decay_change,
                                 p.decay_tolerance, p.note});
  document.third_octaves = result.thirds;
  document.spectrogram = {result.times_s, result.bands_hz, rounded_rows(result.reference_db),
                          rounded_rows(result.sound_db)};
  return document;
}

}  // namespace klang::validate
