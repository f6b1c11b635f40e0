#pragma once
#include <optional>

#include "reports/kit/svg_plot.hpp"
#include "validate/regression/regression_document.hpp"

/// The figures of `klang regress check`.
namespace klang::reports::detail {

/// Partials of both as lines over frequency, with the third-octave levels above.
Svg regression_spectrum_figure(const validate::RegressionDocument& data);

/// How far each partial's frequency and decay lie from the reference, and the tolerance; empty without pairs.
std::optional<Svg> regression_partials_figure(const validate::RegressionDocument& data);

/// Levels over time and frequency: reference, sound, and the sound's level less the reference's. Empty without levels.
std::optional<Svg> regression_spectrogram_figure(const validate::RegressionDocument& data);

}  // namespace klang::reports::detail
