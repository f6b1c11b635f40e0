// The page of klang iet: a test report that prints.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "core/foundation/config/fields_csv.hpp"
#include "fit/iet/iet_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

std::string cell(const std::optional<double>& value, double factor, int digits) {
  return number_cell(value ? rounded(factor * *value, digits) : "—", value ? Number(factor * *value) : Number());
}

std::string head(const std::vector<std::pair<const char*, bool>>& columns) {
  std::string text = "<thead><tr>";
  for (const auto& [name, number] : columns)
    text += tag("th", name, number ? "class=\"n\" scope=\"col\"" : "scope=\"col\"");
  return text + "</tr></thead>\n<tbody>";
}

/// What the standard wants in the report of each specimen beside its size.
struct Condition {
  const char* name;
  std::function<std::string(const fit::IetSpecimen&)> words;
};

std::vector<Condition> conditions() {
  return {{"Operator", [](const fit::IetSpecimen& g) { return g.operator_name; }},
          {"Date", [](const fit::IetSpecimen& g) { return g.date; }},
          {"Temperature",
           [](const fit::IetSpecimen& g) { return g.temperature_c ? rounded(*g.temperature_c, 4) + "\u202f°C" : ""; }},
          {"Support", [](const fit::IetSpecimen& g) { return g.support; }},
          {"Device", [](const fit::IetSpecimen& g) { return g.device; }}};
}

bool is_common(const fit::IetDocument& data, const Condition& condition) {
  return std::all_of(data.specimens.begin(), data.specimens.end(), [&](const fit::IetRow& row) {
    return condition.words(row.given) == condition.words(data.specimens.front().given);
  });
}

/// What all specimens share stands once, the rest in the table.
std::string common_conditions(const fit::IetDocument& data) {
  std::string body;
  for (const Condition& condition : conditions()) {
    if (!is_common(data, condition)) continue;
    const std::string words = condition.words(data.specimens.front().given);
    body += "<tr>" + tag("th", condition.name, "scope=\"row\"") +
            tag("td", words.empty() ? "not given" : escaped(words)) + "</tr>\n";
  }
  return body.empty() ? body : "<table><caption>Of all specimens.</caption><tbody>" + body + "</tbody></table>\n";
}

std::string specimen_table(const fit::IetDocument& data) {
  std::vector<Condition> own;
  for (const Condition& condition : conditions()) {
    if (!is_common(data, condition)) own.push_back(condition);
  }
  std::string body;
  for (const fit::IetRow& row : data.specimens) {
    const fit::IetSpecimen& g = row.given;
    body += "<tr>" + tag("th", escaped(g.specimen), "scope=\"row\"") + tag("td", to_text(g.shape)) +
            cell(g.length_m, 1e3, 6) + cell(g.width_m, 1e3, 6) + cell(g.thickness_m, 1e3, 6) +
            cell(g.diameter_m, 1e3, 6) + cell(g.mass_kg, 1e3, 6) + cell(row.density_kg_m3, 1.0, 5);
    for (const Condition& condition : own) {
      const std::string words = condition.words(g);
      body += tag("td", words.empty() ? "not given" : escaped(words));
    }
    body += "</tr>\n";
  }
  std::vector<std::pair<const char*, bool>> columns{
      {"Specimen", false},      {"Shape", false},        {"Length [mm]", true}, {"Width [mm]", true},
      {"Thickness [mm]", true}, {"Diameter [mm]", true}, {"Mass [g]", true},    {"Density [kg/m³]", true}};
  for (const Condition& condition : own) columns.emplace_back(condition.name, false);
  return common_conditions(data) +
         scrolled("<table><caption>As they were given; the density is mass over volume.</caption>" + head(columns) +
                      body + "</tbody></table>",
                  "Specimens");
}

std::string result_table(const fit::IetDocument& data) {
  std::string body;
  for (const fit::IetRow& row : data.specimens) {
    const std::string mark = row.implausible ? " <span class=\"tag bad\">implausible</span>"
                             : row.outlier   ? " <span class=\"tag fair\">outlier</span>"
                                             : "";
    body += std::string("<tr") + (row.remark.empty() ? "" : " class=\"pair\"") + ">" +
            tag("th", escaped(row.given.specimen) + mark, "scope=\"row\"") + cell(row.flexural_hz, 1.0, 7) +
            cell(row.torsional_hz ? row.torsional_hz : row.second_hz, 1.0, 7) + cell(row.e_e1876_pa, 1e-9, 5) +
            cell(row.g_e1876_pa, 1e-9, 5) + cell(row.nu_e1876, 1.0, 3) + cell(row.e_model_pa, 1e-9, 5) +
            cell(row.g_model_pa, 1e-9, 5) +
            number_cell(row.difference_percent ? fixed(*row.difference_percent, 2) : "—", row.difference_percent) +
            cell(row.q_inverse_flexural, 1e3, 3) + "</tr>\n";
    if (!row.remark.empty()) body += "<tr class=\"note\"><td colspan=\"10\">" + escaped(row.remark) + "</td></tr>\n";
  }
  return scrolled(
      "<table><caption>Closed forms of the standard beside the full three-dimensional model of the same frequencies; "
      "the difference is that of E.</caption>" +
          head({{"Specimen", false},
                {"Flexural or first [Hz]", true},
                {"Torsional or second [Hz]", true},
                {"E, E1876 [GPa]", true},
                {"G, E1876 [GPa]", true},
                {"ν, E1876", true},
                {"E, model [GPa]", true},
                {"G, model [GPa]", true},
                {"Difference [%]", true},
                {"Q⁻¹ · 1000", true}}) +
          body + "</tbody></table>",
      "Results");
}

/// A column of iet.csv in words, and what its numbers are multiplied with there.
struct QuantityWords {
  std::string name;
  double factor = 1.0;
};

QuantityWords words_of_quantity(const std::string& column) {
  static const std::map<std::string, QuantityWords> known{
      {"e_e1876_pa", {"E by the closed form [GPa]", 1e-9}}, {"g_e1876_pa", {"G by the closed form [GPa]", 1e-9}},
      {"nu_e1876", {"ν by the closed form", 1.0}},          {"e_model_pa", {"E by the full model [GPa]", 1e-9}},
      {"g_model_pa", {"G by the full model [GPa]", 1e-9}},  {"nu_model", {"ν by the full model", 1.0}},
      {"q_inverse_flexural", {"Q⁻¹ · 1000, flexural", 1e3}}};
  const auto found = known.find(column);
  return found == known.end() ? QuantityWords{column, 1.0} : found->second;
}

std::string summary_table(const fit::IetDocument& data) {
  std::string body;
  for (const fit::IetSummary& line : data.summary) {
    const QuantityWords words = words_of_quantity(line.quantity);
    const double mean = words.factor * line.mean;
    const bool spread = line.std && *line.std > 0.0;
    const int decimals = spread ? std::min(decimals_for(words.factor * *line.std), 6) : 3;
    body += "<tr>" + tag("td", to_text(line.shape)) + tag("th", escaped(words.name), "scope=\"row\"") +
            number_cell(fixed(mean, decimals), mean) +
            number_cell(spread ? rounded(words.factor * *line.std, 2) : "—",
                        spread ? Number(words.factor * *line.std) : Number()) +
            number_cell(spread && mean != 0.0 ? rounded(100.0 * words.factor * *line.std / std::abs(mean), 2) : "—",
                        spread && mean != 0.0 ? Number(100.0 * words.factor * *line.std / std::abs(mean)) : Number()) +
            number_cell(std::to_string(line.n)) + "</tr>\n";
  }
  return scrolled(
      "<table><caption>Mean and standard deviation s of one specimen (n − 1), without outliers and what is "
      "implausible. The spread among "
      "specimens, without the tolerances of dimensions and mass.</caption>" +
          head({{"Shape", false}, {"Quantity", false}, {"Mean", true}, {"s", true}, {"s [%]", true}, {"n", true}}) +
          body + "</tbody></table>",
      "Summary");
}

std::vector<std::string> sentences_of(const fit::IetDocument& data) {
  std::size_t n_measured = 0, n_outliers = 0, n_implausible = 0, n_assumed = 0;
  double widest = 0.0;
  for (const fit::IetRow& row : data.specimens) {
    n_measured += row.flexural_hz ? 1 : 0;
    n_outliers += row.outlier && !row.implausible ? 1 : 0;
    n_implausible += row.implausible ? 1 : 0;
    n_assumed += row.flexural_hz && row.nu_assumed ? 1 : 0;
    if (!row.implausible) widest = std::max(widest, std::abs(row.difference_percent.value_or(0.0)));
  }
  std::vector<std::string> sentences{
      "<b>" + std::to_string(n_measured) + "</b> of " +
      counted(data.specimens.size(), "specimen was", "specimens were") + " measured" +
      (n_outliers > 0 ? "; " + counted(n_outliers, "is an outlier and", "are outliers and") + " left out of the means"
                      : "") +
      "."};
  if (n_implausible > 0)
    sentences.push_back("<b>" + counted(n_implausible, "specimen has", "specimens have") +
                        " values that cannot be</b> and " + (n_implausible == 1 ? "is" : "are") +
                        " left out of the means: the remarks say why.");
  sentences.push_back(
      "Closed forms and full model differ by " + fixed(widest, 2) +
      " % in E at most. The closed forms are those of slender bodies with a correction for their thickness; "
      "the model needs neither, so that a difference above 1 % points to a body outside the standard’s "
      "proportions.");
  if (n_assumed > 0)
    sentences.push_back(counted(n_assumed, "specimen shows", "specimens show") +
                        " no second frequency: ν = 0.3 is assumed for E, and G is not given.");
  sentences.push_back(
      "Given dimensions and masses are taken as exact: E is <b>without the tolerances of dimensions and mass</b>.");
  for (const fit::IetRow& row : data.specimens) {
    if (row.given.shape != fit::IetShape::kDisc) continue;
    sentences.push_back(
        "Discs: the factors K₁, K₂ and ν, which the standard tabulates by t/r, are computed by the model here.");
    break;
  }
  return sentences;
}

Page make(const fit::IetDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · impulse excitation, ASTM E1876";
  page.title = data.name;
  page.verdict = status_verdict(data.header);
  page.sentences = sentences_of(data);
  KeyFigures keys;
  keys.add("Specimens", std::to_string(data.specimens.size()));
  for (const fit::IetSummary& line : data.summary) {
    if (line.quantity != "e_e1876_pa" && line.quantity != "g_e1876_pa") continue;
    const std::string name = (line.quantity[0] == 'e' ? "E of " : "G of ") + to_text(line.shape) + "s";
    const bool spread = line.std && *line.std > 0.0;
    const int decimals = spread ? std::min(decimals_for(1e-9 * *line.std), 6) : 2;
    keys.add(
        name,
        fixed(1e-9 * line.mean, decimals) + (spread ? " ± " + fixed(1e-9 * *line.std, decimals) : "") + "\u202fGPa",
        "n = " + std::to_string(line.n) + ", without the tolerances of dimensions and mass");
  }
  page.key_figures = keys.html();
  page.sections = {{"summary", "Summary", summary_table(data)},
                   {"results", "Results", result_table(data)},
                   {"specimens", "Specimens", specimen_table(data)}};
  add_table("iet.csv", csv_table(data.specimens), data.header.provenance.inputs, folder, page.downloads);
  return page;
}

}  // namespace

PageKind iet_page() { return page_kind<fit::IetDocument>("iet", make); }

}  // namespace klang::reports::detail
