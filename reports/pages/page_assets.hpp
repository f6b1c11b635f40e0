#pragma once
#include <string>
#include <string_view>

namespace klang::reports::detail {

/// Style sheet of a page with this content: its own, that of the plots it holds, and the figures' colours.
std::string page_css(std::string_view content);
/// Script elements for this content: what every page can do, and the libraries of the figures in it, embedded.
std::string page_scripts(std::string_view content);

}  // namespace klang::reports::detail
