#pragma once
#include <string_view>

/// The files of web/, which the build puts into the program.
namespace klang::reports::detail {

extern const std::string_view kPageCss, kPageJs, kSpectrumJs, kShapeJs;
extern const std::string_view kUplotCss, kUplotJs, kThreeJs;

}  // namespace klang::reports::detail
