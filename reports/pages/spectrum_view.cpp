#include "reports/pages/spectrum_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/sound/audio/fft.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"

namespace klang::reports::detail {
namespace {

using nlohmann::json;

constexpr double kLongestWindowS = 2.0, kFloorDb = 110.0;
constexpr std::size_t kMostBins = 5000;

double window_at(double share) { return 0.5 * (1.0 + std::cos(EIGEN_PI * share)); }

double highest_of(const SpectrumView& view) {
  if (!view.given.level_db.empty()) return view.given.step_hz * static_cast<double>(view.given.level_db.size() - 1);
  double highest = 0;
  for (const fit::Partial& p : view.partials) highest = std::max(highest, p.frequency_hz);
  const double rate = view.recorded.n_frames() > 0 ? view.recorded.sample_rate_hz : view.computed.sample_rate_hz;
  const double nyquist = rate > 0 ? 0.5 * rate : 1.3 * highest;
  return highest > 0 ? std::min(1.2 * highest, nyquist) : std::min(nyquist, 20000.0);
}

/// Tenths of a decibel as whole numbers; what lies far under the loudest is cut off.
json tenths(const std::vector<double>& levels, double floor_db) {
  json list = json::array();
  for (const double level : levels) {
    if (std::isnan(level)) {
      list.push_back(nullptr);
    } else {
      list.push_back(static_cast<int>(std::lround(10 * std::max(level, floor_db))));
    }
  }
  return list;
}

/// Whether the partial stands in the figure at all.
bool stands(const SpectrumView& view, const fit::Partial& p) {
  return !view.given.level_db.empty() || p.amplitude.value_or(0.0) > 0.0;
}

double level_in(const SpectrumView& view, const fit::Partial& p, double window_s) {
  if (view.given.level_db.empty()) return level_of(p, window_s);
  const auto last = static_cast<double>(view.given.level_db.size() - 1);
  return view.given
      .level_db[static_cast<std::size_t>(std::clamp(std::round(p.frequency_hz / view.given.step_hz), 0.0, last))];
}

json partial_data(const SpectrumView& view, double window_s) {
  json list = json::array();
  const auto to_steps = [](double value, double steps) { return std::round(value * steps) / steps; };
  for (const fit::Partial& p : view.partials) {
    json one = {{"f", p.frequency_hz}, {"a", p.amplitude.value_or(0.0)}, {"d", p.decay_per_s.value_or(0.0)}};
    one["p"] = to_steps(p.phase_rad.value_or(0.0), 1e4);
    if (stands(view, p)) one["l"] = to_steps(level_in(view, p, window_s), 100);
    if (!p.note.empty()) one["n"] = p.note + (p.cents ? " " + signed_cents(*p.cents) + " cents" : "");
    list.push_back(std::move(one));
  }
  return list;
}

/// JSON that no tag can end.
std::string data_script(const char* attribute, const json& data) {
  std::string text = data.dump();
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos;) text.replace(at, 2, "<\\/");
  return "<script type=\"application/json\" " + std::string(attribute) + ">" + text + "</script>\n";
}

Svg drawn(const SpectrumView& view, const LevelSpectrum& measured, const LevelSpectrum& model, double window_s,
          double high_hz) {
  constexpr double kHeight = 360, kLeft = 66, kTop = 26;
  std::vector<double> levels;
  double top = -200;
  for (const LevelSpectrum* s : {&measured, &model})
    for (const double level : s->level_db) top = std::max(top, level);
  for (const fit::Partial& p : view.partials)
    if (stands(view, p)) levels.push_back(level_in(view, p, window_s));
  for (const double level : levels) top = std::max(top, level);
  double low = top - 60;
  for (const double level : levels) low = std::min(low, level - 10);
  const AxisSpec y{view.axis, Scale::kLinear, 10 * std::floor(std::max(low, top - kFloorDb) / 10),
                   10 * std::ceil((top + 4) / 10), true};
  Svg svg(kPageWidth, kHeight,
          "Measured spectrum and partials: level over frequency" + (view.name.empty() ? "" : " of " + view.name) +
              ", " + counted(levels.size(), "partial", "partials") + ".");
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48},
              {"Frequency [Hz]", Scale::kLinear, 0, high_hz, true}, y);
  frame.draw_axes(10, 6, false, true);
  const auto curve = [&](const LevelSpectrum& s, const char* classes) {
    std::vector<PlotPoint> points;
    for (std::size_t k = 0; k < s.level_db.size(); ++k) {
      if (std::isnan(s.level_db[k])) continue;
      points.push_back({static_cast<double>(k) * s.step_hz, std::max(s.level_db[k], y.low)});
    }
    if (!points.empty()) frame.curve(points, classes);
  };
  curve(measured, "rule");
  curve(model, "s1 thin");
  std::vector<double> taken;
  for (const fit::Partial& p : view.partials) {
    if (!stands(view, p) || p.frequency_hz > high_hz) continue;
    const double at = frame.x(p.frequency_hz), level = level_in(view, p, window_s);
    svg.line(at, frame.bottom(), at, frame.y(level), "accent");
    svg.marker(0, at, frame.y(level), 3.5, hertz(p.frequency_hz) + ", " + fixed(level, 1) + " dB");
    if (std::any_of(taken.begin(), taken.end(), [&](double other) { return std::abs(other - at) < 46; })) continue;
    taken.push_back(at);
    svg.text(std::clamp(at, frame.left() + 18, frame.right() - 18), frame.y(level) - 8,
             fixed(p.frequency_hz, p.frequency_hz < 1000 ? 1 : 0), "tiny", Anchor::kMiddle);
  }
  return svg;
}

std::string layer(const char* name, const char* words) {
  return "<button type=\"button\" data-layer=\"" + std::string(name) + "\" aria-pressed=\"true\">" + words +
         "</button>";
}

}  // namespace

double told_strike_s(const std::vector<double>& strikes_s, const std::optional<int>& amplitude_strike) {
  if (strikes_s.empty()) return 0.0;
  const int strike = amplitude_strike.value_or(0);
  return strike >= 0 && strike < static_cast<int>(strikes_s.size()) ? strikes_s[static_cast<std::size_t>(strike)]
                                                                    : strikes_s.front();
}

LevelSpectrum level_spectrum(const audio::Signal& sound, double strike_s, double highest_hz) {
  LevelSpectrum result;
  const double rate = sound.sample_rate_hz;
  const auto begin = static_cast<Eigen::Index>(std::lround(std::max(0.0, strike_s) * rate));
  const auto n = std::min(sound.n_frames() - begin, static_cast<Eigen::Index>(kLongestWindowS * rate));
  if (sound.n_frames() == 0 || n < 64) return result;
  Eigen::VectorXd x = sound.samples.col(0).segment(begin, n);
  double sum = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double w = window_at(static_cast<double>(i) / static_cast<double>(n));
    x[i] *= w;
    sum += w;
  }
  const Eigen::Index size = audio::good_fft_size(2 * n);
  const Eigen::VectorXcd spectrum = audio::real_spectrum(x, size);
  const double fine_hz = rate / static_cast<double>(size);
  const auto n_fine = std::min(spectrum.size(), static_cast<Eigen::Index>(highest_hz / fine_hz) + 1);
  const auto per_bin = std::max<Eigen::Index>(
      1, (n_fine + static_cast<Eigen::Index>(kMostBins) - 1) / static_cast<Eigen::Index>(kMostBins));
  result.window_s = static_cast<double>(n) / rate;
  result.step_hz = fine_hz * static_cast<double>(per_bin);
  for (Eigen::Index k = 0; k < n_fine; k += per_bin) {
    const Eigen::Index from = std::max<Eigen::Index>(0, k - per_bin / 2);
    const Eigen::Index count = std::min(per_bin, n_fine - from);
    const double largest = spectrum.segment(from, count).cwiseAbs().maxCoeff();
    result.level_db.push_back(20 * std::log10(std::max(2 * largest / sum, 1e-12)));
  }
  return result;
}

LevelSpectrum level_spectrum(const std::vector<double>& frequency_hz, const std::vector<double>& level_db) {
  LevelSpectrum result;
  if (frequency_hz.size() < 2 || frequency_hz.size() != level_db.size()) return result;
  const std::size_t n = frequency_hz.size();
  result.step_hz = (frequency_hz.back() - frequency_hz.front()) / static_cast<double>(n - 1);
  const auto n_steps = static_cast<std::size_t>(std::min(1e5, frequency_hz.back() / result.step_hz + 1e-6));
  std::size_t right = 1;
  for (std::size_t k = 0; k <= n_steps; ++k) {
    const double f = static_cast<double>(k) * result.step_hz;
    while (right + 1 < n && frequency_hz[right] < f) ++right;
    const double share = (f - frequency_hz[right - 1]) / (frequency_hz[right] - frequency_hz[right - 1]);
    result.level_db.push_back(share < -1e-6 ? std::numeric_limits<double>::quiet_NaN()
                                            : std::lerp(level_db[right - 1], level_db[right], std::min(share, 1.0)));
  }
  return result;
}

double level_of(const fit::Partial& partial, double window_s) {
  constexpr int kSteps = 2000;
  double whole = 0, heard = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double share = (i + 0.5) / kSteps, w = window_at(share);
    whole += w;
    heard += w * std::exp(-partial.decay_per_s.value_or(0.0) * share * window_s);
  }
  return 20 * std::log10(std::max(partial.amplitude.value_or(0.0) * heard / whole, 1e-12));
}

std::string spectrum_html(const SpectrumView& view, ReportFolder& folder) {
  const double high_hz = highest_of(view);
  const LevelSpectrum measured =
      view.given.level_db.empty() ? level_spectrum(view.recorded, view.strike_s, high_hz) : view.given;
  const LevelSpectrum model = level_spectrum(view.computed, view.strike_s, high_hz);
  const bool partials_stand =
      std::any_of(view.partials.begin(), view.partials.end(), [&](const fit::Partial& p) { return stands(view, p); });
  if (measured.level_db.empty() && !partials_stand) return {};
  const double window_s = measured.window_s > 0 ? measured.window_s
                          : model.window_s > 0  ? model.window_s
                                                : kLongestWindowS;
  const Svg svg = drawn(view, measured, model, window_s, high_hz);
  if (!view.stem.empty()) folder.add_figure(view.stem, svg);
  double top = -200;
  for (const LevelSpectrum* s : {&measured, &model})
    for (const double level : s->level_db) top = std::max(top, level);
  json data = {{"high_hz", high_hz}, {"axis", view.axis}};
  if (!measured.level_db.empty())
    data["measured"] = {{"step", measured.step_hz}, {"level", tenths(measured.level_db, top - kFloorDb)}};
  if (!model.level_db.empty())
    data["model"] = {{"step", model.step_hz}, {"level", tenths(model.level_db, top - kFloorDb)}};
  const std::string layers = (measured.level_db.empty() ? "" : layer("measured", "Measured")) +
                             (model.level_db.empty() ? "" : layer("model", "Model")) +
                             (view.partials.empty() ? "" : layer("partials", "Partials"));
  return "<figure data-figure=\"spectrum\" data-range-hz=\"0 " + rounded(high_hz, 6) + "\">" + sheet(svg) +
         data_script("data-spectrum", data) + data_script("data-partials", partial_data(view, window_s)) +
         "<div class=\"live\" hidden></div><p class=\"tools\">" + layers +
         "<button type=\"button\" data-action=\"zoom-in\" aria-label=\"Zoom in\">+</button><button type=\"button\" "
         "data-action=\"zoom-out\" aria-label=\"Zoom out\">−</button><button type=\"button\" "
         "data-action=\"zoom-reset\">All</button> <output data-readout></output></p>" +
         tag("figcaption", (view.given.level_db.empty()
                                ? "Measured spectrum of the " + rounded(window_s, 2) +
                                      " s after the strike, under a window that falls; partials stand where such a "
                                      "ring would peak."
                                : "The rms of the measured responses; partials stand on it.") +
                               " Drag or turn the wheel to zoom, click twice for all.") +
         "</figure>\n";
}

std::string hear_cell(std::size_t index, double frequency_hz) {
  const std::string number = std::to_string(index), at = hertz(frequency_hz);
  return "<td class=\"act\"><button type=\"button\" data-action=\"hear\" data-partial=\"" + number +
         "\" aria-label=\"Hear the partial at " + at +
         "\">Hear</button> <button type=\"button\" data-action=\"hear-without\" data-partial=\"" + number +
         "\" aria-label=\"Hear without the partial at " + at + "\">Without</button></td>";
}

}  // namespace klang::reports::detail
