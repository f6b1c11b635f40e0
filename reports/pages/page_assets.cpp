#include "reports/pages/page_assets.hpp"

#include "reports/kit/raster.hpp"
#include "reports/kit/svg_plot.hpp"
#include "reports/pages/web_files.hpp"

namespace klang::reports::detail {
namespace {

constexpr std::string_view kSpectrum = "data-figure=\"spectrum\"", kShape = "data-figure=\"shape\"";

bool has(std::string_view html, std::string_view what) { return html.find(what) != std::string_view::npos; }

/// As a data URI: what a library's text may hold (a tag's end, an address) is nothing that the page says.
std::string packed_script(std::string_view text) {
  return "<script src=\"" + data_uri("text/javascript", text) + "\"></script>\n";
}

}  // namespace

std::string page_css(std::string_view content) {
  return std::string(has(content, kSpectrum) ? kUplotCss : "") + std::string(kPageCss) + figure_css(false) +
         "@media screen and (prefers-color-scheme:dark){\n" + figure_css(true) + "}\n";
}

std::string page_scripts(std::string_view content) {
  std::string scripts = "<script>" + std::string(kPageJs) + "</script>\n";
  if (has(content, kSpectrum)) scripts += packed_script(kUplotJs) + packed_script(kSpectrumJs);
  if (has(content, kShape)) scripts += packed_script(kThreeJs) + packed_script(kShapeJs);
  return scripts;
}

}  // namespace klang::reports::detail
