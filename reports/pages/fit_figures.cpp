#include "reports/pages/fit_figures.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "reports/kit/text.hpp"
#include "reports/pages/plot_parts.hpp"

namespace klang::reports::detail {
namespace {

/// Modes closer than this share one rung and one place in a list: twins of symmetric bodies.
constexpr double kTwinRatio = 1.0003;

std::string match_words(const fit::MatchRecord& match) {
  return match.specimen + ", mode " + std::to_string(match.mode_index) + ": measured " +
         hertz(match.frequency_hz, match.frequency_std_hz) + ", model " + hertz(match.model_frequency_hz) + ", " +
         signed_cents(match.deviation_cents) + " cents";
}

}  // namespace

std::vector<std::string> names_of(const fit::FitDocument& data) {
  std::vector<std::string> names;
  for (const fit::SpecimenRecord& specimen : data.specimens) names.push_back(specimen.name);
  return names;
}

SpecimenRows rows_of(const fit::FitDocument& data, const fit::SpecimenRecord& specimen) {
  SpecimenRows rows;
  std::set<int> matched_modes;
  for (const fit::MatchRecord& match : data.matches) {
    if (match.specimen != specimen.name) continue;
    rows.matches.push_back(match);
    matched_modes.insert(match.mode_index);
  }
  for (const fit::PredictedRecord& mode : data.predicted) {
    if (mode.specimen == specimen.name) rows.predicted.push_back(mode);
  }
  std::stable_sort(rows.matches.begin(), rows.matches.end(), [](const fit::MatchRecord& a, const fit::MatchRecord& b) {
    return a.frequency_hz < b.frequency_hz;
  });
  std::stable_sort(
      rows.predicted.begin(), rows.predicted.end(),
      [](const fit::PredictedRecord& a, const fit::PredictedRecord& b) { return a.frequency_hz < b.frequency_hz; });
  for (const fit::PredictedRecord& mode : rows.predicted) {
    const bool heard =
        std::any_of(rows.predicted.begin(), rows.predicted.end(), [&](const fit::PredictedRecord& other) {
          return matched_modes.count(other.mode_index) && other.frequency_hz < mode.frequency_hz * kTwinRatio &&
                 mode.frequency_hz < other.frequency_hz * kTwinRatio &&
                 std::abs(other.mode_index - mode.mode_index) <= 1;
        });
    if (!heard) rows.unheard.push_back(mode);
  }
  for (const fit::PartialRecord& partial : specimen.partials) {
    if (!partial.matched_mode) rows.unmatched.push_back(partial);
  }
  return rows;
}

Svg ladder_figure(const fit::FitDocument& data, std::size_t first, std::size_t count) {
  constexpr double kHeight = 640, kLeft = 66, kTop = 54, kBottom = 30;
  count = std::min({count, std::size_t{8}, data.specimens.size() - first});
  std::vector<SpecimenRows> rows;
  std::vector<double> frequencies;
  std::string names;
  for (std::size_t i = 0; i < count; ++i) {
    const fit::SpecimenRecord& specimen = data.specimens[first + i];
    rows.push_back(rows_of(data, specimen));
    names += (i ? ", " : "") + specimen.name;
    for (const fit::PartialRecord& p : specimen.partials) frequencies.push_back(p.frequency_hz);
    for (const fit::MatchRecord& m : rows.back().matches) {
      frequencies.push_back(m.frequency_hz);
      frequencies.push_back(m.model_frequency_hz);
    }
  }
  // The model's modes far above the last partial would only squeeze the rest.
  const AxisSpec measured = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.05);
  for (const SpecimenRows& row : rows) {
    for (const fit::PredictedRecord& p : row.predicted) {
      if (frequencies.empty() || (p.frequency_hz < 1.35 * measured.high && p.frequency_hz > measured.low / 1.35)) {
        frequencies.push_back(p.frequency_hz);
      }
    }
  }
  AxisSpec y = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.05);
  Svg svg(kPageWidth, kHeight,
          "Measured and model frequencies of " + names + " side by side; the numbers are listed in the tables.");
  const double plot_width = kPageWidth - kLeft - 10;
  Frame frame(svg, {kLeft, kTop, plot_width, kHeight - kTop - kBottom}, {"", Scale::kLinear, 0, 1, false}, y);
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
    for (const fit::PredictedRecord& mode : rows[i].predicted) {
      if (mode.frequency_hz < y.low || mode.frequency_hz > y.high) continue;
      svg.begin_group("mode " + std::to_string(mode.mode_index) + ", " + hertz(mode.frequency_hz));
      svg.line(right_start, frame.y(mode.frequency_hz), right_end, frame.y(mode.frequency_hz), "ghost");
      svg.end_group();
    }
    for (const fit::PartialRecord& partial : rows[i].unmatched) {
      if (partial.frequency_hz < y.low || partial.frequency_hz > y.high) continue;
      svg.begin_group(hertz(partial.frequency_hz, partial.frequency_std_hz) + ", no mode");
      svg.line(left_start, frame.y(partial.frequency_hz), left_end, frame.y(partial.frequency_hz), "alarm dash4");
      svg.end_group();
    }
    std::vector<double> wanted;
    for (const fit::MatchRecord& match : rows[i].matches) wanted.push_back(frame.y(match.frequency_hz));
    const std::vector<double> placed = spread_labels(wanted, 11.5, kTop + 4, frame.bottom());
    for (std::size_t k = 0; k < rows[i].matches.size(); ++k) {
      const fit::MatchRecord& match = rows[i].matches[k];
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

std::optional<Svg> residual_figure(const fit::FitDocument& data) {
  if (data.matches.empty()) return {};
  constexpr double kHeight = 340, kLeft = 66, kTop = 34;
  std::vector<double> frequencies, deviations;
  const auto std_cents = [](const fit::MatchRecord& m) {
    return m.frequency_std_hz && m.frequency_hz > 0 ? 1200 / std::log(2.0) * *m.frequency_std_hz / m.frequency_hz : 0.0;
  };
  double largest = 0, sum_sq = 0;
  for (const fit::MatchRecord& match : data.matches) {
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
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48}, x, y);
  svg.rect(frame.left(), frame.y(rms), frame.right() - frame.left(), frame.y(-rms) - frame.y(rms), "band");
  frame.draw_axes(9, 6, false, true);
  svg.line(frame.left(), frame.y(0), frame.right(), frame.y(0), "axis");
  for (std::size_t s = 0; s < data.specimens.size(); ++s) {
    for (const fit::MatchRecord& match : data.matches) {
      if (match.specimen != data.specimens[s].name) continue;
      if (const double spread = std_cents(match); spread > 0) {
        frame.error_bar(match.frequency_hz, match.deviation_cents - spread, match.deviation_cents + spread,
                        series_class("s", s) + " thin");
      }
      svg.marker(static_cast<int>(s % kSeriesCount), frame.x(match.frequency_hz), frame.y(match.deviation_cents), 4.5,
                 match_words(match));
    }
  }
  legend(svg, kLeft, 18, names_of(data));
  svg.text(frame.right(), 18, "grey band: ± rms " + rounded(rms, 2) + " cents", "muted small", Anchor::kEnd);
  return svg;
}

}  // namespace klang::reports::detail
