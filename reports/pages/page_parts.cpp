#include "reports/pages/page_parts.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports::detail {

std::string tag(std::string_view name, std::string_view content, std::string_view attributes) {
  return "<" + std::string(name) + (attributes.empty() ? "" : " " + std::string(attributes)) + ">" +
         std::string(content) + "</" + std::string(name) + ">";
}
std::string number_cell(std::string_view content, const Number& value) {
  return tag(
      "td", content,
      value && std::isfinite(*value) ? "class=\"n\" data-value=\"" + klang::to_text(*value) + "\"" : "class=\"n\"");
}

std::string figure(const std::string& content, const std::string& caption, const std::string& name) {
  return (name.empty() ? "<figure>" : "<figure data-figure=\"" + name + "\">") + content +
         (caption.empty() ? "" : tag("figcaption", caption)) + "</figure>\n";
}
std::string sheet(const Svg& svg) {
  return "<div class=\"sheet scroll\" tabindex=\"0\" role=\"group\" aria-label=\"Figure, scrolls sideways on "
         "a small screen\">" +
         svg.inline_markup() + "</div>";
}
std::string scrolled(const std::string& table, const std::string& label) {
  return "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"" + escaped(label) + "\">" + table +
         "</div>\n";
}
std::string more(const std::string& title, const std::string& content) {
  return "<details class=\"more\"><summary>" + title + "</summary>" + content + "</details>\n";
}

std::string encoded_path(const std::string& path) {
  std::string text = "./";  // never a scheme or another host
  static constexpr char kHex[] = "0123456789ABCDEF";
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                       c == '_' || c == '.' || c == '/';
    if (plain) {
      text += c;
    } else {
      text += '%';
      text += kHex[byte >> 4];
      text += kHex[byte & 15];
    }
  }
  return text;
}

}  // namespace klang::reports::detail
