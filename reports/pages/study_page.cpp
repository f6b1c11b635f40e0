// The page of klang converge.
#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/study_figures.hpp"
#include "reports/scenes/study_pictures.hpp"
#include "validate/studies/study_document.hpp"

namespace klang::reports::detail {
namespace {

std::string pill(bool passed, bool counts = true) {
  if (!counts) return "<span class=\"tag\">for comparison</span>";
  return passed ? "<span class=\"tag good\">passed</span>" : "<span class=\"tag bad\">not met</span>";
}

std::string order_noun(const validate::SeriesRecord& series) {
  return series.kind == validate::Convergence::kGeometric ? "rate" : "order";
}

std::string expected_words(const validate::SeriesRecord& series) {
  if (!series.order.expected_order) return "—";
  return rounded(*series.order.expected_order, 3) +
         (series.order.order_tolerance ? " ± " + rounded(*series.order.order_tolerance, 2) : "") +
         (series.higher_is_fine ? " or higher" : "");
}

std::string interval_words(const validate::SeriesRecord& series) {
  if (!series.order.order_ci95 || !series.order.expected_order) return "—";
  return fixed((*series.order.order_ci95)[0], 2) + " to " + fixed((*series.order.order_ci95)[1], 2);
}

/// What the verdict looks at: the finest level's error, the largest for round-off.
Number judged_error(const validate::SeriesRecord& series) {
  if (series.order.levels.empty()) return {};
  if (series.kind != validate::Convergence::kRoundOff) return series.order.levels.back().error;
  Number largest;
  for (const validate::LevelRecord& level : series.order.levels) {
    if (level.error) largest = std::max(largest.value_or(0), *level.error);
  }
  return largest;
}

std::string scientific(const Number& value, int digits = 2) { return value ? rounded(*value, digits) : "—"; }

std::string series_table(const validate::StudyDocument& study) {
  std::string body;
  for (const validate::SeriesRecord& series : study.series) {
    const auto n_used = std::count_if(series.order.levels.begin(), series.order.levels.end(),
                                      [](const validate::LevelRecord& l) { return l.excluded.empty(); });
    body +=
        "<tr>" + tag("th", escaped(series.title), "scope=\"row\"") + tag("td", pill(series.passed, series.counts)) +
        number_cell(
            series.order.observed_order && series.order.expected_order ? fixed(*series.order.observed_order, 3) : "—",
            series.order.observed_order && series.order.expected_order ? Number(*series.order.observed_order)
                                                                       : Number()) +
        number_cell(interval_words(series)) + number_cell(expected_words(series)) +
        number_cell(std::to_string(series.order.levels.size()) +
                    (!series.order.expected_order || n_used == static_cast<long>(series.order.levels.size())
                         ? ""
                         : " (" + std::to_string(n_used) + " in the fit)")) +
        number_cell(scientific(judged_error(series)), judged_error(series)) +
        number_cell(scientific(series.error_tolerance), series.error_tolerance) + "</tr>\n";
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

std::string level_table(const validate::SeriesRecord& series) {
  const bool has_h = std::any_of(series.order.levels.begin(), series.order.levels.end(),
                                 [](const validate::LevelRecord& l) { return l.h_m.has_value(); });
  const bool has_value = std::any_of(series.order.levels.begin(), series.order.levels.end(),
                                     [](const validate::LevelRecord& l) { return l.value.has_value(); });
  std::string body;
  for (const validate::LevelRecord& level : series.order.levels) {
    body += "<tr" + std::string(level.excluded.empty() || !series.order.expected_order ? "" : " class=\"open\"") + ">" +
            number_cell(has_h ? rounded(level.h_m.value_or(0), 4) : rounded(level.n.value_or(0), 7)) +
            number_cell(fixed(level.n_unknowns, 0), level.n_unknowns) +
            number_cell(scientific(level.error, 4), level.error) +
            number_cell(level.pairwise_order ? fixed(*level.pairwise_order, 3) : "—", level.pairwise_order);
    if (has_value) body += number_cell(level.value ? rounded(*level.value, 8) : "—", level.value);
    body += tag("td", !series.order.expected_order ? ""
                      : level.excluded.empty()     ? "in the fit"
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

std::string series_details(const validate::SeriesRecord& series, std::size_t index) {
  std::string facts = "Error: " + escaped(series.error) + ". Reference: " + escaped(series.reference) + ".";
  if (series.error_floor && *series.error_floor > 0 && series.kind != validate::Convergence::kRoundOff)
    facts += " Levels at or below " + scientific(series.error_floor) + " (" + escaped(series.floor) +
             ") are left out of the fit.";
  if (series.asymptotic && series.order.expected_order)
    facts += *series.asymptotic
                 ? " The last two pairwise values agree within 15 %: the asymptotic range is reached."
                 : " The last two pairwise values still differ by more than 15 %: the asymptotic range is not reached.";
  if (series.gci && series.gci->gci_fine) {
    const validate::GciRecord& gci = *series.gci;
    facts += " Grid convergence index of the value on the three finest levels: " + rounded(100 * *gci.gci_fine, 3) +
             " % at apparent order " + fixed(gci.order.value_or(0), 2) +
             (gci.asymptotic_ratio ? ", asymptotic ratio " + fixed(*gci.asymptotic_ratio, 4) : "");
    if (gci.extrapolated)
      facts += "; extrapolated " + rounded(*gci.extrapolated, 8) +
               (gci.exact ? " (exact " + rounded(*gci.exact, 8) + ")" : "");
    facts += ".";
  }
  return "<details class=\"body\" id=\"series-" + std::to_string(index) + "\"" + (index == 0 ? " open" : "") +
         "><summary><h3>" + escaped(series.title) + "</h3><span class=\"shape\">" + escaped(series.verdict) +
         "</span>" + pill(series.passed, series.counts) + "</summary>\n<p class=\"how\"><small>" + facts +
         "</small></p>\n" + level_table(series) + "</details>\n";
}

std::string claim_table(const validate::StudyDocument& study) {
  std::string body;
  for (const validate::Claim& claim : study.claims) {
    body += "<tr>" + tag("th", escaped(claim.words), "scope=\"row\"") + tag("td", pill(claim.passed)) +
            number_cell(scientific(measured(claim.measured), 6), measured(claim.measured)) +
            number_cell(scientific(claim.reference, 6), claim.reference) +
            number_cell(scientific(measured(claim.tolerance)), measured(claim.tolerance)) + "</tr>\n";
  }
  if (body.empty()) return {};
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Claim</th><th scope=\"col\">Verdict</th><th scope=\"col\" "
      "class=\"n\">Measured</th><th scope=\"col\" class=\"n\">Reference</th><th scope=\"col\" "
      "class=\"n\">Tolerance</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Claims");
}

std::vector<StudyField> fields_of(const validate::StudyDocument& study) {
  std::vector<StudyField> fields;
  for (const validate::FieldRecord& field : study.fields.slices) fields.push_back({FieldKind::kSlice, field});
  for (const validate::FieldRecord& field : study.fields.surfaces) fields.push_back({FieldKind::kSurface, field});
  for (const validate::FieldRecord& field : study.fields.balloons) fields.push_back({FieldKind::kBalloon, field});
  return fields;
}

/// Slices are drawn here, the rest by VTK in its own process; in the order of the fields.
std::vector<std::optional<Svg>> drawn_fields(const std::vector<StudyField>& fields, ReportFolder& folder) {
  std::vector<FieldPictureRequest> requests;
  std::vector<std::optional<Svg>> drawn(fields.size());
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::filesystem::path file = folder.beside(fields[i].record.file);
    if (file.empty()) continue;
    if (fields[i].kind == FieldKind::kSlice) {
      if (const auto slice = read_slice(file)) {
        drawn[i] = slice_figure(fields[i], *slice);
      } else {
        folder.warn(fields[i].record.file + ": no slice that can be read, left out");
      }
    } else if (folder.options().pictures) {
      requests.push_back({file, fields[i].kind});
      asked.push_back(i);
    }
  }
  folder.monitor().throw_if_stopped();
  const DrawnPictures rendered = render_fields(requests, folder.monitor());
  if (!rendered.warning.empty()) folder.warn(rendered.warning);
  for (std::size_t k = 0; k < asked.size(); ++k) {
    const DrawnPicture& picture = rendered.pictures[k];
    if (!picture.png.empty()) drawn[asked[k]] = picture_figure(fields[asked[k]], picture);
  }
  return drawn;
}

std::string pictures_html(const std::vector<StudyField>& fields, ReportFolder& folder) {
  const std::vector<std::optional<Svg>> drawn = drawn_fields(fields, folder);
  std::string body;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!drawn[i]) continue;
    const validate::FieldRecord& field = fields[i].record;
    folder.add_figure(file_stem(field.name), *drawn[i]);
    body += "<figure><h3>" + escaped(field.title) + "</h3>" + drawn[i]->inline_markup() +
            tag("figcaption", escaped(field.caption)) + "</figure>\n";
  }
  return body.empty() ? "" : "<div class=\"pictures\">" + body + "</div>\n";
}

std::string key_figures(const validate::StudyDocument& study) {
  KeyFigures keys;
  if (!study.series.empty()) {
    const validate::SeriesRecord& main = study.series.front();
    if (main.order.observed_order && main.order.expected_order)
      keys.add(capitalised("observed " + order_noun(main)), fixed(*main.order.observed_order, 2),
               "expected " + expected_words(main));
    keys.add("Finest error", scientific(judged_error(main)), "allowed " + scientific(main.error_tolerance));
    const auto n_counting = std::count_if(study.series.begin(), study.series.end(),
                                          [](const validate::SeriesRecord& s) { return s.counts; });
    const auto n_passed = std::count_if(study.series.begin(), study.series.end(),
                                        [](const validate::SeriesRecord& s) { return s.counts && s.passed; });
    keys.add("Series passed", std::to_string(n_passed), "of " + std::to_string(n_counting));
    double largest = 0;
    for (const validate::SeriesRecord& series : study.series) {
      for (const validate::LevelRecord& level : series.order.levels) {
        if (level.h_m) largest = std::max(largest, level.n_unknowns);
      }
    }
    if (largest > 0) keys.add("Largest system", fixed(largest, 0), "unknowns");
  }
  const auto claims_passed =
      std::count_if(study.claims.begin(), study.claims.end(), [](const validate::Claim& c) { return c.passed; });
  keys.add("Claims", std::to_string(claims_passed), "of " + std::to_string(study.claims.size()) + " hold");
  return keys.html();
}

std::vector<std::string> sentences_of(const validate::StudyDocument& study) {
  std::vector<std::string> sentences;
  if (!study.question.empty()) sentences.push_back(escaped(study.question));
  std::vector<std::string> missed;
  for (const validate::Claim& claim : study.claims) {
    if (!claim.passed) missed.push_back(escaped(claim.words));
  }
  if (!study.series.empty()) {
    const validate::SeriesRecord& main = study.series.front();
    std::string text = escaped(main.title) + ": ";
    if (main.order.observed_order && main.order.expected_order) {
      text += "the error falls with " + order_noun(main) + " <b>" + fixed(*main.order.observed_order, 2) + "</b>" +
              (main.order.order_ci95 ? " (95 % interval " + interval_words(main) + ")" : "") + " where " +
              rounded(*main.order.expected_order, 3) + " is expected, down to <b>" + scientific(judged_error(main)) +
              "</b>.";
    } else if (!main.order.expected_order && judged_error(main) && main.order.levels.front().error) {
      text += "the error goes from " + scientific(main.order.levels.front().error) + " to <b>" +
              scientific(judged_error(main)) + "</b> over its " + std::to_string(main.order.levels.size()) + " levels" +
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

Verdict verdict_of(const validate::StudyDocument& study) {
  Verdict result = study.passed ? Verdict{"Passed", "good", {}} : Verdict{"Not passed", "bad", {}};
  const auto missed = static_cast<std::size_t>(std::count_if(
      study.claims.begin(), study.claims.end(), [](const validate::Claim& claim) { return !claim.passed; }));
  if (missed > 0) {
    result.details = std::to_string(missed) + " of " + counted(study.claims.size(), "claim", "claims") + " not met";
  } else if (!study.series.empty()) {
    result.details = study.series.front().verdict;
  }
  return result;
}

Page make(const validate::StudyDocument& study, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · convergence study";
  page.title = study.title.empty() ? "Convergence study" : study.title;
  page.verdict = verdict_of(study);
  page.sentences = sentences_of(study);
  page.key_figures = key_figures(study);
  std::string orders = series_table(study), details;
  for (const auto& figures : {convergence_figures(study), cost_figures(study)}) {
    for (const CaptionedFigure& plot : figures) {
      folder.add_figure(plot.stem, plot.svg);
      orders += figure(sheet(plot.svg), plot.caption);
    }
  }
  for (std::size_t i = 0; i < study.series.size(); ++i) details += series_details(study.series[i], i);
  const std::vector<StudyField> fields = fields_of(study);
  page.sections = {{"orders", "Orders", orders},
                   {"pictures", "Where the error sits", pictures_html(fields, folder)},
                   {"series", "Series", details},
                   {"claims", "Claims", claim_table(study)}};
  add_if_there("levels.csv", "– every level", folder, page.downloads);
  add_if_there("junit.xml", "– the claims for a test report", folder, page.downloads);
  for (const StudyField& field : fields) add_if_there(field.record.file, "– for ParaView", folder, page.downloads);
  page.downloads.push_back(kFiguresDownload);
  page.footer =
      "Orders are slopes of least-squares lines through the logarithms; intervals hold with 95 % by Student’s t.";
  return page;
}

}  // namespace

PageKind study_page() { return page_kind<validate::StudyDocument>("study", make); }

}  // namespace klang::reports::detail
