#include "reports/pages/key_figures.hpp"

#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {

void KeyFigures::add(const std::string& name, const std::string& value, const std::string& note) {
  html_ += "<div><dt>" + name + "</dt><dd>" + value + (note.empty() ? "" : tag("small", note)) + "</dd></div>";
}

std::string KeyFigures::html() const { return html_.empty() ? "" : "<dl class=\"keys\">" + html_ + "</dl>\n"; }

}  // namespace klang::reports::detail
