#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fit/run/fit_document.hpp"
#include "reports/kit/svg_plot.hpp"

/// The plots of a fit that need its numbers only.
namespace klang::reports::detail {

/// A specimen's rows of the result, by its name.
struct SpecimenRows {
  std::vector<fit::MatchRecord> matches;        ///< by rising measured frequency
  std::vector<fit::PredictedRecord> predicted;  ///< by rising frequency
  std::vector<fit::PredictedRecord> unheard;    ///< without a partial; the partner of a matched twin is not one
  std::vector<fit::PartialRecord> unmatched;    ///< partials without a mode
};
SpecimenRows rows_of(const fit::FitDocument& data, const fit::SpecimenRecord& specimen);

std::vector<std::string> names_of(const fit::FitDocument& data);

/// Measured (left rungs) against model (right rungs) frequencies of up to eight specimens; residuals in cents
/// beside.
Svg ladder_figure(const fit::FitDocument& data, std::size_t first, std::size_t count);

/// Deviation of every match in cents over frequency; empty without one.
std::optional<Svg> residual_figure(const fit::FitDocument& data);

}  // namespace klang::reports::detail
