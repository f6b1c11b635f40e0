#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/sound/audio/signal.hpp"
#include "fit/ringdown/partial_table.hpp"
#include "reports/kit/report_folder.hpp"

namespace klang::reports::detail {

/// Levels of a sound after its strike under a window that starts at its top and falls to 0 (the right half of Hann's), long
/// enough to tell partials apart: a tone that does not decay stands at its amplitude.
struct LevelSpectrum {
  double step_hz = 0;
  std::vector<double> level_db;  ///< of bin k at k step_hz, re full scale; each the largest within the bin
  double window_s = 0;
};
/// The strike at which partials' amplitudes are told, of whatever a file says; 0 without strikes.
double told_strike_s(const std::vector<double>& strikes_s, const std::optional<int>& amplitude_strike);

LevelSpectrum level_spectrum(const audio::Signal& sound, double strike_s, double highest_hz);
/// Levels that were measured at rising frequencies, at even steps from 0 on; NaN below the first.
LevelSpectrum level_spectrum(const std::vector<double>& frequency_hz, const std::vector<double>& level_db);

/// A recording's spectrum with the partials and the model that are to explain it.
struct SpectrumView {
  std::string name;                  ///< of what rings, for labels; may be empty
  audio::Signal recorded, computed;  ///< either may have no frames
  double strike_s = 0;               ///< from where on it is transformed
  std::vector<fit::Partial> partials;
  std::string stem = "partials";  ///< of the figure's files; empty: none
  LevelSpectrum given = {};       ///< of what is no recording: partials stand on it
  std::string axis = "Level [dB re full scale]";
};

/// Where the peak of a partial stands in such a spectrum: 20 log10 of a |sum w(t) exp(-d t)| / sum w(t).
double level_of(const fit::Partial& partial, double window_s);

/// The figure: drawn for print and for a browser without scripts, and its data for the script that zooms and reads; empty without
/// sound and partials. Adds figures/STEM.
std::string spectrum_html(const SpectrumView& view, ReportFolder& folder);

/// Buttons that let the partial with this place in the view's list be heard, alone and left out: a table cell.
std::string hear_cell(std::size_t index, double frequency_hz);

}  // namespace klang::reports::detail
