#include <algorithm>
#include <array>
#include <cmath>

#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/regression_figures.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kWidth = 1080, kLeft = 66;
constexpr double kDifferenceDb = 12.0;  // where the difference's colours end

double level_db(const Number& amplitude, double gain_db) {
  return amplitude && *amplitude > 0 ? 20 * std::log10(*amplitude) - gain_db : -400.0;
}

/// Blue for less, red for more, near white for none: indices 0 to 254, 127 in the middle; 255 is grey.
std::array<std::array<std::uint8_t, 3>, 256> difference_palette() {
  std::array<std::array<std::uint8_t, 3>, 256> colours{};
  const std::array<double, 3> low = {28, 78, 156}, middle = {247, 246, 242}, high = {176, 32, 38};
  for (std::size_t i = 0; i < 255; ++i) {
    const double t = (static_cast<double>(i) - 127.0) / 127.0;
    const auto& end = t < 0 ? low : high;
    for (std::size_t c = 0; c < 3; ++c) {
      colours[i][c] = static_cast<std::uint8_t>(std::lround(middle[c] + std::sqrt(std::abs(t)) * (end[c] - middle[c])));
    }
  }
  colours[255] = {214, 214, 212};
  return colours;
}

/// Whether the levels are a matrix of that many bands and times.
bool is_matrix(const std::vector<std::vector<double>>& levels, std::size_t n_bands, std::size_t n_times) {
  return levels.size() == n_bands &&
         std::all_of(levels.begin(), levels.end(), [&](const auto& row) { return row.size() == n_times; });
}

/// A matrix [band][time] as pixels, the highest band on top.
template <class Index>
IndexedImage image_of(const std::vector<std::vector<double>>& levels, Index&& index) {
  IndexedImage image{static_cast<int>(levels.front().size()), static_cast<int>(levels.size()), {}};
  for (std::size_t row = levels.size(); row-- > 0;) {
    for (std::size_t t = 0; t < levels[row].size(); ++t) image.pixels.push_back(index(row, t));
  }
  return image;
}

struct ColourBar {
  double left, top, height, low, high;
  const char* unit;
};

void colour_bar(Svg& svg, const ColourBar& bar, const std::array<std::array<std::uint8_t, 3>, 256>& palette, int last) {
  const auto& [left, top, height, low, high, unit] = bar;
  IndexedImage ramp{1, last + 1, {}};
  for (int i = last; i >= 0; --i) ramp.pixels.push_back(static_cast<std::uint8_t>(i));
  svg.image(left, top, 12, height, data_uri("image/png", png_bytes(ramp, palette)));
  svg.rect(left, top, 12, height, "axis");
  for (const Tick& tick : axis_ticks({"", Scale::kLinear, low, high, true}, 6)) {
    const double at = top + height * (high - tick.value) / (high - low);
    svg.line(left + 12, at, left + 16, at, "axis");
    svg.text(left + 20, at + 4, tick.label, "muted small");
  }
  svg.text(left + 12, top - 12, unit, "muted small", Anchor::kMiddle);
}

}  // namespace

Svg regression_spectrum_figure(const validate::RegressionDocument& data) {
  constexpr double kHeight = 440, kTop = 34, kRight = 24;
  std::vector<double> frequencies, levels;
  for (const validate::PartialRecord& p : data.partials) {
    for (const auto& [side, gain] : {std::pair{&p.reference, 0.0}, std::pair{&p.sound, data.gain_db.value_or(0)}}) {
      if (!*side) continue;
      frequencies.push_back((*side)->frequency_hz);
      levels.push_back(level_db((*side)->amplitude, gain));
    }
  }
  for (const validate::ThirdComparison& third : data.third_octaves) {
    if (third.difference_db)
      levels.push_back(std::min(measured(third.reference_db).value_or(0), measured(third.sound_db).value_or(0)));
  }
  const double highest = levels.empty() ? 0 : *std::max_element(levels.begin(), levels.end());
  const double lowest = levels.empty() ? -80 : std::max(*std::min_element(levels.begin(), levels.end()), highest - 100);
  const double floor = 10 * std::floor((lowest - 8) / 10), ceiling = 10 * std::ceil((highest + 6) / 10);
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.08);
  Svg svg(kWidth, kHeight,
          "Levels of the partials of the reference and of the sound over frequency, and third-octave levels of both.");
  Frame frame(svg, {kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48}, x,
              {"Level at the strike [dB re full scale]", Scale::kLinear, floor, ceiling});
  frame.draw_axes(10, 7);
  for (const bool is_sound : {false, true}) {
    for (const validate::ThirdComparison& third : data.third_octaves) {
      const Number level = measured(is_sound ? third.sound_db : third.reference_db);
      if (!third.difference_db || !level) continue;
      const double edge = std::pow(10.0, 0.05);
      frame.curve({{third.centre_hz / edge, *level}, {third.centre_hz * edge, *level}},
                  is_sound ? "s1 mid dash2" : "s0 mid");
    }
  }
  for (const validate::PartialRecord& p : data.partials) {
    // The two stand side by side where they agree.
    for (const bool is_sound : {false, true}) {
      const auto& side = is_sound ? p.sound : p.reference;
      if (!side) continue;
      const double level = std::max(level_db(side->amplitude, is_sound ? data.gain_db.value_or(0) : 0.0), floor);
      const double at = frame.x(side->frequency_hz) + (is_sound ? 3 : -3);
      svg.line(at, frame.y(floor), at, frame.y(level), is_sound ? "s1 thick" : "s0 thick");
      svg.marker(is_sound ? 1 : 0, at, frame.y(level), 4,
                 std::string(is_sound ? "sound" : "reference") + ": " +
                     hertz(side->frequency_hz, side->frequency_std_hz) + ", " + fixed(level, 1) + " dB",
                 !(p.reference && p.sound));
    }
  }
  svg.marker(0, kLeft + 8, kTop - 16, 4, "");
  svg.text(kLeft + 18, kTop - 12, "Reference", "small");
  svg.marker(1, kLeft + 98, kTop - 16, 4, "");
  svg.text(kLeft + 108, kTop - 12, "Sound, at the reference’s level", "small");
  svg.text(kWidth - kRight, kTop - 12, "lines: mean third-octave levels; hollow: in one only", "muted small",
           Anchor::kEnd);
  return svg;
}

std::optional<Svg> regression_partials_figure(const validate::RegressionDocument& data) {
  constexpr double kHeight = 470, kTop = 34, kRight = 24, kPanel = 176, kGap = 30;
  std::vector<double> frequencies;
  for (const validate::PartialRecord& p : data.partials) {
    if (p.reference && p.sound) frequencies.push_back(p.reference->frequency_hz);
  }
  if (frequencies.empty()) return {};
  Svg svg(kWidth, kHeight,
          "Deviation of each partial's frequency in cents and of its decay in per cent, with tolerances.");
  for (const bool is_decay : {false, true}) {
    const double top = kTop + (is_decay ? kPanel + kGap : 0);
    const auto deviation = [&](const validate::PartialRecord& p) {
      return is_decay ? (p.decay_change ? Number(100 * *p.decay_change) : Number()) : p.cents;
    };
    const auto tolerance = [&](const validate::PartialRecord& p) {
      return (is_decay ? 100 : 1) * (is_decay ? p.decay_tolerance : p.cents_tolerance).value_or(0);
    };
    // Scaled by the narrow tolerances and the deviations: a partial that nobody knows shall not flatten the rest.
    std::vector<double> tolerances;
    double largest = 0;
    for (const validate::PartialRecord& p : data.partials) {
      if (!deviation(p)) continue;
      tolerances.push_back(tolerance(p));
      largest = std::max(largest, std::abs(*deviation(p)));
    }
    if (tolerances.empty()) continue;
    std::nth_element(tolerances.begin(), tolerances.begin() + static_cast<std::ptrdiff_t>(tolerances.size() / 2),
                     tolerances.end());
    const double range = 1.2 * std::max(largest, 1.5 * tolerances[tolerances.size() / 2]);
    AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.08);
    x.labelled = is_decay;
    Frame frame(svg, {kLeft, top, kWidth - kLeft - kRight, kPanel}, x,
                {is_decay ? "Decay [%]" : "Frequency [cents]", Scale::kLinear, -range, range});
    frame.draw_axes(10, 5);
    svg.line(frame.left(), frame.y(0), frame.right(), frame.y(0), "axis");
    for (const validate::PartialRecord& p : data.partials) {
      if (!deviation(p)) continue;
      const double at = p.reference->frequency_hz, allowed = tolerance(p);
      frame.error_bar(at, std::max(-allowed, -range), std::min(allowed, range), "rule mid");
      const bool out = std::abs(*deviation(p)) > allowed;
      svg.marker(out ? 1 : 0, frame.x(at), frame.y(*deviation(p)), out ? 6 : 4.5,
                 hertz(at) + ": " + fixed(*deviation(p), 2) + (is_decay ? " %" : " cents") + ", tolerance " +
                     rounded(allowed, 3) + (p.note.empty() ? "" : "; " + p.note),
                 !p.note.empty());
    }
  }
  svg.text(kLeft, kTop - 12, "Sound less reference; bars: tolerance", "strong");
  return svg;
}

std::optional<Svg> regression_spectrogram_figure(const validate::RegressionDocument& data) {
  constexpr double kHeight = 380, kTop = 40, kPlotHeight = 286, kGap = 16, kBar = 58;
  const auto& reference = data.spectrogram.reference_db;
  const auto& sound = data.spectrogram.sound_db;
  if (reference.empty() || reference.front().empty() || data.spectrogram.bands_hz.size() < 2 ||
      data.spectrogram.times_s.empty() || !is_matrix(reference, reference.size(), reference.front().size()) ||
      !is_matrix(sound, reference.size(), reference.front().size()))
    return {};
  double low = 1e300, high = -1e300;
  for (const auto* levels : {&reference, &sound}) {
    for (const auto& row : *levels) {
      for (const double level : row) low = std::min(low, level), high = std::max(high, level);
    }
  }
  high = 5 * std::ceil(high / 5), low = std::max(5 * std::floor(low / 5), high - 80);
  if (!(low < high) || !std::isfinite(high - low)) return {};
  const double step_s =
      data.spectrogram.times_s.size() > 1 ? data.spectrogram.times_s[1] - data.spectrogram.times_s[0] : 0.01;
  const double last_s = data.spectrogram.times_s.back() - data.spectrogram.times_s.front() + step_s;
  const double half_band = std::sqrt(data.spectrogram.bands_hz[1] / data.spectrogram.bands_hz[0]);
  const AxisSpec y{"Frequency [kHz]", Scale::kLog, data.spectrogram.bands_hz.front() / half_band / 1000,
                   data.spectrogram.bands_hz.back() * half_band / 1000, true};
  const double panel = (kWidth - kLeft - 2 * kBar - 2 * kGap) / 3;
  Svg svg(kWidth, kHeight, "Levels over time and frequency of the reference and of the sound, and their difference.");
  const auto palette = difference_palette();
  const char* titles[] = {"Reference", "Sound, at the reference’s level", "Sound less reference"};
  for (int i = 0; i < 3; ++i) {
    const double left = kLeft + i * (panel + kGap) + (i == 2 ? kBar : 0);
    const auto& shown = i == 0 ? reference : sound;
    const IndexedImage image = image_of(reference, [&](std::size_t band, std::size_t t) {
      if (i < 2) {
        const double level = std::isfinite(shown[band][t]) ? shown[band][t] : low;
        return static_cast<std::uint8_t>(std::lround(255 * std::clamp((level - low) / (high - low), 0.0, 1.0)));
      }
      const double difference = sound[band][t] - reference[band][t];
      if (std::isnan(difference)) return std::uint8_t{255};
      return static_cast<std::uint8_t>(127 + std::lround(127 * std::clamp(difference / kDifferenceDb, -1.0, 1.0)));
    });
    svg.image(left, kTop, panel, kPlotHeight,
              data_uri("image/png", png_bytes(image, i == 2 ? palette : heat_palette())));
    AxisSpec axis = y;
    axis.labelled = i == 0;
    Frame frame(svg, {left, kTop, panel, kPlotHeight}, {"Time from the onset [s]", Scale::kLinear, 0, last_s, true},
                axis);
    frame.draw_axes(5, 6, false, false);
    svg.text(left, kTop - 12, titles[i], "strong");
  }
  colour_bar(svg, {kLeft + 2 * panel + kGap + 8, kTop, kPlotHeight, low, high, "dB"}, heat_palette(), 255);
  colour_bar(svg, {kWidth - kBar + 8, kTop, kPlotHeight, -kDifferenceDb, kDifferenceDb, "dB"}, palette, 254);
  return svg;
}

}  // namespace klang::reports::detail
