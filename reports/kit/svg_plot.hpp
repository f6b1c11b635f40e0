#pragma once
#include <string>
#include <string_view>
#include <vector>

/// A small plotting layer that writes SVG. Shapes carry classes, not colours: the page colours them for light
/// and dark screens, a file of its own gets the light palette in a style element.
namespace klang::reports {

/// Rules for the classes below, each prefixed by "svg.kf ".
///   ink, muted (text), axis, grid, rule (lines), paper (fill), s0-s7 (stroke and marker fill of a series),
///   accent, ghost, alarm, thin, mid, thick, dash1-dash4, small, tiny, strong, halo (text with a rim of
///   paper)
std::string figure_css(bool dark);

inline constexpr int kSeriesCount = 8;

struct PlotPoint {
  double x = 0, y = 0;
};

enum class Anchor { kStart, kMiddle, kEnd };

/// A drawing; coordinates in CSS pixels from the upper left corner.
class Svg {
 public:
  Svg(double width, double height, std::string description);
  void line(double x1, double y1, double x2, double y2, std::string_view classes);
  void rect(double x, double y, double width, double height, std::string_view classes, double radius = 0);
  void polyline(const std::vector<PlotPoint>& points, std::string_view classes, bool closed = false);
  /// Marker of series 0-7: its own shape and colour. tooltip may be empty.
  void marker(int series, double x, double y, double radius, std::string_view tooltip, bool hollow = false);
  void text(double x, double y, std::string_view words, std::string_view classes, Anchor anchor = Anchor::kStart,
            double turned_deg = 0);
  /// An image given as a data URI, stretched to the rectangle.
  void image(double x, double y, double width, double height, std::string_view data_uri);
  /// Encloses what is drawn until end_group; the title shows under a pointer.
  void begin_group(std::string_view title);
  void end_group();

  double width() const { return width_; }
  double height() const { return height_; }
  const std::string& description() const { return description_; }
  /// For the page: no colours of its own.
  std::string inline_markup() const;
  /// A file that any viewer shows: light palette, white ground.
  std::string standalone() const;

 private:
  std::string markup(std::string_view head) const;
  double width_, height_;
  std::string description_, body_;
};

enum class Scale { kLinear, kLog };

struct AxisSpec {
  std::string label;
  Scale scale = Scale::kLinear;
  double low = 0, high = 1;  ///< low < high, both > 0 on a log scale; an axis without extent is given one
  bool labelled = true;      ///< tick labels and axis label are drawn
};

struct Tick {
  double value = 0;
  std::string label;  ///< empty: a minor tick
};

/// Round values (1, 2 or 5 times a power of ten) that divide the axis into about `wanted` parts.
std::vector<Tick> axis_ticks(const AxisSpec& axis, int wanted);

/// A range that holds all values with a margin; for a log scale values <= 0 do not count. Sane for no or one
/// value.
AxisSpec axis_around(std::string label, Scale scale, const std::vector<double>& values, double margin = 0.06);

struct PlotArea {
  double left, top, width, height;
};

/// The area between two axes.
class Frame {
 public:
  Frame(Svg& svg, const PlotArea& area, AxisSpec x, AxisSpec y);
  /// Grid, ticks, labels and the frame's lines; call first.
  void draw_axes(int x_ticks = 7, int y_ticks = 6, bool x_grid = true, bool y_grid = true);
  double x(double value) const;
  double y(double value) const;
  bool shows(double x_value, double y_value) const;
  /// A curve cut at the frame; values that an axis cannot show are left out.
  void curve(const std::vector<PlotPoint>& values, std::string_view classes);
  /// Vertical bar with caps from low to high, cut at the frame.
  void error_bar(double x_value, double y_low, double y_high, std::string_view classes);
  double left() const { return left_; }
  double right() const { return left_ + width_; }
  double top() const { return top_; }
  double bottom() const { return top_ + height_; }

 private:
  Svg& svg_;
  double left_, top_, width_, height_;
  AxisSpec x_axis_, y_axis_;
};

/// Moves label positions apart so that neighbours are at least `spacing` away and all lie in [low, high]
/// where that is possible; order is kept and the total shift small. Positions need not be sorted.
std::vector<double> spread_labels(std::vector<double> positions, double spacing, double low, double high);

}  // namespace klang::reports
