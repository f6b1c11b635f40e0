#include "reports/pages/figures.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "reports/kit/text.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kPageWidth = 1080;

/// Modes closer than this share one rung and one place in a list: twins of symmetric bodies.
constexpr double kTwinRatio = 1.0003;

std::string_view short_name(std::string_view name, std::size_t longest) {
  return name.size() <= longest ? name : name.substr(0, longest);
}

/// Cut at a whole UTF-8 character, with an ellipsis.
std::string label_of(const std::string& name, std::size_t longest = 16) {
  if (name.size() <= longest) return name;
  std::string_view cut = short_name(name, longest - 1);
  while (!cut.empty() && (static_cast<unsigned char>(name[cut.size()]) & 0xc0) == 0x80) cut.remove_suffix(1);
  return std::string(cut) + "…";
}

std::string series_class(std::string_view prefix, std::size_t index) {
  return std::string(prefix) + std::to_string(index % kSeriesCount);
}

std::string match_words(const Match& match) {
  return match.specimen + ", mode " + std::to_string(match.mode_index) + ": measured " +
         hertz(match.frequency_hz, match.frequency_std_hz) + ", model " + hertz(match.model_frequency_hz) + ", " +
         signed_cents(match.deviation_cents) + " cents";
}

/// Markers with names in a row; returns nothing to draw when there is one series only.
void legend(Svg& svg, double left, double top, const std::vector<Specimen>& specimens) {
  double x = left;
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    const std::string name = label_of(specimens[i].name);
    const double width = 26 + 7.0 * static_cast<double>(name.size());
    if (x + width > kPageWidth - 10) return;
    svg.marker(static_cast<int>(i % kSeriesCount), x + 6, top - 4, 4.5, "");
    svg.text(x + 16, top, name, "small");
    x += width;
  }
}

}  // namespace

SpecimenRows rows_of(const ResultData& data, const Specimen& specimen) {
  SpecimenRows rows;
  std::set<int> matched_modes;
  for (const Match& match : data.matches) {
    if (match.specimen != specimen.name) continue;
    rows.matches.push_back(match);
    matched_modes.insert(match.mode_index);
  }
  for (const Predicted& mode : data.predicted) {
    if (mode.specimen == specimen.name) rows.predicted.push_back(mode);
  }
  std::stable_sort(rows.matches.begin(), rows.matches.end(),
                   [](const Match& a, const Match& b) { return a.frequency_hz < b.frequency_hz; });
  std::stable_sort(rows.predicted.begin(), rows.predicted.end(),
                   [](const Predicted& a, const Predicted& b) { return a.frequency_hz < b.frequency_hz; });
  for (const Predicted& mode : rows.predicted) {
    const bool heard = std::any_of(rows.predicted.begin(), rows.predicted.end(), [&](const Predicted& other) {
      return matched_modes.count(other.mode_index) && other.frequency_hz < mode.frequency_hz * kTwinRatio &&
             mode.frequency_hz < other.frequency_hz * kTwinRatio && std::abs(other.mode_index - mode.mode_index) <= 1;
    });
    if (!heard) rows.unheard.push_back(mode);
  }
  for (const Partial& partial : specimen.partials) {
    if (!partial.matched_mode) rows.unmatched.push_back(partial);
  }
  return rows;
}

Svg ladder_figure(const ResultData& data, std::size_t first, std::size_t count) {
  constexpr double kHeight = 640, kLeft = 66, kTop = 54, kBottom = 30;
  count = std::min({count, std::size_t{8}, data.specimens.size() - first});
  std::vector<SpecimenRows> rows;
  std::vector<double> frequencies;
  std::string names;
  for (std::size_t i = 0; i < count; ++i) {
    const Specimen& specimen = data.specimens[first + i];
    rows.push_back(rows_of(data, specimen));
    names += (i ? ", " : "") + specimen.name;
    for (const Partial& p : specimen.partials) frequencies.push_back(p.frequency_hz);
    for (const Match& m : rows.back().matches) {
      frequencies.push_back(m.frequency_hz);
      frequencies.push_back(m.model_frequency_hz);
    }
  }
  // The model's modes far above the last partial would only squeeze the rest.
  const AxisSpec measured = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.05);
  for (const SpecimenRows& row : rows) {
    for (const Predicted& p : row.predicted) {
      if (frequencies.empty() || (p.frequency_hz < 1.35 * measured.high && p.frequency_hz > measured.low / 1.35)) {
        frequencies.push_back(p.frequency_hz);
      }
    }
  }
  AxisSpec y = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.05);
  Svg svg(kPageWidth, kHeight,
          "Measured and model frequencies of " + names + " side by side; the numbers are listed in the tables.");
  const double plot_width = kPageWidth - kLeft - 10;
  Frame frame(svg, kLeft, kTop, plot_width, kHeight - kTop - kBottom, {"", Scale::kLinear, 0, 1, false}, y);
  for (const Tick& tick : axis_ticks(y, 9)) {
    const double at = frame.y(tick.value);
    if (!tick.label.empty()) svg.line(kLeft, at, frame.right(), at, "grid");
    svg.line(kLeft - (tick.label.empty() ? 3 : 5), at, kLeft, at, "axis");
    svg.text(kLeft - 8, at + 4, tick.label, "muted small", Anchor::kEnd);
  }
  svg.line(kLeft, frame.top(), kLeft, frame.bottom(), "axis");
  svg.text(kLeft - 50, (frame.top() + frame.bottom()) / 2, y.label, "muted", Anchor::kMiddle, -90);

  const double column = std::min(plot_width / static_cast<double>(std::max<std::size_t>(count, 1)), 420.0);
  const bool roomy = column > 300;  // then the frequencies are written too
  const double indent = (plot_width - column * static_cast<double>(count)) / 2;
  for (std::size_t i = 0; i < count; ++i) {
    const double left = kLeft + indent + column * static_cast<double>(i);
    // Rung - gap - rung - number, in fractions of the column.
    const double left_start = left + 0.08 * column, left_end = left + 0.34 * column, right_start = left + 0.44 * column,
                 right_end = left + 0.70 * column, words = left + 0.74 * column;
    svg.text((left_start + right_end) / 2, kTop - 30, label_of(data.specimens[first + i].name), "strong",
             Anchor::kMiddle);
    svg.text((left_start + left_end) / 2, kTop - 13, "measured", "muted tiny", Anchor::kMiddle);
    svg.text((right_start + right_end) / 2, kTop - 13, "model", "muted tiny", Anchor::kMiddle);
    svg.text(words, kTop - 13, "cents", "muted tiny");
    for (const Predicted& mode : rows[i].predicted) {
      if (mode.frequency_hz < y.low || mode.frequency_hz > y.high) continue;
      svg.begin_group("mode " + std::to_string(mode.mode_index) + ", " + hertz(mode.frequency_hz));
      svg.line(right_start, frame.y(mode.frequency_hz), right_end, frame.y(mode.frequency_hz), "ghost");
      svg.end_group();
    }
    for (const Partial& partial : rows[i].unmatched) {
      if (partial.frequency_hz < y.low || partial.frequency_hz > y.high) continue;
      svg.begin_group(hertz(partial.frequency_hz, partial.frequency_std_hz) + ", no mode");
      svg.line(left_start, frame.y(partial.frequency_hz), left_end, frame.y(partial.frequency_hz), "alarm dash4");
      svg.end_group();
    }
    std::vector<double> wanted;
    for (const Match& match : rows[i].matches) wanted.push_back(frame.y(match.frequency_hz));
    const std::vector<double> placed = spread_labels(wanted, 11.5, kTop + 4, frame.bottom());
    for (std::size_t k = 0; k < rows[i].matches.size(); ++k) {
      const Match& match = rows[i].matches[k];
      const double at = frame.y(match.frequency_hz), model_at = frame.y(match.model_frequency_hz);
      svg.begin_group(match_words(match));
      svg.line(left_start, at, left_end, at, "ink");
      svg.line(left_end, at, right_start, model_at, "rule");
      svg.line(right_start, model_at, right_end, model_at, "accent");
      if (std::abs(placed[k] - model_at) > 3) svg.line(right_end + 1, model_at, words - 2, placed[k], "grid");
      svg.text(words, placed[k] + 3.5, signed_cents(match.deviation_cents), "tiny");
      if (roomy) svg.text(words + 36, placed[k] + 3.5, hertz(match.frequency_hz, match.frequency_std_hz), "muted tiny");
      svg.end_group();
    }
  }
  const double y_key = kHeight - 8;
  double x = kLeft + 4;
  const auto key = [&](std::string_view classes, std::string_view label) {
    svg.line(x, y_key - 4, x + 26, y_key - 4, classes);
    svg.text(x + 32, y_key, label, "muted small");
    x += 52 + 6.1 * static_cast<double>(label.size());
  };
  key("ink", "measured partial");
  key("accent", "mode it matches");
  key("ghost", "mode not heard (or the second of a pair)");
  key("alarm dash4", "partial without a mode");
  return svg;
}

std::optional<Svg> residual_figure(const ResultData& data) {
  if (data.matches.empty()) return {};
  constexpr double kHeight = 340, kLeft = 66, kTop = 34;
  std::vector<double> frequencies, deviations;
  const auto std_cents = [](const Match& m) {
    return m.frequency_std_hz && m.frequency_hz > 0 ? 1200 / std::log(2.0) * *m.frequency_std_hz / m.frequency_hz : 0.0;
  };
  double largest = 0, sum_sq = 0;
  for (const Match& match : data.matches) {
    frequencies.push_back(match.frequency_hz);
    largest = std::max(
        largest, std::abs(match.deviation_cents) + std::min(std_cents(match), 2 * std::abs(match.deviation_cents) + 1));
    sum_sq += match.deviation_cents * match.deviation_cents;
  }
  const double rms = std::sqrt(sum_sq / static_cast<double>(data.matches.size()));
  largest = std::max(largest * 1.12, 1e-3);
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.04);
  const AxisSpec y{"Measured − model [cents]", Scale::kLinear, -largest, largest, true};
  Svg svg(kPageWidth, kHeight,
          "Deviation of each matched partial from the model in cents over frequency; root mean square " +
              rounded(rms, 2) + " cents.");
  Frame frame(svg, kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48, x, y);
  svg.rect(frame.left(), frame.y(rms), frame.right() - frame.left(), frame.y(-rms) - frame.y(rms), "band");
  frame.draw_axes(9, 6, false, true);
  svg.line(frame.left(), frame.y(0), frame.right(), frame.y(0), "axis");
  for (std::size_t s = 0; s < data.specimens.size(); ++s) {
    for (const Match& match : data.matches) {
      if (match.specimen != data.specimens[s].name) continue;
      if (const double spread = std_cents(match); spread > 0) {
        frame.error_bar(match.frequency_hz, match.deviation_cents - spread, match.deviation_cents + spread,
                        series_class("s", s) + " thin");
      }
      svg.marker(static_cast<int>(s % kSeriesCount), frame.x(match.frequency_hz), frame.y(match.deviation_cents), 4.5,
                 match_words(match));
    }
  }
  legend(svg, kLeft, 18, data.specimens);
  svg.text(frame.right(), 18, "grey band: ± rms " + rounded(rms, 2) + " cents", "muted small", Anchor::kEnd);
  return svg;
}

std::optional<Svg> decay_figure(const ResultData& data) {
  constexpr double kHeight = 460, kLeft = 66, kTop = 34, kRight = 170;
  std::vector<double> frequencies, decays;
  struct Point {
    std::size_t series;
    double frequency_hz, decay_per_s, std_per_s;
    bool hollow;
    std::string words;
  };
  std::vector<Point> points;
  for (std::size_t s = 0; s < data.specimens.size(); ++s) {
    for (const Partial& p : data.specimens[s].partials) {
      if (!p.decay_per_s || !(*p.decay_per_s > 0) || !(p.frequency_hz > 0)) continue;
      const bool hollow = data.kind == "fit" && !p.matched_mode;
      const double spread = p.decay_std_per_s.value_or(0);
      points.push_back(
          {s, p.frequency_hz, *p.decay_per_s, spread, hollow,
           (data.specimens[s].name.empty() ? "" : data.specimens[s].name + ", ") +
               hertz(p.frequency_hz, p.frequency_std_hz) + ": " +
               (spread > 0 ? fixed(*p.decay_per_s, decimals_for(spread)) + " ± " + fixed(spread, decimals_for(spread))
                           : rounded(*p.decay_per_s)) +
               " 1/s" + (hollow ? ", no mode" : "")});
      frequencies.push_back(p.frequency_hz);
      decays.push_back(*p.decay_per_s);
    }
  }
  if (points.empty() && data.damping.empty()) return {};
  if (points.empty()) {
    for (const DampingModel& model : data.damping) {
      frequencies.insert(frequencies.end(), model.curve_frequency_hz.begin(), model.curve_frequency_hz.end());
      decays.insert(decays.end(), model.curve_decay_per_s.begin(), model.curve_decay_per_s.end());
    }
  }
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.08);
  const AxisSpec y = axis_around("Decay of amplitude [1/s]", Scale::kLog, decays, 0.14);
  std::string models;
  for (const DampingModel& model : data.damping) models += (models.empty() ? "" : ", ") + damping_words(model.model);
  Svg svg(kPageWidth, kHeight,
          "Decay rate over frequency on logarithmic axes, measured with error bars" +
              (models.empty() ? std::string(".") : ", and the curves of the damping models " + models + "."));
  const double right_margin = data.damping.empty() ? 14 : kRight;
  Frame frame(svg, kLeft, kTop, kPageWidth - kLeft - right_margin, kHeight - kTop - 48, x, y);
  frame.draw_axes(9, 8);
  // Curves from the least likely to the best, which lies on top.
  std::vector<double> ends;
  std::vector<std::string> names, classes;
  static constexpr std::string_view kDashes[] = {"dash1", "dash2", "dash3", "dash4"};
  for (std::size_t i = data.damping.size(); i-- > 0;) {
    const DampingModel& model = data.damping[i];
    // What acts beside the material differs from mode to mode: no curve shows it, and only the best one's is worth a line.
    if (model.model != data.damping_model && model.model.find("_and_") != std::string::npos) continue;
    std::vector<PlotPoint> curve;
    double end = 0, end_distance = 1e300;
    for (std::size_t k = 0; k < model.curve_frequency_hz.size(); ++k) {
      curve.push_back({model.curve_frequency_hz[k], model.curve_decay_per_s[k]});
      const double distance = std::abs(std::log(std::max(model.curve_frequency_hz[k], 1e-9) / x.high));
      if (model.curve_decay_per_s[k] > 0 && distance < end_distance) {
        end_distance = distance;
        end = model.curve_decay_per_s[k];
      }
    }
    const bool best = model.model == data.damping_model;
    const std::string line = best ? "ink thick" : "axis mid " + std::string(kDashes[i % 4]);
    frame.curve(curve, line);
    ends.push_back(end > 0 ? std::clamp(frame.y(end), frame.top(), frame.bottom()) : frame.bottom());
    names.push_back(damping_words(model.model));
    classes.push_back(line);
  }
  const std::vector<double> placed = spread_labels(ends, 17, frame.top(), frame.bottom());
  for (std::size_t i = 0; i < names.size(); ++i) {
    svg.line(frame.right() + 6, ends[i], frame.right() + 14, placed[i], "grid");
    svg.line(frame.right() + 14, placed[i], frame.right() + 38, placed[i], classes[i]);
    const bool best = classes[i] == "ink thick";
    svg.text(frame.right() + 43, placed[i] + 4, names[i], best ? "small strong" : "small");
  }
  for (const Point& point : points) {
    if (point.std_per_s > 0) {
      frame.error_bar(point.frequency_hz, std::max(point.decay_per_s - point.std_per_s, y.low * 1e-3),
                      point.decay_per_s + point.std_per_s, series_class("s", point.series) + " thin");
    }
    svg.marker(static_cast<int>(point.series % kSeriesCount), frame.x(point.frequency_hz), frame.y(point.decay_per_s),
               4.5, point.words, point.hollow);
  }
  if (data.specimens.size() > 1) legend(svg, kLeft, 18, data.specimens);
  return svg;
}

std::optional<Svg> spectrum_figure(const Specimen& specimen) {
  constexpr double kHeight = 340, kLeft = 66, kTop = 24;
  std::vector<double> frequencies, levels;
  for (const Partial& p : specimen.partials) {
    if (!p.amplitude || !(*p.amplitude > 0) || !(p.frequency_hz > 0)) continue;
    frequencies.push_back(p.frequency_hz);
    levels.push_back(20 * std::log10(*p.amplitude));
  }
  if (frequencies.empty()) return {};
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.08);
  AxisSpec y = axis_around("Level at the strike [dB re full scale]", Scale::kLinear, levels, 0.1);
  y.low = 10 * std::floor((y.low - 6) / 10);
  y.high = 5 * std::ceil((y.high + 3) / 5);
  Svg svg(kPageWidth, kHeight,
          "Partials as lines: level at the strike over frequency, " +
              counted(frequencies.size(), "partial", "partials") + ".");
  Frame frame(svg, kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48, x, y);
  frame.draw_axes(9, 6, false, true);
  std::vector<std::size_t> loudest(frequencies.size());
  for (std::size_t i = 0; i < loudest.size(); ++i) loudest[i] = i;
  std::stable_sort(loudest.begin(), loudest.end(), [&](std::size_t a, std::size_t b) { return levels[a] > levels[b]; });
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    svg.line(frame.x(frequencies[i]), frame.bottom(), frame.x(frequencies[i]), frame.y(levels[i]), "accent");
    svg.marker(0, frame.x(frequencies[i]), frame.y(levels[i]), 4,
               hertz(frequencies[i]) + ", " + fixed(levels[i], 1) + " dB");
  }
  // Frequencies of the loudest, where their words do not overlap.
  std::vector<double> taken;
  for (const std::size_t i : loudest) {
    const double at = frame.x(frequencies[i]);
    const bool clear =
        std::none_of(taken.begin(), taken.end(), [&](double other) { return std::abs(other - at) < 46; });
    if (!clear || taken.size() >= 14) continue;
    taken.push_back(at);
    svg.text(std::clamp(at, frame.left() + 18, frame.right() - 18), frame.y(levels[i]) - 9,
             fixed(frequencies[i], frequencies[i] < 1000 ? 1 : 0), "tiny", Anchor::kMiddle);
  }
  return svg;
}

std::optional<Svg> modes_figure(const Specimen& specimen) {
  if (specimen.modes.empty()) return {};
  constexpr double kHeight = 150, kLeft = 20, kTop = 20;
  std::vector<double> frequencies;
  for (const Mode& mode : specimen.modes) frequencies.push_back(mode.frequency_hz);
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.05);
  Svg svg(kPageWidth, kHeight, "Frequencies of the modes on a logarithmic axis.");
  Frame frame(svg, kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48, x, {"", Scale::kLinear, 0, 1, false});
  for (const Tick& tick : axis_ticks(x, 9)) {
    const double at = frame.x(tick.value);
    svg.line(at, frame.bottom(), at, frame.bottom() + (tick.label.empty() ? 3 : 5), "axis");
    svg.text(at, frame.bottom() + 18, tick.label, "muted small", Anchor::kMiddle);
  }
  svg.line(frame.left(), frame.bottom(), frame.right(), frame.bottom(), "axis");
  svg.text((frame.left() + frame.right()) / 2, frame.bottom() + 36, x.label, "muted", Anchor::kMiddle);
  for (const Mode& mode : specimen.modes) {
    if (!(mode.frequency_hz > 0)) continue;
    svg.begin_group("mode " + std::to_string(mode.index) + ", " + hertz(mode.frequency_hz));
    svg.line(frame.x(mode.frequency_hz), frame.top(), frame.x(mode.frequency_hz), frame.bottom(), "accent");
    svg.end_group();
  }
  return svg;
}

}  // namespace klang::reports::detail
