#include "reports/pages/page_parts.hpp"

#include "reports/kit/text.hpp"

namespace klang::reports::detail {

std::string tag(std::string_view name, std::string_view content, std::string_view attributes) {
  return "<" + std::string(name) + (attributes.empty() ? "" : " " + std::string(attributes)) + ">" +
         std::string(content) + "</" + std::string(name) + ">";
}
std::string number_cell(std::string_view content) { return tag("td", content, "class=\"n\""); }

std::string figure(const std::string& content, const std::string& caption) {
  return "<figure>" + content + (caption.empty() ? "" : tag("figcaption", caption)) + "</figure>\n";
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
  std::string text;
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

std::string provenance(const ResultData& data) {
  std::string rows;
  const auto row = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) rows += "<tr>" + tag("th", name, "scope=\"row\"") + tag("td", value) + "</tr>\n";
  };
  row("Made by", data.version.empty() ? "" : "klang " + escaped(data.version));
  row("Command", data.command.empty() ? "" : "<code>" + escaped(data.command) + "</code>");
  row("Seed", escaped(data.seed));
  if (data.cost_initial && data.cost_final)
    row("Cost", rounded(*data.cost_initial, 4) + " → " + rounded(*data.cost_final, 4));
  std::string times;
  for (const auto& [name, seconds] : data.wall_time_s)
    times += (times.empty() ? "" : ", ") + escaped(name) + " " + rounded(seconds, 3) + " s";
  row("Time", times);
  std::string html = rows.empty() ? "" : "<table><tbody>" + rows + "</tbody></table>\n";
  if (!data.inputs.empty()) {
    std::string inputs;
    for (const ProvenanceInput& input : data.inputs) {
      inputs += "<tr>" + tag("td", escaped(input.path)) + number_cell(input.n_bytes ? fixed(*input.n_bytes, 0) : "—") +
                tag("td", escaped(input.sha256), "class=\"hash\"") + "</tr>\n";
    }
    html += scrolled(
        "<table><thead><tr><th scope=\"col\">Input</th><th scope=\"col\" class=\"n\">Bytes</th><th "
        "scope=\"col\">SHA-256</th></tr></thead><tbody>" +
            inputs + "</tbody></table>",
        "Inputs");
  }
  if (!data.options.empty() && data.options != "{}" && data.options != "null")
    html += more("Options", "<pre>" + escaped(data.options) + "</pre>");
  return html;
}

}  // namespace klang::reports::detail
