#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "reports/kit/svg_plot.hpp"

/// What several figures share.
namespace klang::reports::detail {

inline constexpr double kPageWidth = 1080;

/// A figure of a page.
struct CaptionedFigure {
  Svg svg;
  std::string stem;     ///< of its files
  std::string caption;  ///< HTML
};

/// Cut at a whole UTF-8 character, with an ellipsis.
std::string label_of(const std::string& name, std::size_t longest = 16);

/// "s3": prefix and number of the series' colours.
std::string series_class(std::string_view prefix, std::size_t index);

/// Markers with names in a row, as many as there is room for.
void legend(Svg& svg, double left, double top, const std::vector<std::string>& names);

/// Axes as wide as the page under a legend of the curves' names.
Frame axes_under_legend(Svg& svg, double height, const std::vector<std::string>& names, const AxisSpec& x,
                        const AxisSpec& y);

}  // namespace klang::reports::detail
