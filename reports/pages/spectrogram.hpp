#pragma once
#include <array>
#include <string>
#include <vector>

#include "core/sound/audio/signal.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/svg_plot.hpp"

namespace klang::reports::detail {

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

/// What stands on and around a spectrogram.
struct SpectrogramSpec {
  std::string name;  ///< of what rings
  SpectrogramRange range;
  std::vector<double> strikes_s;                            ///< marked on the time axis
  std::vector<double> breaks_s;                             ///< a line from top to bottom, with a cross above it
  std::string recorded_words = "Recorded", computed_words;  ///< titles of the panels
  Ridges ridges;
  bool small = false;  ///< fewer pixels: many share a page
};

/// Recorded, computed and what lies between them on one scale of level. The third panel is the difference of
/// the magnitudes | |recorded| - |computed| |: phases do not enter, so that it shows missing or superfluous
/// energy only. With no computed sound (no frames) there is one wide panel. Level: 20 log10 of the amplitude of
/// a sine that gives it, full scale = 0 dB.
Svg spectrogram_figure(const audio::Signal& recorded, const audio::Signal& computed, const SpectrogramSpec& spec);

/// Where the panels stand across the figure, in per cent of its width: left edge and width.
std::vector<std::array<double, 2>> spectrogram_panels(bool compared);

}  // namespace klang::reports::detail
