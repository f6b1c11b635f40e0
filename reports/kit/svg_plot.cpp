#include "reports/kit/svg_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports {
namespace {

using detail::coordinate;
using detail::escaped;

struct Palette {
  std::string_view ink, muted, axis, grid, rule, paper, accent, ghost, alarm;
  std::array<std::string_view, kSeriesCount> series;
};
// Distinct for the common kinds of colour blindness, and of even lightness on each ground.
constexpr Palette kLight = {
    "#1f2328", "#646b73",
    "#8a9099", "#e6e4df",
    "#b9bcc0", "#ffffff",
    "#0f5f8a", "#c3c7cc",
    "#b3261e", {"#0f5f8a", "#c4561b", "#2e7d4f", "#8250a8", "#a37a00", "#c2407e", "#1f8a8c", "#5b6168"}};
constexpr Palette kDark = {
    "#e7e5e0", "#a0a6ad",
    "#737a82", "#2b2f35",
    "#4b5058", "#16181c",
    "#6db9e6", "#4b5158",
    "#ff8f85", {"#6db9e6", "#f0955f", "#75c796", "#c09ae0", "#d9b64a", "#ee8fbd", "#63c7c9", "#b3b9c0"}};

/// A power of ten on a log axis: "10⁻⁶" instead of "1 × 10⁻⁶".
std::string power_label(std::string label) {
  const std::size_t times = label.find("\u00d7"), ten = label.find("10", times == std::string::npos ? 0 : times);
  return times != std::string::npos && ten != std::string::npos && label[0] == '1' ? label.substr(ten) : label;
}

std::string number_label(double value) {
  const double magnitude = std::abs(value);
  const bool whole = std::abs(magnitude - std::round(magnitude)) <= 1e-9 * magnitude;
  if (magnitude >= 10000 && magnitude < 1e7 && whole) {  // 10 000: groups of three
    std::string digits = detail::fixed(magnitude, 0);
    for (int i = static_cast<int>(digits.size()) - 3; i > 0; i -= 3)
      digits.insert(static_cast<std::size_t>(i), "\u202f");
    return (value < 0 ? "\u2212" : "") + digits;
  }
  return detail::rounded(std::abs(value) < 1e-300 ? 0.0 : value, 6);
}
constexpr double kLeastExtent = 1e-4;  // of its values, to each side of a linear axis: finer labels are one, or long

}  // namespace

std::string figure_css(bool dark) {
  const Palette& p = dark ? kDark : kLight;
  std::string css;
  const auto rule = [&](std::string_view selector, std::string_view body) {
    css += "svg.kf ";
    css += selector;
    css += "{";
    css += body;
    css += "}\n";
  };
  const auto colour = [](std::string_view property, std::string_view value) {
    return std::string(property) + ":" + std::string(value);
  };
  rule("text",
       "font:12px system-ui,'Segoe UI',Roboto,'Helvetica Neue','Liberation Sans','DejaVu Sans',sans-serif;"
       "font-variant-numeric:tabular-nums;" +
           colour("fill", p.ink));
  rule("text.muted", colour("fill", p.muted));
  rule("text.small", "font-size:11px");
  rule("text.tiny", "font-size:10px");
  rule("text.strong", "font-weight:600");
  rule("text.accent", colour("fill", p.accent));
  rule("text.alarm", colour("fill", p.alarm));
  rule("text.halo", "paint-order:stroke;stroke-width:3px;stroke-linejoin:round;" + colour("stroke", p.paper));
  rule(".axis", "fill:none;stroke-width:1;" + colour("stroke", p.axis));
  rule(".grid", "fill:none;stroke-width:1;" + colour("stroke", p.grid));
  rule(".rule", "fill:none;stroke-width:1;" + colour("stroke", p.rule));
  rule(".ink", "fill:none;stroke-width:1.5;" + colour("stroke", p.ink));
  rule("text.ink", "stroke:none;" + colour("fill", p.ink));
  rule(".accent", "fill:none;stroke-width:1.75;" + colour("stroke", p.accent));
  rule("text.accent", "stroke:none;" + colour("fill", p.accent));
  rule(".ridge", "fill:none;stroke-width:1.75;stroke:#7df9ff");
  rule(".ghost", "fill:none;stroke-width:1.25;" + colour("stroke", p.ghost));
  rule(".alarm", "fill:none;stroke-width:1.75;" + colour("stroke", p.alarm));
  rule("text.alarm", "stroke:none;" + colour("fill", p.alarm));
  rule(".paper", "stroke:none;" + colour("fill", p.paper));
  rule(".band", "stroke:none;" + colour("fill", p.grid));
  for (int i = 0; i < kSeriesCount; ++i) {
    const std::string n = std::to_string(i);
    rule(".s" + n, "fill:none;stroke-width:1.75;" + colour("stroke", p.series[static_cast<std::size_t>(i)]));
    rule(".m" + n,
         "stroke-width:1;" + colour("fill", p.series[static_cast<std::size_t>(i)]) + ";" + colour("stroke", p.paper));
    rule(".h" + n,
         "stroke-width:1.5;" + colour("stroke", p.series[static_cast<std::size_t>(i)]) + ";" + colour("fill", p.paper));
    rule("text.t" + n, colour("fill", p.series[static_cast<std::size_t>(i)]));
  }
  rule(".thin", "stroke-width:1");
  rule(".thick", "stroke-width:2.5");
  rule(".mid", "stroke-width:1.5");
  rule(".dash1", "stroke-dasharray:7 4");
  rule(".dash2", "stroke-dasharray:2 3");
  rule(".dash3", "stroke-dasharray:10 3 2 3");
  rule(".dash4", "stroke-dasharray:4 2");
  return css;
}

Svg::Svg(double width, double height, std::string description)
    : width_(width), height_(height), description_(std::move(description)) {
  KLANG_CHECK(width > 0 && height > 0, "a drawing needs an area");
}

void Svg::line(double x1, double y1, double x2, double y2, std::string_view classes) {
  body_ += "<line class=\"" + std::string(classes) + "\" x1=\"" + coordinate(x1) + "\" y1=\"" + coordinate(y1) +
           "\" x2=\"" + coordinate(x2) + "\" y2=\"" + coordinate(y2) + "\"/>\n";
}

void Svg::rect(double x, double y, double width, double height, std::string_view classes, double radius) {
  body_ += "<rect class=\"" + std::string(classes) + "\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) +
           "\" width=\"" + coordinate(std::max(width, 0.0)) + "\" height=\"" + coordinate(std::max(height, 0.0)) +
           (radius > 0 ? "\" rx=\"" + coordinate(radius) : "") + "\"/>\n";
}

void Svg::polyline(const std::vector<PlotPoint>& points, std::string_view classes, bool closed) {
  if (points.size() < 2) return;
  body_ += std::string(closed ? "<polygon" : "<polyline") + " class=\"" + std::string(classes) + "\" points=\"";
  for (const PlotPoint& point : points) body_ += coordinate(point.x) + "," + coordinate(point.y) + " ";
  body_.back() = '"';
  body_ += "/>\n";
}

void Svg::marker(int series, double x, double y, double radius, std::string_view tooltip, bool hollow) {
  const int kind = series % kSeriesCount;
  const std::string attributes = " class=\"" + std::string(hollow ? "h" : "m") + std::to_string(kind) + "\"";
  const std::string title = tooltip.empty() ? "/>\n" : "><title>" + escaped(tooltip) + "</title></";
  const auto polygon = [&](std::initializer_list<PlotPoint> corners) {
    body_ += "<polygon" + attributes + " points=\"";
    for (const PlotPoint& corner : corners) {
      body_ += coordinate(x + radius * corner.x) + "," + coordinate(y + radius * corner.y) + " ";
    }
    body_.back() = '"';
    body_ += title + (tooltip.empty() ? "" : "polygon>\n");
  };
  switch (kind) {
    case 1:
      polygon({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}});
      break;
    case 2:
      polygon({{0, -1.2}, {1.1, 0.8}, {-1.1, 0.8}});
      break;
    case 3:
      polygon({{0, -1.3}, {1.3, 0}, {0, 1.3}, {-1.3, 0}});
      break;
    case 4:
      polygon({{0, 1.2}, {1.1, -0.8}, {-1.1, -0.8}});
      break;
    case 5:
      polygon({{-0.4, -1.2},
               {0.4, -1.2},
               {0.4, -0.4},
               {1.2, -0.4},
               {1.2, 0.4},
               {0.4, 0.4},
               {0.4, 1.2},
               {-0.4, 1.2},
               {-0.4, 0.4},
               {-1.2, 0.4},
               {-1.2, -0.4},
               {-0.4, -0.4}});
      break;
    case 6:
      polygon({{-1.3, 0}, {-0.6, -1.1}, {0.6, -1.1}, {1.3, 0}, {0.6, 1.1}, {-0.6, 1.1}});
      break;
    case 7:
      polygon({{1.2, 0}, {-0.8, -1.1}, {-0.8, 1.1}});
      break;
    default:
      body_ += "<circle" + attributes + " cx=\"" + coordinate(x) + "\" cy=\"" + coordinate(y) + "\" r=\"" +
               coordinate(radius) + "\"" + title + (tooltip.empty() ? "" : "circle>\n");
  }
}

void Svg::text(double x, double y, std::string_view words, std::string_view classes, Anchor anchor, double turned_deg) {
  body_ += "<text class=\"" + std::string(classes) + "\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\"";
  if (anchor != Anchor::kStart) body_ += anchor == Anchor::kMiddle ? " text-anchor=\"middle\"" : " text-anchor=\"end\"";
  if (turned_deg != 0) {
    body_ += " transform=\"rotate(" + coordinate(turned_deg) + " " + coordinate(x) + " " + coordinate(y) + ")\"";
  }
  body_ += ">" + escaped(words) + "</text>\n";
}

void Svg::image(double x, double y, double width, double height, std::string_view data_uri) {
  body_ += "<image x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\" width=\"" + coordinate(width) +
           "\" height=\"" + coordinate(height) + "\" preserveAspectRatio=\"none\" href=\"" + std::string(data_uri) +
           "\"/>\n";
}

void Svg::begin_group(std::string_view title) { body_ += "<g><title>" + escaped(title) + "</title>\n"; }
void Svg::end_group() { body_ += "</g>\n"; }

std::string Svg::markup(std::string_view head) const {
  return "<svg class=\"kf\" role=\"img\" aria-label=\"" + escaped(description_) + "\" viewBox=\"0 0 " +
         coordinate(width_) + " " + coordinate(height_) + "\" width=\"" + coordinate(width_) + "\" height=\"" +
         coordinate(height_) + "\"" + std::string(head) + body_ + "</svg>\n";
}

std::string Svg::inline_markup() const { return markup(">\n"); }

std::string Svg::standalone() const {
  return markup(" xmlns=\"http://www.w3.org/2000/svg\">\n<style>" + figure_css(false) +
                "</style>\n<rect class=\"paper\" x=\"0\" y=\"0\" width=\"100%\" height=\"100%\"/>\n");
}

std::vector<Tick> axis_ticks(const AxisSpec& axis, int wanted) {
  std::vector<Tick> ticks;
  const auto add = [&](double value, bool labelled) {
    if (value < axis.low * (1 - 1e-12) - (axis.low < 0 ? -2e-12 * axis.low : 0) ||
        value > axis.high + 1e-12 * std::abs(axis.high))
      return;
    ticks.push_back({value, labelled ? power_label(number_label(value)) : std::string()});
  };
  if (axis.scale == Scale::kLog) {
    const int first = static_cast<int>(std::floor(std::log10(axis.low)));
    const int last = static_cast<int>(std::ceil(std::log10(axis.high)));
    const double decades = std::log10(axis.high) - std::log10(axis.low);
    const int every = std::max(1, static_cast<int>(std::ceil(decades / wanted)));
    if (decades < 0.35) {  // too short for round decimals of a log scale: linear steps
      AxisSpec linear = axis;
      linear.scale = Scale::kLinear;
      return axis_ticks(linear, wanted);
    }
    for (int decade = first; decade <= last; ++decade) {
      for (int digit = 1; digit <= 9; ++digit) {
        const double value = digit * std::pow(10.0, decade);
        const bool five = digit == 2 || digit == 5;
        const bool more = decades < 1.2 && (digit == 3 || digit == 7);
        const bool labelled =
            digit == 1 ? (decade % every == 0) : every == 1 && decades * 3 <= wanted + 3 && (five || more);
        if (every == 1 || digit == 1) add(value, labelled);
      }
    }
    return ticks;
  }
  const double raw = (axis.high - axis.low) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = power * (raw / power <= 1.0 + 1e-9   ? 1
                               : raw / power <= 2.0 + 1e-9 ? 2
                               : raw / power <= 5.0 + 1e-9 ? 5
                                                           : 10);
  const double first = std::ceil(axis.low / step - 1e-9);
  for (int i = 0; i < 200; ++i) {
    const double value = (first + i) * step;
    if (value > axis.high + 1e-9 * step) break;
    ticks.push_back({value, number_label(std::abs(value) < 1e-9 * step ? 0.0 : value)});
  }
  return ticks;
}

namespace {

constexpr double kLargestOnAxis = 1e100, kSmallestOnLogAxis = 1e-100;  // sums and ratios of what is shown stay finite

/// An axis with an extent, whatever a result file says: a page with an absurd number in it is still a page.
AxisSpec drawable(AxisSpec axis) {
  const bool log = axis.scale == Scale::kLog;
  const double lowest = log ? kSmallestOnLogAxis : -kLargestOnAxis;
  axis.low = std::isfinite(axis.low) ? std::clamp(axis.low, lowest, kLargestOnAxis) : (log ? 1.0 : 0.0);
  axis.high = std::isfinite(axis.high) ? std::clamp(axis.high, lowest, kLargestOnAxis) : axis.low;
  const double least = axis.low + std::max(1e-9 * std::abs(axis.low), log ? 0.0 : 1e-300);
  if (!(axis.high > least))
    axis.high = log ? 2.0 * axis.low : axis.low + (axis.low != 0.0 ? 0.1 * std::abs(axis.low) : 1.0);
  return axis;
}

}  // namespace

AxisSpec axis_around(std::string label, Scale scale, const std::vector<double>& values, double margin) {
  AxisSpec axis{std::move(label), scale, 0, 0, true};
  bool any = false;
  const double lowest = scale == Scale::kLog ? kSmallestOnLogAxis : -kLargestOnAxis;
  for (double value : values) {
    if (!std::isfinite(value) || (scale == Scale::kLog && !(value > 0))) continue;
    value = std::clamp(value, lowest, kLargestOnAxis);
    axis.low = any ? std::min(axis.low, value) : value;
    axis.high = any ? std::max(axis.high, value) : value;
    any = true;
  }
  if (scale == Scale::kLog) {
    if (!any) return {axis.label, scale, 1, 10, true};
    const double factor = std::max(std::exp(margin * (std::log(axis.high) - std::log(axis.low))), 1.08);
    axis.low /= factor;
    axis.high *= factor;
    return drawable(std::move(axis));
  }
  if (!any) return {axis.label, scale, 0, 1, true};
  double pad = margin * (axis.high - axis.low);
  if (!(pad > 0)) pad = axis.high != 0 ? 0.1 * std::abs(axis.high) : 1.0;
  pad = std::max(pad, kLeastExtent * std::max(std::abs(axis.low), std::abs(axis.high)));
  axis.low -= pad;
  axis.high += pad;
  return drawable(std::move(axis));
}

Frame::Frame(Svg& svg, const PlotArea& area, AxisSpec x, AxisSpec y)
    : svg_(svg),
      left_(area.left),
      top_(area.top),
      width_(area.width),
      height_(area.height),
      x_axis_(drawable(std::move(x))),
      y_axis_(drawable(std::move(y))) {}

namespace {
double fraction(const AxisSpec& axis, double value) {
  if (axis.scale == Scale::kLog)
    return (std::log(std::max(value, kSmallestOnLogAxis)) - std::log(axis.low)) /
           (std::log(axis.high) - std::log(axis.low));
  return (value - axis.low) / (axis.high - axis.low);
}
}  // namespace

double Frame::x(double value) const { return left_ + width_ * fraction(x_axis_, value); }
double Frame::y(double value) const { return top_ + height_ * (1 - fraction(y_axis_, value)); }

bool Frame::shows(double x_value, double y_value) const {
  return x_value >= x_axis_.low && x_value <= x_axis_.high && y_value >= y_axis_.low && y_value <= y_axis_.high;
}

void Frame::draw_axes(int x_ticks, int y_ticks, bool x_grid, bool y_grid) {
  for (const Tick& tick : axis_ticks(x_axis_, x_ticks)) {
    const double at = x(tick.value);
    if (x_grid && !tick.label.empty()) svg_.line(at, top_, at, bottom(), "grid");
    svg_.line(at, bottom(), at, bottom() + (tick.label.empty() ? 3 : 5), "axis");
    if (x_axis_.labelled) svg_.text(at, bottom() + 18, tick.label, "muted small", Anchor::kMiddle);
  }
  for (const Tick& tick : axis_ticks(y_axis_, y_ticks)) {
    const double at = y(tick.value);
    if (y_grid && !tick.label.empty()) svg_.line(left_, at, right(), at, "grid");
    svg_.line(left_ - (tick.label.empty() ? 3 : 5), at, left_, at, "axis");
    if (y_axis_.labelled) svg_.text(left_ - 8, at + 4, tick.label, "muted small", Anchor::kEnd);
  }
  svg_.line(left_, bottom(), right(), bottom(), "axis");
  svg_.line(left_, top_, left_, bottom(), "axis");
  if (x_axis_.labelled) svg_.text((left_ + right()) / 2, bottom() + 36, x_axis_.label, "muted", Anchor::kMiddle);
  if (y_axis_.labelled) svg_.text(left_ - 50, (top_ + bottom()) / 2, y_axis_.label, "muted", Anchor::kMiddle, -90);
}

void Frame::curve(const std::vector<PlotPoint>& values, std::string_view classes) {
  std::vector<PlotPoint> run;
  const auto flush = [&] {
    svg_.polyline(run, classes);
    run.clear();
  };
  const auto usable = [&](const PlotPoint& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && (x_axis_.scale == Scale::kLinear || p.x > 0) &&
           (y_axis_.scale == Scale::kLinear || p.y > 0);
  };
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    if (!usable(values[i]) || !usable(values[i + 1])) {
      flush();
      continue;
    }
    const PlotPoint a{x(values[i].x), y(values[i].y)}, b{x(values[i + 1].x), y(values[i + 1].y)};
    // Liang and Barsky: the part of a-b inside the frame, as parameters from 0 to 1.
    double from = 0, to = 1;
    const auto cut = [&](double direction, double distance) {
      if (direction == 0) {
        if (distance < 0) to = -1;
      } else if (direction < 0) {
        from = std::max(from, distance / direction);
      } else {
        to = std::min(to, distance / direction);
      }
    };
    cut(a.x - b.x, a.x - left_);
    cut(b.x - a.x, right() - a.x);
    cut(a.y - b.y, a.y - top_);
    cut(b.y - a.y, bottom() - a.y);
    if (!(from <= to)) {
      flush();
      continue;
    }
    if (from > 0) flush();
    if (run.empty()) run.push_back({a.x + from * (b.x - a.x), a.y + from * (b.y - a.y)});
    run.push_back({a.x + to * (b.x - a.x), a.y + to * (b.y - a.y)});
    if (to < 1) flush();
  }
  flush();
}

void Frame::error_bar(double x_value, double y_low, double y_high, std::string_view classes) {
  if (!(x_value >= x_axis_.low && x_value <= x_axis_.high)) return;
  const double at = x(x_value);
  const double upper = std::clamp(y(std::min(y_high, y_axis_.high)), top_, bottom());
  const double lower = std::clamp(y(std::max(y_low, y_axis_.low)), top_, bottom());
  svg_.line(at, upper, at, lower, classes);
  if (y_high <= y_axis_.high) svg_.line(at - 3, upper, at + 3, upper, classes);
  if (y_low >= y_axis_.low) svg_.line(at - 3, lower, at + 3, lower, classes);
}

std::vector<double> spread_labels(std::vector<double> positions, double spacing, double low, double high) {
  const std::size_t n = positions.size();
  if (n == 0) return positions;
  spacing = std::min(spacing, (high - low) / static_cast<double>(n));
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return positions[a] < positions[b]; });
  // Blocks of touching labels sit at the mean of what their members want (pool adjacent violators).
  struct Block {
    double wanted_first;  ///< mean over members of (wanted position - rank * spacing)
    std::size_t count;
  };
  std::vector<Block> blocks;
  for (const std::size_t index : order) {
    blocks.push_back({positions[index], 1});
    while (blocks.size() > 1) {
      Block& before = blocks[blocks.size() - 2];
      const Block& last = blocks.back();
      if (before.wanted_first + spacing * static_cast<double>(before.count) <= last.wanted_first) break;
      const double total = static_cast<double>(before.count + last.count);
      before.wanted_first =
          (before.wanted_first * static_cast<double>(before.count) +
           (last.wanted_first - spacing * static_cast<double>(before.count)) * static_cast<double>(last.count)) /
          total;
      before.count += last.count;
      blocks.pop_back();
    }
  }
  std::vector<double> result(n);
  std::size_t rank = 0;
  for (const Block& block : blocks) {
    for (std::size_t k = 0; k < block.count; ++k, ++rank) {
      result[order[rank]] = block.wanted_first + spacing * static_cast<double>(k);
    }
  }
  // Into the range, keeping the spacing: from below, then from above.
  double floor_at = low;
  for (const std::size_t index : order) {
    result[index] = std::max(result[index], floor_at);
    floor_at = result[index] + spacing;
  }
  double ceiling = high;
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    result[*it] = std::min(result[*it], ceiling);
    ceiling = result[*it] - spacing;
  }
  return result;
}

}  // namespace klang::reports
