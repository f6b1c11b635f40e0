#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"

/// The plots that need the numbers of a result only.
namespace klang::reports::detail {

/// A specimen's rows of the result, by its name.
struct SpecimenRows {
  std::vector<Match> matches;        ///< by rising measured frequency
  std::vector<Predicted> predicted;  ///< by rising frequency
  std::vector<Predicted> unheard;    ///< model modes without a partial; the partner of a matched twin is not one
  std::vector<Partial> unmatched;    ///< partials without a mode
};
SpecimenRows rows_of(const ResultData& data, const Specimen& specimen);

/// Measured (left rungs) against model (right rungs) frequencies of up to eight specimens; residuals in cents
/// beside.
Svg ladder_figure(const ResultData& data, std::size_t first, std::size_t count);

/// Deviation of every match in cents over frequency.
std::optional<Svg> residual_figure(const ResultData& data);

/// Decay over frequency, measured with error bars, and every damping candidate's curve. Empty without a
/// decay.
std::optional<Svg> decay_figure(const ResultData& data);

/// Partials of one recording as lines: level over frequency.
std::optional<Svg> spectrum_figure(const Specimen& specimen);

/// Frequencies of a modes result as one ladder.
std::optional<Svg> modes_figure(const Specimen& specimen);

}  // namespace klang::reports::detail
