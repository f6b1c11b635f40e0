#include "reports/pages/papers_page.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

std::size_t count_of(const PapersData& data, std::string_view verdict) {
  return static_cast<std::size_t>(std::count_if(data.numbers.begin(), data.numbers.end(),
                                                [&](const PaperRow& row) { return row.verdict == verdict; }));
}

std::string pill(const std::string& verdict) {
  const char* kind = verdict == "agrees" ? "good" : verdict == "paper is off" ? "fair" : "bad";
  return "<span class=\"tag " + std::string(kind) + "\">" + escaped(verdict) + "</span>";
}

std::string row_html(const PaperRow& row) {
  const bool known = row.printed && row.ours && *row.printed != 0;
  const double difference = known ? 100 * (*row.ours / *row.printed - 1) : 0;
  return "<tr>" +
         tag("th", escaped(row.quantity) + (row.note.empty() ? "" : "<br><small>" + escaped(row.note) + "</small>"),
             "scope=\"row\"") +
         number_cell(row.printed ? rounded(*row.printed, 6) : "—") +
         number_cell(row.ours ? rounded(*row.ours, 6) : "—") +
         number_cell(known ? (difference > 0 ? "+" : "") + rounded(difference, 2) + " %" : "—") +
         number_cell(row.reference
                         ? rounded(*row.reference, 6) + "<br><small>" + escaped(row.reference_source) + "</small>"
                         : "—") +
         number_cell(row.tolerance ? rounded(100 * *row.tolerance, 2) + " %<br><small>" +
                                         escaped(row.tolerance_source) + "</small>"
                                   : "—") +
         tag("td", pill(row.verdict)) + "</tr>\n";
}

}  // namespace

std::vector<std::pair<std::string, std::string>> papers_sections(const PapersData& data) {
  std::vector<std::pair<std::string, std::string>> sections;
  std::string body, title;
  const auto close = [&] {
    if (body.empty()) return;
    sections.emplace_back(title, scrolled("<table><thead><tr><th scope=\"col\">Quantity</th><th scope=\"col\" "
                                          "class=\"n\">Printed</th><th scope=\"col\" class=\"n\">Ours</th><th "
                                          "scope=\"col\" class=\"n\">Difference</th><th scope=\"col\" "
                                          "class=\"n\">Reference</th><th scope=\"col\" class=\"n\">Tolerance</th><th "
                                          "scope=\"col\">Verdict</th></tr></thead>\n<tbody>" +
                                              body + "</tbody></table>",
                                          title));
    body.clear();
  };
  for (const PaperRow& row : data.numbers) {
    const std::string here = escaped(row.paper + ", " + row.place);
    if (here != title) close();
    title = here;
    body += row_html(row);
  }
  close();
  for (const PaperGapRow& gap : data.gaps)
    body += "<tr>" + tag("td", escaped(gap.paper)) + tag("td", escaped(gap.place)) + tag("td", escaped(gap.reason)) +
            "</tr>\n";
  if (!body.empty())
    sections.emplace_back("Not computed",
                          scrolled("<table><thead><tr><th scope=\"col\">Paper</th><th scope=\"col\">Where</th><th "
                                   "scope=\"col\">Why</th></tr></thead>\n<tbody>" +
                                       body + "</tbody></table>",
                                   "Not computed"));
  return sections;
}

std::string papers_key_figures(const PapersData& data) {
  std::string html;
  for (const auto& [name, verdict] :
       {std::pair{"Agree", "agrees"}, {"Off in the paper", "paper is off"}, {"Differ", "differs"}})
    html += "<div><dt>" + std::string(name) + "</dt><dd>" + std::to_string(count_of(data, verdict)) +
            tag("small", "of " + std::to_string(data.numbers.size())) + "</dd></div>";
  return "<dl class=\"keys\">" + html + "</dl>\n";
}

std::vector<std::string> papers_sentences(const PapersData& data) {
  std::vector<std::string> sentences = {
      "Of <b>" + counted(data.numbers.size(), "number", "numbers") +
      "</b> that the papers print and this program can compute, <b>" + std::to_string(count_of(data, "agrees")) +
      "</b> agree; <b>" + std::to_string(count_of(data, "paper is off")) +
      "</b> are misprinted or inaccurate in the paper, and the table says how that is known."};
  for (const PaperRow& row : data.numbers) {
    if (row.verdict == "differs")
      sentences.push_back("Open: " + escaped(row.paper + ", " + row.place + ", " + row.quantity) + ".");
  }
  return sentences;
}

}  // namespace klang::reports::detail
