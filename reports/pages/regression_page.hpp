#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"

/// The page of `klang regress check`.
namespace klang::reports::detail {

/// Partials of both as lines over frequency, with the third-octave levels above.
Svg regression_spectrum_figure(const RegressionData& data);

/// How far each partial's frequency and decay lie from the reference, and the tolerance; empty without pairs.
std::optional<Svg> regression_partials_figure(const RegressionData& data);

/// Levels over time and frequency: reference, sound, and the sound's level less the reference's. Empty without levels.
std::optional<Svg> regression_spectrogram_figure(const RegressionData& data);

std::string regression_partial_table(const RegressionData& data);
std::string regression_claim_table(const RegressionData& data);
std::string regression_key_figures(const RegressionData& data);
std::vector<std::string> regression_sentences(const ResultData& data);

}  // namespace klang::reports::detail
