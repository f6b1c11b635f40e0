#include "reports/pages/study_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reports/kit/text.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kPictureWidth = 520, kBarSpace = 74;

double step_of(const validate::LevelRecord& level) { return level.h_m ? *level.h_m : level.n.value_or(0); }

bool geometric(const validate::SeriesRecord& series) { return series.kind == validate::Convergence::kGeometric; }

std::string series_class(const char* prefix, std::size_t index) {
  return prefix + std::to_string(index % kSeriesCount);
}

/// Least-squares line through the levels that count: ln error = middle_y + slope (x - middle_x).
struct FittedLine {
  double middle_x = 0, middle_y = 0, low_x = 0, high_x = 0;
  bool any = false;
};

double abscissa(const validate::SeriesRecord& series, double step) { return geometric(series) ? step : std::log(step); }

FittedLine fitted_line(const validate::SeriesRecord& series) {
  FittedLine line;
  double n = 0;
  line.low_x = std::numeric_limits<double>::infinity(), line.high_x = -line.low_x;
  for (const validate::LevelRecord& level : series.order.levels) {
    if (!level.excluded.empty() || !level.error || !(*level.error > 0)) continue;
    const double x = abscissa(series, step_of(level));
    line.middle_x += x, line.middle_y += std::log(*level.error), n += 1;
    line.low_x = std::min(line.low_x, x), line.high_x = std::max(line.high_x, x);
  }
  if (n < 2 || !series.order.observed_order || !series.order.expected_order) return line;
  line.middle_x /= n, line.middle_y /= n;
  line.any = true;
  return line;
}

/// Slope of ln(error) over the abscissa for an order: errors fall with falling h and with rising n.
double slope_of(const validate::SeriesRecord& series, double order) {
  const bool over_h = !series.order.levels.empty() && series.order.levels.front().h_m.has_value();
  return over_h ? order : -order;
}

std::string order_words(const validate::SeriesRecord& series) {
  if (series.kind == validate::Convergence::kRoundOff) return "round-off";
  if (!series.order.expected_order) return "no order expected";
  const std::string name = geometric(series) ? "rate " : "order ";
  return series.order.observed_order ? name + fixed(*series.order.observed_order, 2) : "no " + name;
}

/// The lowest place in a column that no label takes yet, close to the one that is wanted.
struct Label {
  double y;
  std::size_t series;
  std::string words;
};

void draw_labels(Svg& svg, const Frame& frame, std::vector<Label> labels, double x) {
  std::vector<double> wanted;
  for (const Label& label : labels) wanted.push_back(label.y);
  const std::vector<double> placed = spread_labels(wanted, 26, frame.top() + 8, frame.bottom() - 8);
  for (std::size_t k = 0; k < labels.size(); ++k) {
    const std::size_t cut = labels[k].words.find('\n');
    svg.marker(static_cast<int>(labels[k].series % kSeriesCount), x + 5, placed[k] - 4, 4.5, "");
    svg.text(x + 15, placed[k], labels[k].words.substr(0, cut), "small");
    if (cut != std::string::npos) svg.text(x + 15, placed[k] + 12, labels[k].words.substr(cut + 1), "muted tiny");
  }
}

std::string shortened(const std::string& text, std::size_t longest) {
  if (text.size() <= longest) return text;
  std::size_t cut = longest;
  while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xc0) == 0x80) --cut;
  return text.substr(0, cut) + "…";
}

/// A triangle that shows the expected slope, below the finest part of the curves.
struct Slope {
  double order, x_from, x_to, y_at;
};
void draw_slope(Svg& svg, const Frame& frame, const AxisSpec& x_axis, const AxisSpec& y_axis, const Slope& slope) {
  const auto [order, x_from, x_to, y_at] = slope;
  const double rise = std::pow(x_to / x_from, order);
  if (!(y_at > y_axis.low) || !(y_at * rise < y_axis.high) || !(x_from > x_axis.low) || !(x_to < x_axis.high)) return;
  svg.polyline(
      {{frame.x(x_from), frame.y(y_at)}, {frame.x(x_to), frame.y(y_at)}, {frame.x(x_to), frame.y(y_at * rise)}}, "rule",
      true);
  svg.text(frame.x(x_to) + 5, (frame.y(y_at) + frame.y(y_at * rise)) / 2 + 4, rounded(order, 3), "muted small");
}

CaptionedFigure convergence_figure(const validate::StudyDocument& study, const std::vector<std::size_t>& group,
                                   std::size_t number) {
  const bool linear_x = geometric(study.series[group.front()]);
  constexpr double kHeight = 560, kLeft = 66, kTop = 20, kRight = 268;
  std::vector<double> steps, errors;
  for (const std::size_t s : group) {
    for (const validate::LevelRecord& level : study.series[s].order.levels) {
      if (!level.error || !(*level.error > 0)) continue;
      steps.push_back(step_of(level));
      errors.push_back(*level.error);
    }
  }
  const validate::SeriesRecord& first = study.series[group.front()];
  const AxisSpec x = axis_around(capitalised(first.step), linear_x ? Scale::kLinear : Scale::kLog, steps, 0.05);
  const AxisSpec y = axis_around("Error", Scale::kLog, errors, 0.07);
  std::string names;
  for (const std::size_t s : group)
    names += (names.empty() ? "" : "; ") + study.series[s].title + ", " + order_words(study.series[s]);
  Svg svg(kPageWidth, kHeight, "Errors over " + first.step + " on logarithmic scales: " + names + ".");
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - kRight, kHeight - kTop - 50}, x, y);

  for (const std::size_t s : group) {  // bands first, so that nothing hides behind them
    const validate::SeriesRecord& series = study.series[s];
    const FittedLine line = fitted_line(series);
    if (!line.any || !series.order.order_ci95) continue;
    const auto at = [&](double order, double place) {
      const double value = std::exp(line.middle_y + slope_of(series, order) * (place - line.middle_x));
      const double step = linear_x ? place : std::exp(place);
      return PlotPoint{std::clamp(frame.x(step), frame.left(), frame.right()),
                       std::clamp(frame.y(value), frame.top(), frame.bottom())};
    };
    const PlotPoint middle = at(0, line.middle_x);
    for (const double end : {line.low_x, line.high_x})
      svg.polyline({middle, at((*series.order.order_ci95)[0], end), at((*series.order.order_ci95)[1], end)}, "band",
                   true);
  }
  frame.draw_axes(7, 8);
  std::vector<Label> labels;
  for (const std::size_t s : group) {
    const validate::SeriesRecord& series = study.series[s];
    const std::string colour = series_class("s", s) + (series.counts ? "" : " dash2");
    const FittedLine line = fitted_line(series);
    if (line.any) {
      std::vector<PlotPoint> curve;
      for (const double end : {line.low_x, line.high_x})
        curve.push_back(
            {linear_x ? end : std::exp(end),
             std::exp(line.middle_y + slope_of(series, *series.order.observed_order) * (end - line.middle_x))});
      frame.curve(curve, colour);
    } else if (!series.order.levels.empty()) {
      std::vector<PlotPoint> curve;
      for (const validate::LevelRecord& level : series.order.levels)
        curve.push_back({step_of(level), level.error.value_or(0)});
      frame.curve(curve, colour + " thin");
    }
    double last = std::nan("");
    double end_step = step_of(series.order.levels.empty() ? validate::LevelRecord{} : series.order.levels.back());
    for (const validate::LevelRecord& level : series.order.levels) {
      if (!level.error || !(*level.error > 0)) continue;
      const std::string words =
          series.title + ": error " + rounded(*level.error, 3) + " at " + rounded(step_of(level), 4) +
          (level.excluded.empty() || !series.order.expected_order ? "" : " (" + level.excluded + ", not in the fit)");
      svg.marker(static_cast<int>(s % kSeriesCount), frame.x(step_of(level)), frame.y(*level.error), 4.5, words,
                 !level.excluded.empty() && series.order.expected_order.has_value());
      // The label belongs to the end of the curve at the right edge.
      if (!std::isfinite(last) || step_of(level) >= end_step) last = *level.error, end_step = step_of(level);
    }
    if (std::isfinite(last))
      labels.push_back(
          {frame.y(last), s,
           shortened(series.title, 38) + "\n" + order_words(series) +
               (series.order.expected_order ? ", expected " + rounded(*series.order.expected_order, 3) : "")});
  }
  if (!linear_x) {
    // One triangle for each expected order, in the free corner below the curves.
    std::vector<double> orders;
    for (const std::size_t s : group) {
      const auto& expected = study.series[s].order.expected_order;
      if (expected && *expected > 0 && std::find(orders.begin(), orders.end(), *expected) == orders.end())
        orders.push_back(*expected);
    }
    const bool over_h = first.order.levels.empty() || first.order.levels.front().h_m.has_value();
    const double width = std::pow(x.high / x.low, 0.13);
    for (std::size_t k = 0; k < orders.size() && over_h; ++k) {
      const double from = x.low * std::pow(x.high / x.low, 0.66 + 0.17 * static_cast<double>(k));
      draw_slope(
          svg, frame, x, y,
          {orders[orders.size() - 1 - k], from, from * std::pow(width, 0.7), y.low * std::pow(y.high / y.low, 0.03)});
    }
  }
  draw_labels(svg, frame, std::move(labels), frame.right() + 14);
  std::string caption =
      "Dots are levels, lines the least-squares fit, grey wedges its 95 % band; hollow dots are not in the fit.";
  const bool compared = std::any_of(group.begin(), group.end(), [&](std::size_t s) { return !study.series[s].counts; });
  if (compared) caption += " Dotted lines are shown for comparison and are no part of the verdict.";
  return {std::move(svg), number == 0 ? "convergence" : "convergence-" + std::to_string(number + 1), caption};
}

std::vector<std::vector<std::size_t>> groups_of(const validate::StudyDocument& study) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t s = 0; s < study.series.size(); ++s) {
    const validate::SeriesRecord& series = study.series[s];
    const bool any =
        std::any_of(series.order.levels.begin(), series.order.levels.end(),
                    [](const validate::LevelRecord& l) { return l.error && *l.error > 0 && step_of(l) > 0; });
    if (!any) continue;
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      const validate::SeriesRecord& other = study.series[group.front()];
      return other.step == series.step && geometric(other) == geometric(series) && group.size() < kSeriesCount;
    });
    same == groups.end() ? groups.push_back({s}) : same->push_back(s);
  }
  return groups;
}

/// The colours of a bar, from low at the bottom to high at the top.
void draw_bar(Svg& svg, double left, double top, double height, const AxisSpec& axis, const std::string& words) {
  IndexedImage ramp{1, 256, {}};
  for (int i = 255; i >= 0; --i) ramp.pixels.push_back(static_cast<std::uint8_t>(i));
  svg.image(left, top, 14, height, data_uri("image/png", png_bytes(ramp, heat_palette())));
  svg.rect(left, top, 14, height, "axis");
  for (const Tick& tick : axis_ticks(axis, 5)) {
    const double share = axis.scale == Scale::kLog ? std::log(tick.value / axis.low) / std::log(axis.high / axis.low)
                                                   : (tick.value - axis.low) / (axis.high - axis.low);
    const double at = top + height * (1 - share);
    svg.line(left + 14, at, left + (tick.label.empty() ? 16 : 18), at, "axis");
    svg.text(left + 22, at + 4, tick.label, "muted small");
  }
  svg.text(left + 7, top - 9, words, "muted small", Anchor::kMiddle);
}

std::string axis_words(const Eigen::Vector3d& side, char fallback) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(side[axis]) > 0.999 * side.norm()) return std::string(1, "xyz"[axis]) + " [m]";
  }
  return std::string(1, fallback) + " [m]";
}

/// Start of a side on its axis, 0 where it runs askew.
double start_of(const Eigen::Vector3d& corner, const Eigen::Vector3d& side) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(side[axis]) > 0.999 * side.norm()) return corner[axis];
  }
  return 0;
}

}  // namespace

std::vector<CaptionedFigure> convergence_figures(const validate::StudyDocument& study) {
  std::vector<CaptionedFigure> figures;
  const auto groups = groups_of(study);
  for (std::size_t g = 0; g < groups.size(); ++g) figures.push_back(convergence_figure(study, groups[g], g));
  return figures;
}

std::vector<CaptionedFigure> cost_figures(const validate::StudyDocument& study) {
  constexpr double kHeight = 420, kLeft = 66, kTop = 20, kRight = 268;
  std::vector<double> costs, errors;
  for (const validate::SeriesRecord& series : study.series) {
    for (const validate::LevelRecord& level : series.order.levels) {
      if (!level.h_m || !level.error || !(*level.error > 0) || !(level.n_unknowns > 0)) continue;
      costs.push_back(level.n_unknowns);
      errors.push_back(*level.error);
    }
  }
  if (costs.size() < 4) return {};
  const AxisSpec x = axis_around("Unknowns", Scale::kLog, costs, 0.05),
                 y = axis_around("Error", Scale::kLog, errors, 0.07);
  Svg svg(kPageWidth, kHeight, "Error over the number of unknowns of every level, both on logarithmic scales.");
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - kRight, kHeight - kTop - 50}, x, y);
  frame.draw_axes(7, 7);
  std::vector<Label> labels;
  for (std::size_t s = 0; s < study.series.size(); ++s) {
    const validate::SeriesRecord& series = study.series[s];
    std::vector<PlotPoint> curve;
    for (const validate::LevelRecord& level : series.order.levels) {
      if (!level.h_m || !level.error || !(*level.error > 0) || !(level.n_unknowns > 0)) continue;
      curve.push_back({level.n_unknowns, *level.error});
    }
    if (curve.empty()) continue;
    frame.curve(curve, series_class("s", s) + (series.counts ? "" : " dash2"));
    for (const PlotPoint& point : curve)
      svg.marker(static_cast<int>(s % kSeriesCount), frame.x(point.x), frame.y(point.y), 4.5,
                 series.title + ": error " + rounded(point.y, 3) + ", " + rounded(point.x, 7) + " unknowns");
    labels.push_back({frame.y(curve.back().y), s, shortened(series.title, 38)});
  }
  draw_labels(svg, frame, std::move(labels), frame.right() + 14);
  std::vector<CaptionedFigure> figures;
  figures.push_back({std::move(svg), "cost", "What an error costs: unknowns of the system that was solved."});
  return figures;
}

Svg slice_figure(const StudyField& field, const validate::SliceField& slice) {
  const double kLeft = 62, kTop = 24, kBottom = 46;
  const auto columns = static_cast<int>(slice.values.cols()), rows = static_cast<int>(slice.values.rows());
  const double width = kPictureWidth - kLeft - kBarSpace - 14;
  const double height = width * slice.side_v_m.norm() / slice.side_u_m.norm();
  double largest = 0, smallest = std::numeric_limits<double>::infinity();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double value = slice.values(row, column);
      if (!(value > 0) || !std::isfinite(value)) continue;
      largest = std::max(largest, value);
      smallest = std::min(smallest, value);
    }
  }
  if (!(largest > 0)) largest = 1, smallest = 0.1;
  AxisSpec bar;
  const bool decibels = field.record.decibels.value_or(false);
  const double floor = field.record.floor.value_or(0.0);
  if (decibels) {
    const double lowest = floor > 0 ? floor : smallest;
    bar = {"", Scale::kLinear, std::max(-60.0, 10 * std::floor(2 * std::log10(lowest / largest))), 0, true};
  } else {
    bar = {"", Scale::kLog, floor > 0 ? std::min(floor, largest / 10) : std::max(smallest, largest * 1e-6), largest,
           true};
    if (!(bar.low < bar.high)) bar.low = bar.high / 10;
  }
  const auto share = [&](double value) {
    if (decibels) return (20 * std::log10(value / largest) - bar.low) / (bar.high - bar.low);
    return std::log(value / bar.low) / std::log(bar.high / bar.low);
  };
  RgbaImage image{columns, rows, {}};
  image.pixels.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) * 4);
  for (int row = rows - 1; row >= 0; --row) {
    for (int column = 0; column < columns; ++column) {
      const double value = slice.values(row, column);
      if (!std::isfinite(value)) {  // the body
        for (const int c : {128, 132, 138, 255}) image.pixels.push_back(static_cast<std::uint8_t>(c));
        continue;
      }
      const double at = value > 0 ? std::clamp(share(value), 0.0, 1.0) : 0.0;
      const auto& colour = heat_palette()[static_cast<std::size_t>(std::lround(255 * at))];
      for (const std::uint8_t c : colour) image.pixels.push_back(c);
      image.pixels.push_back(255);
    }
  }
  Svg svg(kPictureWidth, kTop + height + kBottom, field.record.title);
  svg.image(kLeft, kTop, width, height, data_uri("image/png", png_bytes(image)));
  const double u0 = start_of(slice.corner_m, slice.side_u_m), v0 = start_of(slice.corner_m, slice.side_v_m);
  Frame frame(svg, {kLeft, kTop, width, height},
              {axis_words(slice.side_u_m, 'u'), Scale::kLinear, u0, u0 + slice.side_u_m.norm(), true},
              {axis_words(slice.side_v_m, 'v'), Scale::kLinear, v0, v0 + slice.side_v_m.norm(), true});
  frame.draw_axes(5, 5, false, false);
  draw_bar(svg, kLeft + width + 16, kTop, height, bar, decibels ? "dB" : "");
  return svg;
}

Svg picture_figure(const StudyField& field, const DrawnPicture& picture) {
  const double kTop = 24, room = kPictureWidth - kBarSpace - 30, kHeight = 380;
  const double scale = std::min(room / std::max(picture.width, 1), kHeight / std::max(picture.height, 1));
  Svg svg(kPictureWidth, kTop + kHeight + 14, field.record.title);
  svg.image((room - scale * picture.width) / 2 + 6, kTop + (kHeight - scale * picture.height) / 2,
            scale * picture.width, scale * picture.height, data_uri("image/png", picture.png));
  AxisSpec axis{"", Scale::kLinear, picture.low, picture.high > picture.low ? picture.high : picture.low + 1, true};
  draw_bar(svg, room + 22, kTop + 30, kHeight - 60, axis, field.kind == FieldKind::kBalloon ? "dB" : "");
  return svg;
}

}  // namespace klang::reports::detail
