// The page of klang iet: a test report that prints.
#include <cmath>
#include <set>

#include "core/foundation/config/fields_csv.hpp"
#include "fit/iet/iet_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

std::string cell(const std::optional<double>& value, double factor, int digits) {
  return number_cell(value ? rounded(factor * *value, digits) : "—");
}

std::string head(const std::vector<std::pair<const char*, bool>>& columns) {
  std::string text = "<thead><tr>";
  for (const auto& [name, number] : columns)
    text += tag("th", name, number ? "class=\"n\" scope=\"col\"" : "scope=\"col\"");
  return text + "</tr></thead>\n<tbody>";
}

std::string specimen_table(const fit::IetDocument& data) {
  std::string body;
  for (const fit::IetRow& row : data.specimens) {
    const fit::IetSpecimen& g = row.given;
    body += "<tr>" + tag("th", escaped(g.specimen), "scope=\"row\"") + tag("td", to_text(g.shape)) +
            cell(g.length_m, 1e3, 6) + cell(g.width_m, 1e3, 6) + cell(g.thickness_m, 1e3, 6) +
            cell(g.diameter_m, 1e3, 6) + cell(g.mass_kg, 1e3, 6) + cell(row.density_kg_m3, 1.0, 5) +
            tag("td", escaped(g.operator_name)) + tag("td", escaped(g.date)) + cell(g.temperature_c, 1.0, 4) +
            tag("td", escaped(g.support)) + tag("td", escaped(g.device)) + "</tr>\n";
  }
  return scrolled("<table><caption>As they were given; the density is mass over volume.</caption>" +
                      head({{"Specimen", false},
                            {"Shape", false},
                            {"Length [mm]", true},
                            {"Width [mm]", true},
                            {"Thickness [mm]", true},
                            {"Diameter [mm]", true},
                            {"Mass [g]", true},
                            {"Density [kg/m³]", true},
                            {"Operator", false},
                            {"Date", false},
                            {"Temperature [°C]", true},
                            {"Support", false},
                            {"Device", false}}) +
                      body + "</tbody></table>",
                  "Specimens");
}

std::string result_table(const fit::IetDocument& data) {
  std::string body;
  for (const fit::IetRow& row : data.specimens) {
    const std::string mark = row.outlier ? " <span class=\"tag fair\">outlier</span>" : "";
    body += std::string("<tr") + (row.remark.empty() ? "" : " class=\"pair\"") + ">" +
            tag("th", escaped(row.given.specimen) + mark, "scope=\"row\"") + cell(row.flexural_hz, 1.0, 7) +
            cell(row.torsional_hz ? row.torsional_hz : row.second_hz, 1.0, 7) + cell(row.e_e1876_pa, 1e-9, 5) +
            cell(row.g_e1876_pa, 1e-9, 5) + cell(row.nu_e1876, 1.0, 3) + cell(row.e_model_pa, 1e-9, 5) +
            cell(row.g_model_pa, 1e-9, 5) +
            number_cell(row.difference_percent ? fixed(*row.difference_percent, 2) : "—") +
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

std::string summary_table(const fit::IetDocument& data) {
  std::string body;
  for (const fit::IetSummary& line : data.summary) {
    body += "<tr>" + tag("td", to_text(line.shape)) + tag("td", "<code>" + escaped(line.quantity) + "</code>") +
            number_cell(rounded(line.mean, 6)) + number_cell(line.std ? rounded(*line.std, 2) : "—") +
            number_cell(line.std && line.mean != 0.0 ? fixed(100.0 * *line.std / std::abs(line.mean), 2) : "—") +
            number_cell(std::to_string(line.n)) + "</tr>\n";
  }
  return scrolled("<table><caption>Mean and standard deviation of one specimen (n − 1), without outliers.</caption>" +
                      head({{"Shape", false},
                            {"Quantity", false},
                            {"Mean [SI]", true},
                            {"s [SI]", true},
                            {"s [%]", true},
                            {"n", true}}) +
                      body + "</tbody></table>",
                  "Summary");
}

std::vector<std::string> sentences_of(const fit::IetDocument& data) {
  std::size_t n_measured = 0, n_outliers = 0, n_assumed = 0;
  double widest = 0.0;
  for (const fit::IetRow& row : data.specimens) {
    n_measured += row.flexural_hz ? 1 : 0;
    n_outliers += row.outlier ? 1 : 0;
    n_assumed += row.flexural_hz && row.nu_assumed ? 1 : 0;
    widest = std::max(widest, std::abs(row.difference_percent.value_or(0.0)));
  }
  std::vector<std::string> sentences{
      "<b>" + std::to_string(n_measured) + "</b> of " +
      counted(data.specimens.size(), "specimen was", "specimens were") + " measured" +
      (n_outliers > 0 ? "; " + counted(n_outliers, "is an outlier and", "are outliers and") + " left out of the means"
                      : "") +
      "."};
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
    const int decimals = line.std && *line.std > 0 ? decimals_for(1e-9 * *line.std) : 2;
    keys.add(
        name,
        fixed(1e-9 * line.mean, decimals) + (line.std ? " ± " + fixed(1e-9 * *line.std, decimals) : "") + "\u202fGPa",
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
