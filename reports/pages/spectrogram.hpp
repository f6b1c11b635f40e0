#pragma once
#include <string>
#include <vector>

#include "core/sound/audio/signal.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/svg_plot.hpp"

namespace klang::reports::detail {

/// The channel with the most energy, alone.
audio::Signal loudest_channel(const audio::Signal& signal);

struct SpectrogramRange {
  double duration_s = 0, high_hz = 0;
  double low_hz = 0;  ///< > 0: logarithmic axis from there
};

/// How far a picture should reach: all of the sound up to 12 s; from 0 Hz to a quarter above the highest
/// partial.
SpectrogramRange spectrogram_range(const audio::Signal& sound, double highest_partial_hz);

/// Lines over a spectrogram: time [s] and frequency [Hz].
struct Ridges {
  std::vector<std::vector<PlotPoint>> lines;
  double window_s = 0;  ///< of the analysis; 0: two rows' resolution
  bool narrow = false;  ///< drawn thin: there are many
};

/// Recorded, fitted and what lies between them on one scale of level. The third panel is the difference of
/// the magnitudes | |recorded| - |fitted| |: phases do not enter, so that it shows missing or superfluous
/// energy only. With no fitted sound (no frames) there is one wide panel. Level: 20 log10 of the amplitude of
/// a sine that gives it, full scale = 0 dB. Strikes are marked on the time axis.
Svg spectrogram_figure(const std::string& name, const audio::Signal& recorded, const audio::Signal& fitted,
                       const std::vector<double>& strikes_s, const SpectrogramRange& range,
                       const std::string& fitted_words, const Ridges& ridges = {},
                       const std::string& recorded_words = "Recorded");

}  // namespace klang::reports::detail
