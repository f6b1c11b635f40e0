#include "reports/pages/fit_tables.hpp"

#include <algorithm>
#include <cmath>

#include "reports/pages/page_parts.hpp"
#include "reports/pages/spectrum_view.hpp"

namespace klang::reports::detail {
namespace {

/// The cell of a row's buttons, empty where the partial is none of those heard.
std::string hear(const std::vector<fit::Partial>& heard, double frequency_hz) {
  if (heard.empty()) return {};
  const auto found =
      std::find_if(heard.begin(), heard.end(), [&](const fit::Partial& p) { return p.frequency_hz == frequency_hz; });
  if (found == heard.end() || !(found->amplitude.value_or(0.0) > 0)) return tag("td", "", "class=\"act\"");
  return hear_cell(static_cast<std::size_t>(found - heard.begin()), frequency_hz);
}

std::string hear_head(const std::vector<fit::Partial>& heard) {
  return heard.empty() ? "" : "<th class=\"act\" scope=\"col\" data-plain>Listen</th>";
}

}  // namespace

ShownEstimate shown(const fit::FitParameter& parameter) {
  return shown(parameter.name, measured(parameter.value), parameter.std, parameter.ci95);
}

std::string name_html(const Quantity& quantity) {
  return escaped(capitalised(quantity.words)) +
         (quantity.symbol.empty() ? "" : " <span class=\"sym\">" + escaped(quantity.symbol) + "</span>");
}

std::string with_unit(const std::string& text, const Quantity& quantity) {
  return text.empty() || quantity.unit.empty() ? escaped(text) : escaped(text) + "\u202f" + escaped(quantity.unit);
}

std::string plus_minus(const Number& value, const Number& std, int digits) {
  if (!value) return "—";
  if (std && *std > 0) return fixed(*value, decimals_for(*std)) + " ± " + fixed(*std, decimals_for(*std));
  return rounded(*value, digits);
}

std::string parameter_table(const std::vector<fit::FitParameter>& parameters) {
  std::string body;
  for (const fit::FitParameter& e : parameters) {
    const ShownEstimate text = shown(e);
    const bool known = e.identifiable;
    const bool noted = !e.why.empty();
    std::string classes = known || e.given ? "" : "open";
    if (noted) classes += classes.empty() ? "pair" : " pair";
    body += "<tr" + (classes.empty() ? "" : " class=\"" + classes + "\"") + ">";
    body += tag("th", name_html(text.quantity) + (e.derived ? " <small>(derived)</small>" : ""), "scope=\"row\"");
    const std::string value = text.std.empty() || !known ? text.value : text.value + " ± " + text.std;
    body += number_cell(with_unit(value, text.quantity) +
                        (e.caveat.empty() ? "" : "<br><small>" + escaped(e.caveat) + "</small>"));
    body += number_cell(known ? escaped(text.interval()) : "—");
    body += number_cell(std::isfinite(e.start_value)
                            ? with_unit(rounded(e.start_value * text.quantity.factor, 5), text.quantity)
                            : "—");
    std::string by_data = e.given ? "<span class=\"tag\">given</span>"
                          : known ? "<span class=\"tag good\">determined</span>"
                                  : "<span class=\"tag fair\">not determined</span>";
    if (e.verdict != fit::Verdict::kNotJudged)
      by_data += std::string(" <span class=\"tag ") +
                 (e.verdict == fit::Verdict::kTrusted    ? "good"
                  : e.verdict == fit::Verdict::kDoubtful ? "fair"
                                                         : "bad") +
                 "\">" + std::string(to_text(e.verdict)) + "</span>";
    body += tag("td", by_data);
    body += "</tr>\n";
    if (noted) body += "<tr class=\"note\"><td colspan=\"5\">" + escaped(e.why) + "</td></tr>\n";
  }
  return "<table><thead><tr><th scope=\"col\">Parameter</th><th scope=\"col\" class=\"n\">Value ± standard "
         "deviation</th>"
         "<th scope=\"col\" class=\"n\">95 % interval</th><th scope=\"col\" class=\"n\">Start</th><th "
         "scope=\"col\">By these data</th></tr></thead>\n<tbody>" +
         body + "</tbody></table>";
}

std::string budget_table(const fit::FitDocument& data) {
  std::string body;
  for (const fit::BudgetEntry& entry : data.budget) {
    const Quantity q = quantity(entry.parameter, entry.contribution_std.value_or(1.0));
    body += "<tr>" + tag("th", name_html(q), "scope=\"row\"") + tag("td", escaped(entry.source)) +
            number_cell(entry.sensitivity ? fixed(*entry.sensitivity, 2) : "—", entry.sensitivity) +
            number_cell(entry.contribution_std ? with_unit(rounded(q.factor * *entry.contribution_std, 2), q)
                                               : "no tolerance given") +
            number_cell(entry.share ? fixed(100 * *entry.share, 1) : "—",
                        entry.share ? Number(100 * *entry.share) : Number()) +
            "</tr>\n";
  }
  if (body.empty()) return {};
  return more("What contributes how much to the standard deviations",
              scrolled("<table><caption>A parameter’s standard deviation is the root of the sum of squares of its "
                       "contributions. The sensitivity says by how many per cent it moves when the source is 1 % "
                       "larger: linear, each partial with the weight that it has in this fit. A given quantity that is "
                       "really changed also changes the weights.</caption><thead><tr><th "
                       "scope=\"col\">Parameter</th><th scope=\"col\">Source</th><th "
                       "class=\"n\" scope=\"col\">Sensitivity</th><th class=\"n\" scope=\"col\">Contribution</th><th "
                       "class=\"n\" scope=\"col\">Share [%]</th></tr></thead>\n<tbody>" +
                           body + "</tbody></table>",
                       "Uncertainty budget"));
}

std::string correlation_table(const fit::FitDocument& data) {
  const std::size_t n = data.correlation.names.size();
  if (n < 2 || data.correlation.matrix.size() != n) return {};
  std::string head = "<th></th>", body;
  for (std::size_t i = 0; i < n; ++i) {
    const Quantity q = quantity(data.correlation.names[i], 1);
    const std::string words = q.symbol.empty() ? escaped(q.words) : "<span class=\"sym\">" + q.symbol + "</span>";
    head += "<th scope=\"col\" class=\"n\">" + words + "</th>";
    body += "<tr>" + tag("th", name_html(q), "scope=\"row\"");
    for (const double value : data.correlation.matrix[i]) body += number_cell(fixed(value, 2), value);
    body += "</tr>\n";
  }
  return more(
      "Correlation of the estimates",
      scrolled("<table><thead><tr>" + head + "</tr></thead><tbody>" + body + "</tbody></table>", "Correlation matrix"));
}

std::string damping_table(const fit::FitDocument& data) {
  double least = 1e300;
  for (const fit::DampingRecord& model : data.damping.candidates) least = std::min(least, model.aicc.value_or(1e300));
  std::string body;
  for (const fit::DampingRecord& model : data.damping.candidates) {
    std::string values;
    for (const fit::FitParameter& e : model.parameters) {
      const ShownEstimate text = shown(e);
      values +=
          (values.empty() ? "" : "<br>") +
          (text.quantity.symbol.empty() ? escaped(text.quantity.words)
                                        : "<span class=\"sym\">" + escaped(text.quantity.symbol) + "</span>") +
          " = " +
          (e.identifiable ? escaped(text.value_with_std())
                          : with_unit(text.value, text.quantity) + " <span class=\"tag fair\">not determined</span>");
    }
    const double weight = std::clamp(model.aicc_weight.value_or(0), 0.0, 1.0);
    body += "<tr" + std::string(model.model == data.damping.model ? " class=\"best\"" : "") + ">" +
            tag("th", escaped(capitalised(damping_words(model.model))), "scope=\"row\"") +
            tag("td", values, "class=\"nw\"") +
            number_cell(model.rms_relative_residual ? rounded(100 * *model.rms_relative_residual, 3) + " %" : "—",
                        model.rms_relative_residual ? Number(100 * *model.rms_relative_residual) : Number()) +
            number_cell(model.aicc ? fixed(*model.aicc, 1) : "—", model.aicc) +
            number_cell(model.aicc ? "+" + fixed(*model.aicc - least, 1) : "—") +
            tag("td",
                model.aicc_weight ? "<span class=\"bar\" style=\"width:" + coordinate(5 * weight) + "em\"></span>" +
                                        escaped(share(weight))
                                  : "—",
                "class=\"nw\"") +
            "</tr>\n";
  }
  return scrolled(
      "<table><caption>Damping models, best first. AICc weighs how well a model fits against how many "
      "parameters it takes; the weight is each model’s share of belief among these.</caption><thead><tr>"
      "<th scope=\"col\">Model</th><th scope=\"col\">Parameters</th><th scope=\"col\" class=\"n\">rms "
      "residual</th>"
      "<th scope=\"col\" class=\"n\">AICc</th><th scope=\"col\" class=\"n\">Difference</th><th "
      "scope=\"col\">Weight</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Damping models");
}

std::string match_table(const std::vector<fit::MatchRecord>& matches, const std::vector<fit::Partial>& heard) {
  std::string body;
  const bool radiates = std::any_of(matches.begin(), matches.end(),
                                    [](const fit::MatchRecord& m) { return m.radiation_decay_per_s.has_value(); });
  for (const fit::MatchRecord& m : matches) {
    body += "<tr>" + number_cell(std::to_string(m.mode_index)) +
            number_cell(escaped(plus_minus(m.frequency_hz, m.frequency_std_hz, 7)), m.frequency_hz) +
            number_cell(m.model_frequency_std_hz
                            ? escaped(plus_minus(m.model_frequency_hz, m.model_frequency_std_hz, 7))
                            : fixed(m.model_frequency_hz,
                                    m.frequency_std_hz ? std::clamp(decimals_for(*m.frequency_std_hz), 1, 4) : 2)) +
            number_cell(signed_cents(m.deviation_cents), m.deviation_cents) +
            number_cell(fixed(100 * (m.frequency_hz / m.model_frequency_hz - 1), 3),
                        100 * (m.frequency_hz / m.model_frequency_hz - 1)) +
            number_cell(escaped(plus_minus(m.decay_per_s, m.decay_std_per_s)), m.decay_per_s) +
            number_cell(m.model_decay_per_s ? rounded(*m.model_decay_per_s, 4) : "—", m.model_decay_per_s) +
            (radiates ? number_cell(m.radiation_decay_per_s ? rounded(*m.radiation_decay_per_s, 3) : "—",
                                    m.radiation_decay_per_s) +
                            number_cell(m.radiation_decay_per_s && m.decay_per_s && *m.decay_per_s > 0
                                            ? fixed(100 * *m.radiation_decay_per_s / *m.decay_per_s, 0)
                                            : "—",
                                        m.radiation_decay_per_s && m.decay_per_s && *m.decay_per_s > 0
                                            ? Number(100 * *m.radiation_decay_per_s / *m.decay_per_s)
                                            : Number())
                      : std::string()) +
            hear(heard, m.frequency_hz) + "</tr>\n";
  }
  return "<table><thead><tr><th class=\"n\" scope=\"col\">Mode</th><th class=\"n\" scope=\"col\">Measured "
         "[Hz]</th>"
         "<th class=\"n\" scope=\"col\">Model [Hz]</th><th class=\"n\" scope=\"col\">Cents</th><th "
         "class=\"n\" scope=\"col\">Per cent</th>"
         "<th class=\"n\" scope=\"col\">Decay [1/s]</th><th class=\"n\" scope=\"col\">Model decay "
         "[1/s]</th>" +
         std::string(
             radiates
                 ? "<th class=\"n\" scope=\"col\">Radiated [1/s]</th><th class=\"n\" scope=\"col\">of the measured "
                   "[%]</th>"
                 : "") +
         hear_head(heard) + "</tr></thead>\n<tbody>" + body + "</tbody></table>";
}

/// What is to be known beside a partial's numbers; empty: nothing.
std::string remarks_on(const fit::Partial& partial) {
  std::string words;
  const auto add = [&](const std::string& remark) { words += (words.empty() ? "" : ", ") + remark; };
  if (partial.kind == fit::PartialKind::kTooShort) add("too short to tell whether it falls");
  if (partial.kind == fit::PartialKind::kWeak) add("weak");
  if (!partial.stage.empty()) add(partial.stage + " of two stages");
  if (partial.beat_hz) add("beats " + rounded(*partial.beat_hz, 3) + " Hz");
  return words;
}

std::string partial_table(const std::vector<fit::Partial>& partials, const std::vector<fit::Partial>& heard) {
  std::string body;
  const bool noted =
      std::any_of(partials.begin(), partials.end(), [](const fit::Partial& p) { return !p.note.empty(); });
  const bool remarked =
      std::any_of(partials.begin(), partials.end(), [](const fit::Partial& p) { return !remarks_on(p).empty(); });
  for (const fit::Partial& p : partials) {
    body += "<tr>" + number_cell(escaped(plus_minus(p.frequency_hz, p.frequency_std_hz, 7)), p.frequency_hz) +
            number_cell(escaped(plus_minus(p.decay_per_s, p.decay_std_per_s)), p.decay_per_s) +
            number_cell(p.decay_per_s && *p.decay_per_s > 0 ? rounded(std::log(1000.0) / *p.decay_per_s, 3) : "—",
                        p.decay_per_s && *p.decay_per_s > 0 ? Number(std::log(1000.0) / *p.decay_per_s) : Number()) +
            number_cell(p.amplitude && *p.amplitude > 0 ? fixed(20 * std::log10(*p.amplitude), 1) : "—",
                        p.amplitude && *p.amplitude > 0 ? Number(20 * std::log10(*p.amplitude)) : Number()) +
            number_cell(p.phase_rad ? fixed(*p.phase_rad, 2) : "—", p.phase_rad) +
            (noted ? tag("td", escaped(p.note)) + number_cell(p.cents ? signed_cents(*p.cents) : "—", p.cents)
                   : std::string()) +
            (remarked ? tag("td", escaped(remarks_on(p))) : std::string()) + hear(heard, p.frequency_hz) + "</tr>\n";
  }
  return "<table><thead><tr><th class=\"n\" scope=\"col\">Frequency [Hz]</th><th class=\"n\" "
         "scope=\"col\">Decay [1/s]</th>"
         "<th class=\"n\" scope=\"col\">60 dB in [s]</th><th class=\"n\" scope=\"col\">Level [dB]</th>"
         "<th class=\"n\" scope=\"col\">Phase [rad]</th>" +
         std::string(noted ? "<th scope=\"col\">Note</th><th class=\"n\" scope=\"col\">Cents</th>" : "") +
         std::string(remarked ? "<th scope=\"col\">Remark</th>" : "") + hear_head(heard) + "</tr></thead>\n<tbody>" +
         body + "</tbody></table>";
}

std::string mode_list(const std::vector<fit::PredictedRecord>& modes) {
  std::string text;
  for (const fit::PredictedRecord& mode : modes) {
    text += (text.empty() ? "" : ", ") +
            ("<span class=\"nobr\">" + std::to_string(mode.mode_index) + " (" + escaped(hertz(mode.frequency_hz))) +
            ")</span>";
  }
  return text;
}

}  // namespace klang::reports::detail
