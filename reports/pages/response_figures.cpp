#include "reports/pages/response_figures.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"

namespace klang::reports::detail {
namespace {

std::string column(const std::string& words) { return "<th class=\"n\" scope=\"col\">" + words + "</th>"; }

std::string estimator_words(const std::string& name) {
  if (name == "least_squares") return "least squares";
  if (name == "lscf") return "LSCF";
  if (name == "era") return "ERA";
  return name;
}

std::string estimate_table(const fit::AnalysisDocument& data) {
  std::string body;
  for (std::size_t k = 0; k < data.partials.size(); ++k) {
    for (const fit::PoleEstimate& e : data.responses->estimates) {
      if (e.partial != static_cast<int>(k)) continue;
      const std::string name = estimator_words(e.estimator);
      body += "<tr>" + number_cell(std::to_string(k + 1)) + tag("td", escaped(name)) +
              number_cell(fixed(e.frequency_hz, 4), e.frequency_hz) +
              number_cell(rounded(e.decay_per_s, 5), e.decay_per_s) +
              number_cell(rounded(100 * e.decay_per_s / (2 * 3.14159265358979 * e.frequency_hz), 4),
                          100 * e.decay_per_s / (2 * 3.14159265358979 * e.frequency_hz)) +
              "</tr>\n";
    }
  }
  return scrolled(
      "<table><caption>Each pole by each estimator; least squares over all responses is what counts.</caption>"
      "<thead><tr>" +
          column("Partial") + "<th scope=\"col\">Estimator</th>" + column("Frequency [Hz]") + column("Decay [1/s]") +
          column("Damping [%]") + "</tr></thead>\n<tbody>" + body + "</tbody></table>",
      "Poles by estimators");
}

std::string matrix_table(const fit::AnalysisDocument& data, const std::vector<std::vector<double>>& rows,
                         const std::vector<std::string>& heads, const std::string& caption) {
  std::string head = "<th scope=\"col\">Partial</th>", body;
  for (const std::string& words : heads) head += column(words);
  for (std::size_t k = 0; k < rows.size() && k < data.partials.size(); ++k) {
    body += "<tr>" + tag("th", escaped(hertz(data.partials[k].frequency_hz)), "scope=\"row\"");
    for (const double value : rows[k])
      body += number_cell(value > 0.5 ? "<b>" + fixed(value, 3) + "</b>" : fixed(value, 3));
    body += "</tr>\n";
  }
  return scrolled("<table><caption>" + caption + "</caption><thead><tr>" + head + "</tr></thead>\n<tbody>" + body +
                      "</tbody></table>",
                  "Modal assurance");
}

/// The responses' level over the whole height of the chart.
void draw_curve(const fit::ResponseRecord& record, Frame& frame, double most) {
  if (record.curve_hz.size() < 2 || record.curve_hz.size() != record.curve_db.size()) return;
  const auto [low, high] = std::minmax_element(record.curve_db.begin(), record.curve_db.end());
  std::vector<PlotPoint> points;
  for (std::size_t i = 0; i < record.curve_hz.size(); ++i)
    points.push_back({record.curve_hz[i], most * (record.curve_db[i] - *low) / std::max(*high - *low, 1e-9)});
  frame.curve(points, "rule");
}

}  // namespace

std::string stability_html(const fit::AnalysisDocument& data, ReportFolder& folder) {
  if (!data.responses) return {};
  std::string html;
  std::vector<double> frequencies;
  int most = 2;
  for (const fit::StabilityPole& pole : data.responses->stability) {
    frequencies.push_back(pole.frequency_hz);
    most = std::max(most, pole.order);
  }
  if (!frequencies.empty()) {
    constexpr double kHeight = 380, kLeft = 66, kTop = 24;
    Svg svg(kPageWidth, kHeight, "Stability chart: poles of models of rising order over frequency.");
    Frame frame(svg, {kLeft, kTop, kPageWidth - kLeft - 14, kHeight - kTop - 48},
                axis_around("Frequency [Hz]", Scale::kLinear, frequencies, 0.05),
                {"Order of the model", Scale::kLinear, 0, most + 2.0, true});
    frame.draw_axes(10, 6, true, true);
    draw_curve(*data.responses, frame, most);
    for (const fit::AnalysisPartial& p : data.partials)
      svg.line(frame.x(p.frequency_hz), frame.top(), frame.x(p.frequency_hz), frame.bottom(), "accent thin");
    for (const fit::StabilityPole& pole : data.responses->stability)
      svg.marker(pole.stable ? 0 : 7, frame.x(pole.frequency_hz), frame.y(pole.order), pole.stable ? 3.5 : 2.5,
                 hertz(pole.frequency_hz) + (pole.stable ? ", stable" : ""), !pole.stable);
    folder.add_figure("stability", svg);
    html =
        figure(sheet(svg),
               "Filled: the order before has the same pole within 1 % in frequency and 5 % in decay. Lines: the poles "
               "that were taken, after least squares." +
                   std::string(data.responses->curve_hz.empty()
                                   ? ""
                                   : " Curve: the responses’ rms level, from the lowest to the highest of this band."),
               "stability");
  }
  return html + estimate_table(data);
}

std::string assurance_html(const fit::AnalysisDocument& data) {
  if (!data.responses) return {};
  std::vector<std::string> heads, modes;
  for (const fit::AnalysisPartial& p : data.partials) heads.push_back(escaped(hertz(p.frequency_hz)));
  for (std::size_t i = 0; i < data.responses->model_hz.size(); ++i)
    modes.push_back("mode " + std::to_string(i) + ", " + escaped(hertz(data.responses->model_hz[i])));
  std::string html = matrix_table(data, data.responses->auto_mac, heads,
                                  "Shapes against each other: 1 is the same shape; large values off the diagonal mean "
                                  "that the places cannot tell two shapes apart.");
  if (!modes.empty()) html += matrix_table(data, data.responses->mac, modes, "Shapes against the model’s.");
  return html;
}

}  // namespace klang::reports::detail
