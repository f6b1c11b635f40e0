// The page of klang validate papers.
#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "validate/papers/papers.hpp"

namespace klang::reports::detail {
namespace {

std::size_t count_of(const validate::PapersDocument& data, validate::PaperVerdict verdict) {
  return static_cast<std::size_t>(
      std::count_if(data.numbers.begin(), data.numbers.end(),
                    [&](const validate::PaperNumber& row) { return row.verdict == verdict; }));
}

std::string pill(validate::PaperVerdict verdict) {
  const char* kind = verdict == validate::PaperVerdict::kAgrees     ? "good"
                     : verdict == validate::PaperVerdict::kPaperOff ? "fair"
                                                                    : "bad";
  return "<span class=\"tag " + std::string(kind) + "\">" + escaped(to_text(verdict)) + "</span>";
}

std::string row_html(const validate::PaperNumber& row) {
  const bool known = std::isfinite(row.printed) && std::isfinite(row.ours) && row.printed != 0;
  const double difference = known ? 100 * (row.ours / row.printed - 1) : 0;
  return "<tr>" +
         tag("th", escaped(row.quantity) + (row.note.empty() ? "" : "<br><small>" + escaped(row.note) + "</small>"),
             "scope=\"row\"") +
         number_cell(rounded(row.printed, 6), row.printed) +
         number_cell(rounded(row.ours, 6) + "<br><small>" + escaped(to_text(row.source)) + "</small>", row.ours) +
         number_cell(known ? (difference > 0 ? "+" : "") + rounded(difference, 2) + " %" : "—") +
         number_cell(row.reference
                         ? rounded(*row.reference, 6) + "<br><small>" + escaped(row.reference_source) + "</small>"
                         : "—",
                     row.reference) +
         number_cell(std::isfinite(row.tolerance) ? rounded(100 * row.tolerance, 2) + " %<br><small>" +
                                                        escaped(row.tolerance_source) + "</small>"
                                                  : "—",
                     std::isfinite(row.tolerance) ? Number(100 * row.tolerance) : Number()) +
         tag("td", pill(row.verdict)) + "</tr>\n";
}

std::string scene_row_html(const validate::PaperScene& row) {
  const auto number = [](const std::optional<double>& value, const char* none) {
    return number_cell(value ? rounded(*value, 4) : none, value);
  };
  const char* kind = row.verdict == validate::SceneVerdict::kAgrees      ? "good"
                     : row.verdict == validate::SceneVerdict::kSameOrder ? "fair"
                                                                         : "";
  return "<tr>" + tag("td", escaped(row.paper + ", " + row.place)) +
         tag("th",
             escaped(row.scene) + "<br><small>" + escaped(row.quantity + (row.note.empty() ? "" : "; " + row.note)) +
                 "</small>",
             "scope=\"row\"") +
         number(row.printed, "—") + number(row.ours, "—") +
         tag("td",
             "<span class=\"tag " + std::string(kind) + "\">" + escaped(validate::verdict_words(row)) + "</span>") +
         tag("td", row.ours ? "<small>" + escaped(row.command + ", " + row.version) + "</small>" : "—") + "</tr>\n";
}

std::vector<Section> sections_of(const validate::PapersDocument& data) {
  std::vector<Section> sections;
  std::string body, title;
  const auto close = [&] {
    if (body.empty()) return;
    sections.push_back({"table-" + std::to_string(sections.size()), title,
                        scrolled("<table><thead><tr><th scope=\"col\">Quantity</th><th scope=\"col\" "
                                 "class=\"n\">Printed</th><th scope=\"col\" class=\"n\">Ours</th><th "
                                 "scope=\"col\" class=\"n\">Difference</th><th scope=\"col\" "
                                 "class=\"n\">Reference</th><th scope=\"col\" class=\"n\">Tolerance</th><th "
                                 "scope=\"col\">Verdict</th></tr></thead>\n<tbody>" +
                                     body + "</tbody></table>",
                                 title)});
    body.clear();
  };
  for (const validate::PaperNumber& row : data.numbers) {
    const std::string here = escaped(row.paper + ", " + row.place);
    if (here != title) close();
    title = here;
    body += row_html(row);
  }
  close();
  for (const validate::PaperScene& row : data.scenes) body += scene_row_html(row);
  if (!body.empty())
    sections.push_back({"table-" + std::to_string(sections.size()), "Scenes, run by hand",
                        "<p>Sizes, strengths and falls that a paper does not give are ours: no part of the verdict. "
                        "Agrees: within a tenth; same order: within a factor of two.</p>" +
                            scrolled("<table><thead><tr><th scope=\"col\">Paper</th><th scope=\"col\">Scene</th><th "
                                     "scope=\"col\" class=\"n\">Printed</th><th scope=\"col\" class=\"n\">Ours</th><th "
                                     "scope=\"col\">Verdict</th><th scope=\"col\">Made by</th></tr></thead>\n<tbody>" +
                                         body + "</tbody></table>",
                                     "Scenes, run by hand")});
  body.clear();
  for (const validate::PaperGap& gap : data.not_computed)
    body += "<tr>" + tag("td", escaped(gap.paper)) + tag("td", escaped(gap.place)) + tag("td", escaped(gap.reason)) +
            "</tr>\n";
  if (!body.empty())
    sections.push_back({"table-" + std::to_string(sections.size()), "Not computed",
                        scrolled("<table><thead><tr><th scope=\"col\">Paper</th><th scope=\"col\">Where</th><th "
                                 "scope=\"col\">Why</th></tr></thead>\n<tbody>" +
                                     body + "</tbody></table>",
                                 "Not computed")});
  return sections;
}

std::string key_figures(const validate::PapersDocument& data) {
  KeyFigures keys;
  for (const auto& [name, verdict] : {std::pair{"Agree", validate::PaperVerdict::kAgrees},
                                      {"Off in the paper", validate::PaperVerdict::kPaperOff},
                                      {"Differ", validate::PaperVerdict::kDiffers}})
    keys.add(name, std::to_string(count_of(data, verdict)), "of " + std::to_string(data.numbers.size()));
  return keys.html();
}

std::vector<std::string> sentences_of(const validate::PapersDocument& data) {
  const auto of_source = [&](validate::NumberSource source) {
    return std::to_string(std::count_if(data.numbers.begin(), data.numbers.end(),
                                        [&](const validate::PaperNumber& row) { return row.source == source; }));
  };
  std::vector<std::string> sentences = {
      "Of <b>" + counted(data.numbers.size(), "number", "numbers") + "</b> that the papers print, <b>" +
          of_source(validate::NumberSource::kProgram) + "</b> are computed by the program, " +
          of_source(validate::NumberSource::kPaper) + " hold the paper against itself, " +
          of_source(validate::NumberSource::kElsewhere) + " hold it against a value from elsewhere.",
      "<b>" + std::to_string(count_of(data, validate::PaperVerdict::kAgrees)) + "</b> agree; <b>" +
          std::to_string(count_of(data, validate::PaperVerdict::kPaperOff)) +
          "</b> are misprinted or inaccurate in the paper, and the table says how that is known. Tolerances that begin "
          "with <i>chosen</i> are ours: neither printed digits nor a theory give them."};
  for (const validate::PaperNumber& row : data.numbers) {
    if (row.verdict == validate::PaperVerdict::kDiffers)
      sentences.push_back("Open: " + escaped(row.paper + ", " + row.place + ", " + row.quantity) + ".");
  }
  return sentences;
}

Page make(const validate::PapersDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · published numbers";
  page.title = "The papers’ numbers";
  const bool passed = data.header.status == "passed";
  page.verdict = {passed ? "Passed" : "Not passed", passed ? "good" : "bad", data.header.message.value_or("")};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  page.sections = sections_of(data);
  add_if_there("junit.xml", "– the claims for a test report", folder, page.downloads);
  return page;
}

}  // namespace

PageKind papers_page() { return page_kind<validate::PapersDocument>("papers", make); }

}  // namespace klang::reports::detail
