#include "reports/pages/plot_parts.hpp"

namespace klang::reports::detail {

std::string label_of(const std::string& name, std::size_t longest) {
  if (name.size() <= longest) return name;
  std::string_view cut = std::string_view(name).substr(0, longest - 1);
  while (!cut.empty() && (static_cast<unsigned char>(name[cut.size()]) & 0xc0) == 0x80) cut.remove_suffix(1);
  return std::string(cut) + "…";
}

std::string series_class(std::string_view prefix, std::size_t index) {
  return std::string(prefix) + std::to_string(index % kSeriesCount);
}

void legend(Svg& svg, double left, double top, const std::vector<std::string>& names) {
  double x = left;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name = label_of(names[i]);
    const double width = 26 + 7.0 * static_cast<double>(name.size());
    if (x + width > kPageWidth - 10) return;
    svg.marker(static_cast<int>(i % kSeriesCount), x + 6, top - 4, 4.5, "");
    svg.text(x + 16, top, name, "small");
    x += width;
  }
}

Frame axes_under_legend(Svg& svg, double height, const std::vector<std::string>& names, const AxisSpec& x,
                        const AxisSpec& y) {
  constexpr double kLeft = 76, kTop = 40, kRight = 24, kBelow = 48;
  legend(svg, kLeft, 16, names);
  Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - kRight, height - kTop - kBelow}, x, y);
  frame.draw_axes(9, 6);
  return frame;
}

}  // namespace klang::reports::detail
