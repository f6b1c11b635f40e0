#include "reports/pages/spectrogram.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/sound/audio/stft.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports::detail {
namespace {

/// Amplitudes on the pixels of a panel: rows from high to low frequency, columns in time.
struct Panel {
  int width = 0, height = 0;
  std::vector<float> amplitude;
};

/// Short-time spectra, each pixel the largest amplitude of the bins and frames that fall into it.
Panel analysed(const audio::Signal& sound, const SpectrogramRange& range, int width, int height, double window_s) {
  Panel panel{width, height,
              std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.f)};
  const double rate = sound.sample_rate_hz;
  audio::Signal shown;
  shown.sample_rate_hz = rate;
  const auto n = std::min(sound.n_frames(), static_cast<Eigen::Index>(std::ceil(range.duration_s * rate)));
  shown.samples = sound.samples.topRows(n);
  // Lines about two rows wide, without smearing the strike.
  audio::StftOptions options;
  const auto edge_hz = [&](int from_below) {
    const double t = static_cast<double>(from_below) / height;
    return range.low_hz > 0 ? range.low_hz * std::pow(range.high_hz / range.low_hz, t) : range.high_hz * t;
  };
  const double row_hz = range.high_hz / height, column_s = range.duration_s / width;
  options.window_s = std::min(std::max(window_s > 0 ? window_s : 1 / row_hz, 8 / rate), shown.duration_s());
  options.hop_s = std::max(std::min(column_s, options.window_s / 4), 1 / rate);
  options.padding = window_s > 0 ? 8 : 2;
  if (n < 8) return panel;
  const audio::Stft stft = audio::stft(shown, options);
  const double bin_hz = rate / 2 / static_cast<double>(stft.frequencies_hz.size() - 1);
  const auto n_bins = static_cast<std::ptrdiff_t>(stft.frequencies_hz.size());
  std::size_t first_frame = 0;
  for (int column = 0; column < width; ++column) {
    // Frames whose centres lie in this column, else the nearest one.
    while (first_frame + 1 < stft.times_s.size() && stft.times_s[first_frame] < column * column_s) ++first_frame;
    std::size_t end_frame = first_frame + 1;
    while (end_frame < stft.times_s.size() && stft.times_s[end_frame] < (column + 1) * column_s) ++end_frame;
    for (int row = 0; row < height; ++row) {
      const double low = edge_hz(height - 1 - row), high = edge_hz(height - row);
      const auto first = static_cast<std::ptrdiff_t>(std::floor(low / bin_hz + 0.5));
      const auto last = std::max(first, static_cast<std::ptrdiff_t>(std::floor(high / bin_hz - 0.5)));
      float power = 0;
      for (std::size_t frame = first_frame; frame < end_frame; ++frame) {
        for (std::ptrdiff_t bin = first; bin <= last && bin < n_bins; ++bin) {
          power = std::max(power, stft.power(bin, static_cast<Eigen::Index>(frame)));
        }
      }
      panel.amplitude[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(column)] = std::sqrt(power);
    }
  }
  return panel;
}

double level_db(double amplitude) { return 20 * std::log10(std::max(amplitude, 1e-12)); }

/// In 64 steps, 1 to 1.5 dB each, which nobody sees and which halve the noise's bytes.
IndexedImage coloured(const Panel& panel, double low_db, double high_db) {
  IndexedImage image{panel.width, panel.height, {}};
  image.pixels.reserve(panel.amplitude.size());
  for (const float amplitude : panel.amplitude) {
    const double t = (level_db(amplitude) - low_db) / (high_db - low_db);
    image.pixels.push_back(static_cast<std::uint8_t>(4 * std::lround(63 * std::clamp(t, 0.0, 1.0))));
  }
  return image;
}

}  // namespace

SpectrogramRange spectrogram_range(const audio::Signal& sound, double highest_partial_hz) {
  SpectrogramRange range;
  range.duration_s = std::clamp(sound.duration_s(), 0.02, 12.0);
  const double nyquist = sound.sample_rate_hz / 2;
  range.high_hz = highest_partial_hz > 0 ? std::min(1.25 * highest_partial_hz, nyquist) : std::min(nyquist, 20000.0);
  // Up to a round number.
  const double step = std::pow(10.0, std::floor(std::log10(range.high_hz))) / 10;
  range.high_hz = std::min(std::ceil(range.high_hz / step) * step, nyquist);
  return range;
}

namespace {

constexpr double kWidth = 1080, kLeft = 66, kGap = 18, kBar = 96;

double width_of_panels(int n_panels) { return (kWidth - kLeft - kBar - kGap * (n_panels - 1)) / n_panels; }

/// Levels that the colours span: from the loudest pixel down to the recording's own floor, 60 to 100 dB.
std::array<double, 2> level_range(const std::vector<Panel>& panels) {
  float loudest = 0;
  for (const Panel& panel : panels) {
    for (const float a : panel.amplitude) loudest = std::max(loudest, a);
  }
  std::vector<float> sorted = panels[0].amplitude;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double high_db = 10 * std::ceil(level_db(loudest) / 10);
  return {10 * std::floor(std::clamp(level_db(sorted[sorted.size() / 2]), high_db - 100, high_db - 60) / 10), high_db};
}

void level_bar(Svg& svg, double left, double top, double height, const std::array<double, 2>& range_db) {
  IndexedImage ramp{1, 256, {}};
  for (int i = 255; i >= 0; --i) ramp.pixels.push_back(static_cast<std::uint8_t>(i));
  svg.image(left, top, 14, height, data_uri("image/png", png_bytes(ramp, heat_palette())));
  svg.rect(left, top, 14, height, "axis");
  const auto [low_db, high_db] = range_db;
  for (const Tick& tick : axis_ticks({"", Scale::kLinear, low_db, high_db, true}, 6)) {
    const double at = top + height * (high_db - tick.value) / (high_db - low_db);
    svg.line(left + 14, at, left + 18, at, "axis");
    svg.text(left + 22, at + 4, tick.label, "muted small");
  }
}

}  // namespace

std::vector<std::array<double, 2>> spectrogram_panels(bool compared) {
  const int n_panels = compared ? 3 : 1;
  const double width = width_of_panels(n_panels);
  std::vector<std::array<double, 2>> panels;
  for (int i = 0; i < n_panels; ++i)
    panels.push_back({100.0 / kWidth * (kLeft + i * (width + kGap)), 100.0 / kWidth * width});
  return panels;
}

Svg spectrogram_figure(const audio::Signal& recorded, const audio::Signal& computed, const SpectrogramSpec& spec) {
  constexpr double kHeight = 380, kTop = 34, kPlotHeight = 292;
  const SpectrogramRange& range = spec.range;
  const int n_panels = computed.n_frames() == 0 ? 1 : 3;
  const double panel_width = width_of_panels(n_panels);
  const int columns = n_panels == 1 ? 900 : spec.small ? 270 : 440, rows = spec.small ? 260 : 400;

  std::vector<Panel> panels{analysed(recorded, range, columns, rows, spec.ridges.window_s)};
  if (n_panels == 3) {
    panels.push_back(analysed(computed, range, columns, rows, spec.ridges.window_s));
    Panel difference = panels[0];
    for (std::size_t i = 0; i < difference.amplitude.size(); ++i) {
      difference.amplitude[i] = std::abs(panels[0].amplitude[i] - panels[1].amplitude[i]);
    }
    panels.push_back(std::move(difference));
  }
  const auto [low_db, high_db] = level_range(panels);

  const std::string compared = n_panels == 3 ? "recorded, fitted and their difference" : "the recording";
  Svg svg(kWidth, kHeight,
          "Spectrogram of " + spec.name + ": " + compared + ", " + rounded(range.low_hz / 1000, 3) + " to " +
              rounded(range.high_hz / 1000, 3) + " kHz over " + rounded(range.duration_s, 3) + " s, levels from " +
              fixed(low_db, 0) + " to " + fixed(high_db, 0) + " dB re full scale.");
  const std::string titles[3] = {spec.recorded_words, spec.computed_words, "Difference of magnitudes"};
  for (int i = 0; i < n_panels; ++i) {
    const double left = kLeft + i * (panel_width + kGap);
    svg.image(left, kTop, panel_width, kPlotHeight,
              data_uri("image/png",
                       png_bytes(coloured(panels[static_cast<std::size_t>(i)], low_db, high_db), heat_palette())));
    Frame frame(svg, {left, kTop, panel_width, kPlotHeight}, {"Time [s]", Scale::kLinear, 0, range.duration_s, true},
                {"Frequency [kHz]", range.low_hz > 0 ? Scale::kLog : Scale::kLinear, range.low_hz / 1000,
                 range.high_hz / 1000, i == 0});
    frame.draw_axes(n_panels == 1 ? 10 : 5, 6, false, false);
    svg.text(left, kTop - 12, titles[i], "strong");
    if (i == 0) {
      for (const auto& line : spec.ridges.lines) {
        std::vector<PlotPoint> shown;
        for (const PlotPoint& p : line) shown.push_back({p.x, p.y / 1000});
        frame.curve(shown, spec.ridges.narrow ? "ridge thin" : "ridge");
      }
    }
    for (const double strike : spec.strikes_s) {
      if (strike < 0 || strike > range.duration_s || i == 2) continue;
      const double at = frame.x(strike);
      svg.polyline({{at - 4, kTop - 7}, {at + 4, kTop - 7}, {at, kTop - 1}}, "m1", true);
    }
    for (const double time_s : spec.breaks_s) {
      if (time_s < 0 || time_s > range.duration_s || i == 2) continue;
      const double at = frame.x(time_s);
      svg.begin_group("breaks at " + rounded(time_s, 5) + " s");
      svg.line(at, kTop, at, kTop + kPlotHeight, "alarm thin dash2");
      svg.line(at - 4, kTop - 9, at + 4, kTop - 1, "alarm mid");
      svg.line(at - 4, kTop - 1, at + 4, kTop - 9, "alarm mid");
      svg.end_group();
    }
  }
  level_bar(svg, kWidth - kBar + 24, kTop, kPlotHeight, {low_db, high_db});
  svg.text(kWidth - 4, kTop - 12, "dB re full scale", "muted small", Anchor::kEnd);
  return svg;
}

}  // namespace klang::reports::detail
