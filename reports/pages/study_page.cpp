#include "reports/pages/study_page.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

std::string pill(bool passed, bool counts = true) {
  if (!counts) return "<span class=\"tag\">for comparison</span>";
  return passed ? "<span class=\"tag good\">passed</span>" : "<span class=\"tag bad\">not met</span>";
}

std::string order_noun(const StudySeries& series) { return series.kind == "geometric" ? "rate" : "order"; }

std::string expected_words(const StudySeries& series) {
  if (!series.expected_order) return "—";
  return rounded(*series.expected_order, 3) +
         (series.order_tolerance ? " ± " + rounded(*series.order_tolerance, 2) : "") +
         (series.higher_is_fine ? " or higher" : "");
}

std::string interval_words(const StudySeries& series) {
  if (!series.order_ci95 || !series.expected_order) return "—";
  return fixed((*series.order_ci95)[0], 2) + " to " + fixed((*series.order_ci95)[1], 2);
}

/// What the verdict looks at: the finest level's error, the largest for round-off.
Number judged_error(const StudySeries& series) {
  if (series.levels.empty()) return {};
  if (series.kind != "round_off") return series.levels.back().error;
  Number largest;
  for (const StudyLevel& level : series.levels) {
    if (level.error) largest = std::max(largest.value_or(0), *level.error);
  }
  return largest;
}

std::string scientific(const Number& value, int digits = 2) { return value ? rounded(*value, digits) : "—"; }

std::string series_table(const StudyData& study) {
  std::string body;
  for (const StudySeries& series : study.series) {
    const auto n_used = std::count_if(series.levels.begin(), series.levels.end(),
                                      [](const StudyLevel& l) { return l.excluded.empty(); });
    body += "<tr>" + tag("th", escaped(series.title), "scope=\"row\"") + tag("td", pill(series.passed, series.counts)) +
            number_cell(series.observed_order && series.expected_order ? fixed(*series.observed_order, 3) : "—") +
            number_cell(interval_words(series)) + number_cell(expected_words(series)) +
            number_cell(std::to_string(series.levels.size()) +
                        (!series.expected_order || n_used == static_cast<long>(series.levels.size())
                             ? ""
                             : " (" + std::to_string(n_used) + " in the fit)")) +
            number_cell(scientific(judged_error(series))) + number_cell(scientific(series.error_tolerance)) + "</tr>\n";
  }
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Series</th><th scope=\"col\">Verdict</th><th scope=\"col\" "
      "class=\"n\">Observed "
      "order</th><th scope=\"col\" class=\"n\">95 % interval</th><th scope=\"col\" class=\"n\">Expected</th><th "
      "scope=\"col\" class=\"n\">Levels</th><th scope=\"col\" class=\"n\">Finest error</th><th scope=\"col\" "
      "class=\"n\">Allowed</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Orders of all series");
}

std::string level_table(const StudySeries& series) {
  const bool has_h =
      std::any_of(series.levels.begin(), series.levels.end(), [](const StudyLevel& l) { return l.h_m.has_value(); });
  const bool has_value =
      std::any_of(series.levels.begin(), series.levels.end(), [](const StudyLevel& l) { return l.value.has_value(); });
  std::string body;
  for (const StudyLevel& level : series.levels) {
    body += "<tr" + std::string(level.excluded.empty() || !series.expected_order ? "" : " class=\"open\"") + ">" +
            number_cell(has_h ? rounded(level.h_m.value_or(0), 4) : rounded(level.n.value_or(0), 7)) +
            number_cell(level.n_unknowns ? fixed(*level.n_unknowns, 0) : "—") +
            number_cell(scientific(level.error, 4)) +
            number_cell(level.pairwise_order ? fixed(*level.pairwise_order, 3) : "—");
    if (has_value) body += number_cell(level.value ? rounded(*level.value, 8) : "—");
    body += tag("td", !series.expected_order   ? ""
                      : level.excluded.empty() ? "in the fit"
                                               : escaped(level.excluded)) +
            "</tr>\n";
  }
  return scrolled("<table><thead><tr><th scope=\"col\" class=\"n\">" + escaped(capitalised(series.step)) +
                      "</th><th scope=\"col\" class=\"n\">" + (has_h ? "Unknowns" : "Numbers") +
                      "</th><th scope=\"col\" class=\"n\">Error</th><th "
                      "scope=\"col\" class=\"n\">Pairwise " +
                      order_noun(series) + "</th>" + (has_value ? "<th scope=\"col\" class=\"n\">Value</th>" : "") +
                      "<th scope=\"col\"></th></tr></thead>\n<tbody>" + body + "</tbody></table>",
                  "Levels of " + series.title);
}

std::string series_details(const StudySeries& series, std::size_t index) {
  std::string facts = "Error: " + escaped(series.error) + ". Reference: " + escaped(series.reference) + ".";
  if (series.error_floor && *series.error_floor > 0 && series.kind != "round_off")
    facts += " Levels at or below " + scientific(series.error_floor) + " (" + escaped(series.floor) +
             ") are left out of the fit.";
  if (series.asymptotic && series.expected_order)
    facts += *series.asymptotic
                 ? " The last two pairwise values agree within 15 %: the asymptotic range is reached."
                 : " The last two pairwise values still differ by more than 15 %: the asymptotic range is not reached.";
  if (series.gci_fine) {
    facts += " Grid convergence index of the value on the three finest levels: " + rounded(100 * *series.gci_fine, 3) +
             " % at apparent order " + fixed(series.gci_order.value_or(0), 2) +
             (series.gci_ratio ? ", asymptotic ratio " + fixed(*series.gci_ratio, 4) : "");
    if (series.gci_extrapolated)
      facts += "; extrapolated " + rounded(*series.gci_extrapolated, 8) +
               (series.gci_exact ? " (exact " + rounded(*series.gci_exact, 8) + ")" : "");
    facts += ".";
  }
  return "<details class=\"body\" id=\"series-" + std::to_string(index) + "\"" + (index == 0 ? " open" : "") +
         "><summary><h3>" + escaped(series.title) + "</h3><span class=\"shape\">" + escaped(series.verdict) +
         "</span>" + pill(series.passed, series.counts) + "</summary>\n<p class=\"how\"><small>" + facts +
         "</small></p>\n" + level_table(series) + "</details>\n";
}

std::string claim_table(const StudyData& study) {
  std::string body;
  for (const StudyClaim& claim : study.claims) {
    body += "<tr>" + tag("th", escaped(claim.words), "scope=\"row\"") + tag("td", pill(claim.passed)) +
            number_cell(scientific(claim.measured, 6)) + number_cell(scientific(claim.reference, 6)) +
            number_cell(scientific(claim.tolerance)) + "</tr>\n";
  }
  if (body.empty()) return {};
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Claim</th><th scope=\"col\">Verdict</th><th scope=\"col\" "
      "class=\"n\">Measured</th><th scope=\"col\" class=\"n\">Reference</th><th scope=\"col\" "
      "class=\"n\">Tolerance</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Claims");
}

std::string pictures(const StudyParts& parts) {
  std::string body;
  for (const StudyPicture& picture : parts.pictures) {
    body += "<figure><h3>" + escaped(picture.field.title) + "</h3>" + picture.svg.inline_markup() +
            tag("figcaption", escaped(picture.field.caption)) + "</figure>\n";
  }
  return body.empty() ? "" : "<div class=\"pictures\">" + body + "</div>\n";
}

}  // namespace

std::vector<StudySection> study_sections(const StudyData& study, const StudyParts& parts) {
  std::string orders = series_table(study);
  for (const CaptionedFigure& plot : parts.convergence) orders += figure(sheet(plot.svg), plot.caption);
  for (const CaptionedFigure& plot : parts.cost) orders += figure(sheet(plot.svg), plot.caption);
  std::string details;
  for (std::size_t i = 0; i < study.series.size(); ++i) details += series_details(study.series[i], i);
  return {{"orders", "Orders", orders},
          {"pictures", "Where the error sits", pictures(parts)},
          {"series", "Series", details},
          {"claims", "Claims", claim_table(study)}};
}

std::string study_key_figures(const StudyData& study) {
  std::string html;
  const auto key = [&](const std::string& name, const std::string& value, const std::string& note) {
    html += "<div><dt>" + name + "</dt><dd>" + value + (note.empty() ? "" : tag("small", note)) + "</dd></div>";
  };
  if (!study.series.empty()) {
    const StudySeries& main = study.series.front();
    if (main.observed_order && main.expected_order)
      key(capitalised("observed " + order_noun(main)), fixed(*main.observed_order, 2),
          "expected " + expected_words(main));
    key("Finest error", scientific(judged_error(main)), "allowed " + scientific(main.error_tolerance));
    const auto n_counting =
        std::count_if(study.series.begin(), study.series.end(), [](const StudySeries& s) { return s.counts; });
    const auto n_passed = std::count_if(study.series.begin(), study.series.end(),
                                        [](const StudySeries& s) { return s.counts && s.passed; });
    key("Series passed", std::to_string(n_passed), "of " + std::to_string(n_counting));
    double largest = 0;
    for (const StudySeries& series : study.series) {
      for (const StudyLevel& level : series.levels) {
        if (level.h_m) largest = std::max(largest, level.n_unknowns.value_or(0));
      }
    }
    if (largest > 0) key("Largest system", fixed(largest, 0), "unknowns");
  }
  const auto claims_passed =
      std::count_if(study.claims.begin(), study.claims.end(), [](const StudyClaim& c) { return c.passed; });
  key("Claims", std::to_string(claims_passed), "of " + std::to_string(study.claims.size()) + " hold");
  return "<dl class=\"keys\">" + html + "</dl>\n";
}

std::vector<std::string> study_sentences(const StudyData& study) {
  std::vector<std::string> sentences;
  if (!study.question.empty()) sentences.push_back(escaped(study.question));
  std::vector<std::string> missed;
  for (const StudyClaim& claim : study.claims) {
    if (!claim.passed) missed.push_back(escaped(claim.words));
  }
  if (!study.series.empty()) {
    const StudySeries& main = study.series.front();
    std::string text = escaped(main.title) + ": ";
    if (main.observed_order && main.expected_order) {
      text += "the error falls with " + order_noun(main) + " <b>" + fixed(*main.observed_order, 2) + "</b>" +
              (main.order_ci95 ? " (95 % interval " + interval_words(main) + ")" : "") + " where " +
              rounded(*main.expected_order, 3) + " is expected, down to <b>" + scientific(judged_error(main)) + "</b>.";
    } else if (!main.expected_order && judged_error(main) && main.levels.front().error) {
      text += "the error goes from " + scientific(main.levels.front().error) + " to <b>" +
              scientific(judged_error(main)) + "</b> over its " + std::to_string(main.levels.size()) + " levels" +
              (main.error_tolerance ? ", " + scientific(main.error_tolerance) + " allowed" : "") +
              "; no order is claimed.";
    } else {
      text += escaped(main.verdict) + ".";
    }
    sentences.push_back(text);
  }
  if (missed.empty()) {
    sentences.push_back("All " + std::to_string(study.claims.size()) + " claims hold.");
  } else {
    std::string text = counted(missed.size(), "claim does", "claims do") + " not hold: ";
    for (std::size_t i = 0; i < std::min<std::size_t>(missed.size(), 4); ++i) text += (i ? "; " : "") + missed[i];
    sentences.push_back(text + (missed.size() > 4 ? "; …" : "."));
  }
  return sentences;
}

}  // namespace klang::reports::detail
