#include "reports/pages/decay_figure.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/plot_parts.hpp"

namespace klang::reports::detail {
namespace {

std::vector<DecayMark> drawable(const std::vector<DecayMark>& marks) {
  std::vector<DecayMark> kept;
  for (const DecayMark& mark : marks) {
    const fit::Partial& p = mark.partial;
    if (p.decay_per_s && *p.decay_per_s > 0 && p.frequency_hz > 0) kept.push_back(mark);
  }
  return kept;
}

std::string words_of(const DecayMark& mark) {
  const fit::Partial& p = mark.partial;
  const double spread = p.decay_std_per_s.value_or(0);
  return (mark.body.empty() ? "" : mark.body + ", ") + hertz(p.frequency_hz, p.frequency_std_hz) + ": " +
         (spread > 0 ? fixed(*p.decay_per_s, decimals_for(spread)) + " ± " + fixed(spread, decimals_for(spread))
                     : rounded(*p.decay_per_s)) +
         " 1/s" + (mark.without_mode ? ", no mode" : "");
}

void draw_models(Svg& svg, Frame& frame, const DecayPlot& plot, double highest_hz) {
  // Curves from the least likely to the best, which lies on top.
  std::vector<double> ends;
  std::vector<std::string> names, classes;
  static constexpr std::string_view kDashes[] = {"dash1", "dash2", "dash3", "dash4"};
  for (std::size_t i = plot.models.size(); i-- > 0;) {
    const fit::DampingRecord& model = plot.models[i];
    // What acts beside the material differs from mode to mode: no curve shows it, and only the best one's is worth a line.
    if (model.model != plot.best && model.model.find("_and_") != std::string::npos) continue;
    std::vector<PlotPoint> curve;
    double end = 0, end_distance = 1e300;
    for (std::size_t k = 0; k < model.curve.frequency_hz.size(); ++k) {
      curve.push_back({model.curve.frequency_hz[k], model.curve.decay_per_s[k]});
      const double distance = std::abs(std::log(std::max(model.curve.frequency_hz[k], 1e-9) / highest_hz));
      if (model.curve.decay_per_s[k] > 0 && distance < end_distance) {
        end_distance = distance;
        end = model.curve.decay_per_s[k];
      }
    }
    const bool best = model.model == plot.best;
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
}

}  // namespace

std::optional<Svg> decay_figure(const DecayPlot& plot) {
  constexpr double kHeight = 460, kLeft = 66, kTop = 34, kRight = 170;
  const std::vector<DecayMark> marks = drawable(plot.marks);
  if (marks.empty() && plot.models.empty()) return {};
  std::vector<double> frequencies, decays;
  for (const DecayMark& mark : marks) {
    frequencies.push_back(mark.partial.frequency_hz);
    decays.push_back(*mark.partial.decay_per_s);
  }
  if (marks.empty()) {
    for (const fit::DampingRecord& model : plot.models) {
      frequencies.insert(frequencies.end(), model.curve.frequency_hz.begin(), model.curve.frequency_hz.end());
      decays.insert(decays.end(), model.curve.decay_per_s.begin(), model.curve.decay_per_s.end());
    }
  }
  const AxisSpec x = axis_around("Frequency [Hz]", Scale::kLog, frequencies, 0.08);
  const AxisSpec y = axis_around("Decay of amplitude [1/s]", Scale::kLog, decays, 0.14);
  std::string models;
  for (const fit::DampingRecord& model : plot.models)
    models += (models.empty() ? "" : ", ") + damping_words(model.model);
  Svg svg(kPageWidth, kHeight,
          "Decay rate over frequency on logarithmic axes, measured with error bars" +
              (models.empty() ? std::string(".") : ", and the curves of the damping models " + models + "."));
  const double right_margin = plot.models.empty() ? 14 : kRight;
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - right_margin, kHeight - kTop - 48}, x, y);
  frame.draw_axes(9, 8);
  draw_models(svg, frame, plot, x.high);
  for (const DecayMark& mark : marks) {
    const double f = mark.partial.frequency_hz, decay = *mark.partial.decay_per_s;
    if (const double spread = mark.partial.decay_std_per_s.value_or(0); spread > 0)
      frame.error_bar(f, std::max(decay - spread, y.low * 1e-3), decay + spread,
                      series_class("s", mark.series) + " thin");
    svg.marker(static_cast<int>(mark.series % kSeriesCount), frame.x(f), frame.y(decay), 4.5, words_of(mark),
               mark.without_mode);
  }
  if (plot.bodies.size() > 1) legend(svg, kLeft, 18, plot.bodies);
  return svg;
}

}  // namespace klang::reports::detail
