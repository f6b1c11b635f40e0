#include "reports/pages/proxy_page.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kWidth = 1080, kLeft = 66, kRight = 24;

double cents(double a, double b) { return 1200.0 * std::log2(a / b); }

struct MeasureWords {
  const char *name, *words, *unit;
};
constexpr MeasureWords kMeasures[] = {
    {"partial_rms_cents", "Partials, rms", "cents"},       {"log_spectral_distance_db", "Log-spectral distance", "dB"},
    {"mel_distance_db", "Distance in mel bands", "dB"},    {"third_octave_db", "Third-octave levels, rms", "dB"},
    {"loudness_difference_db", "A-weighted energy", "dB"}, {"decay_rms_percent", "Decays, rms", "%"}};

MeasureWords words_of(const std::string& name) {
  for (const MeasureWords& m : kMeasures)
    if (m.name == name) return m;
  return {name.c_str(), name.c_str(), ""};
}

const ProxyFitData::Measure& partials(const ProxyFitData& data) { return data.measures.front(); }

std::string signed_number(double value, int decimals) { return (value > 0 ? "+" : "") + fixed(value, decimals); }

}  // namespace

Svg proxy_partials_figure(const ProxyFitData& data) {
  constexpr double kTop = 34, kLines = 230, kGap = 34, kCents = 190, kHeight = kTop + kLines + kGap + kCents + 48;
  Svg svg(
      kWidth, kHeight,
      "Partials of the body, of the first proxy and of the fitted one over frequency, and their differences in cents.");
  std::vector<double> frequencies;
  double loudest = 0;
  for (const auto* list : {&data.target, &data.before, &data.after})
    for (const auto& line : *list) {
      frequencies.push_back(line.frequency_hz);
      loudest = std::max(loudest, line.amplitude);
    }
  AxisSpec x = axis_around("Frequency of the body's partial [Hz]", Scale::kLog, frequencies, 0.05);
  const auto level = [&](const ProxyFitData::Line& line) {
    return std::max(20 * std::log10(std::max(line.amplitude, 1e-30) / loudest), -79.0);
  };
  double lowest = -20;
  for (const auto* list : {&data.target, &data.before, &data.after})
    for (const auto& line : *list) lowest = std::min(lowest, level(line));
  const double floor = 10 * std::floor((lowest - 5) / 10);
  AxisSpec hidden = x;
  hidden.labelled = false;
  Frame lines(svg, kLeft, kTop, kWidth - kLeft - kRight, kLines, hidden,
              {"Level at the strike [dB re loudest]", Scale::kLinear, floor, 5});
  lines.draw_axes(10, 6);
  const struct {
    const std::vector<ProxyFitData::Line>* list;
    int series;
    const char *stroke, *words;
  } sides[] = {{&data.target, 0, "s0 thick", "Body"},
               {&data.before, 1, "s1 mid dash2", "First proxy"},
               {&data.after, 2, "s2 thick", "Fitted proxy"}};
  double at = kLeft + 8;
  for (const auto& side : sides) {
    for (std::size_t k = 0; k < side.list->size(); ++k) {
      const auto& line = (*side.list)[k];
      const double place = lines.x(line.frequency_hz);
      svg.line(place, lines.y(floor), place, lines.y(level(line)), side.stroke);
      svg.marker(side.series, place, lines.y(level(line)), 3.5,
                 std::string(side.words) + ", partial " + std::to_string(k + 1) + ": " + hertz(line.frequency_hz),
                 k >= static_cast<std::size_t>(data.n_fitted));
    }
    svg.marker(side.series, at, kTop - 16, 4, "");
    svg.text(at + 10, kTop - 12, side.words, "small");
    at += 100;
  }
  svg.text(kWidth - kRight, kTop - 12, "hollow: not among the " + std::to_string(data.n_fitted) + " that are fitted",
           "muted small", Anchor::kEnd);

  double largest = 10;
  for (std::size_t k = 0; k < data.target.size(); ++k)
    for (const auto* list : {&data.before, &data.after})
      largest = std::max(largest, std::abs(cents((*list)[k].frequency_hz, data.target[k].frequency_hz)));
  Frame frame(svg, kLeft, kTop + kLines + kGap, kWidth - kLeft - kRight, kCents, x,
              {"Proxy above body [cents]", Scale::kLinear, -1.12 * largest, 1.12 * largest});
  frame.draw_axes(10, 5);
  svg.line(frame.left(), frame.y(0), frame.right(), frame.y(0), "axis");
  for (std::size_t k = 0; k < data.target.size(); ++k) {
    const double place = frame.x(data.target[k].frequency_hz);
    const double first = cents(data.before[k].frequency_hz, data.target[k].frequency_hz),
                 last = cents(data.after[k].frequency_hz, data.target[k].frequency_hz);
    svg.line(place, frame.y(first), place, frame.y(last), "rule thin");
    const bool hollow = k >= static_cast<std::size_t>(data.n_fitted);
    svg.marker(1, place, frame.y(first), 4,
               "first proxy, partial " + std::to_string(k + 1) + ": " + signed_cents(first), hollow);
    svg.marker(2, place, frame.y(last), 4, "fitted proxy, partial " + std::to_string(k + 1) + ": " + signed_cents(last),
               hollow);
  }
  return svg;
}

Svg proxy_shape_figure(const ProxyFitData& data) {
  constexpr double kHeight = 300, kTop = 40, kBottom = 34, kPane = (kWidth - 80) / 3;
  Svg svg(kWidth, kHeight, "Sections of the first and of the fitted ellipsoid, each through two axes.");
  const double longest = std::max(data.start.axes_m[2], data.fitted.axes_m[2]);
  const double pixels_per_m = std::min(kPane - 40, kHeight - kTop - kBottom) / (2 * longest);
  const char* names[] = {"a", "b", "c"};
  const std::array<std::array<std::size_t, 2>, 3> planes{{{2, 0}, {2, 1}, {1, 0}}};
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = 40 + (static_cast<double>(i) + 0.5) * kPane, y = kTop + 0.5 * (kHeight - kTop - kBottom);
    for (const bool fitted : {false, true}) {
      const auto& axes = (fitted ? data.fitted : data.start).axes_m;
      std::vector<PlotPoint> outline;
      for (int k = 0; k < 120; ++k) {
        const double angle = 2 * 3.14159265358979323846 * k / 120;
        outline.push_back({x + pixels_per_m * axes[planes[i][0]] * std::cos(angle),
                           y - pixels_per_m * axes[planes[i][1]] * std::sin(angle)});
      }
      svg.polyline(outline, fitted ? "s2 thick" : "s1 mid dash2", true);
    }
    svg.text(x, kHeight - 10, std::string(names[planes[i][0]]) + " across, " + names[planes[i][1]] + " up",
             "muted small", Anchor::kMiddle);
  }
  svg.line(40, kTop - 26, 80, kTop - 26, "s1 mid dash2");
  svg.text(86, kTop - 22, "First proxy", "small");
  svg.line(186, kTop - 26, 226, kTop - 26, "s2 thick");
  svg.text(232, kTop - 22, "Fitted proxy", "small");
  // A scale of 1, 2 or 5 times a power of ten, about a tenth of the width.
  const double wanted = 120 / pixels_per_m, power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double length = power * (wanted / power >= 5 ? 5 : wanted / power >= 2 ? 2 : 1);
  const double right = kWidth - 40;
  svg.line(right - length * pixels_per_m, kTop - 26, right, kTop - 26, "axis");
  svg.text(right - length * pixels_per_m - 8, kTop - 22, rounded(1000 * length, 2) + " mm", "small", Anchor::kEnd);
  return svg;
}

std::string proxy_measure_table(const ProxyFitData& data) {
  std::string body;
  for (const auto& m : data.measures) {
    const MeasureWords words = words_of(m.name);
    const double change = m.before > 0 ? 100 * (m.after / m.before - 1) : 0;
    body += "<tr>" + tag("th", escaped(words.words), "scope=\"row\"") +
            number_cell(rounded(m.before, 4) + " " + words.unit) + number_cell(rounded(m.after, 4) + " " + words.unit) +
            number_cell(m.before > 0 ? signed_number(change, 0) + " %" : "—") +
            number_cell(m.n_worse ? std::to_string(*m.n_worse) : "—") + "</tr>\n";
  }
  return scrolled(
             "<table><thead><tr><th scope=\"col\">Measure</th><th scope=\"col\" class=\"n\">First proxy</th><th "
             "scope=\"col\" class=\"n\">Fitted</th><th scope=\"col\" "
             "class=\"n\">Change</th><th scope=\"col\" class=\"n\">Tried and worse in it</th></tr></thead>\n<tbody>" +
                 body + "</tbody></table>",
             "Measures") +
         "<p class=\"how\"><small>Every measure is 0 for equal sounds. Compared: " + escaped(data.sound) + ". " +
         escaped(capitalised(data.loudness)) +
         ". Proxies whose spectrograms alone were a fifth worse are not in the last column.</small></p>\n";
}

std::string proxy_parameter_table(const ProxyFitData& data) {
  std::string body;
  const auto row = [&](const std::string& words, double before, double after) {
    body += "<tr>" + tag("th", words, "scope=\"row\"") + number_cell(rounded(before, 4)) +
            number_cell(rounded(after, 4)) + "</tr>\n";
  };
  const char* names[] = {"Semi-axis a [mm]", "Semi-axis b [mm]", "Semi-axis c [mm]"};
  for (std::size_t i = 0; i < 3; ++i) row(names[i], 1000 * data.start.axes_m[i], 1000 * data.fitted.axes_m[i]);
  row("Scale γ, length of (a, b, c) [mm]", 1000 * data.start.scale_m, 1000 * data.fitted.scale_m);
  row("Damping by mass [1/s]", data.start.rayleigh_mass_per_s, data.fitted.rayleigh_mass_per_s);
  row("Damping by stiffness [ns]", 1e9 * data.start.rayleigh_stiffness_s, 1e9 * data.fitted.rayleigh_stiffness_s);
  row("Gain", data.start.gain, data.fitted.gain);
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Parameter</th><th scope=\"col\" class=\"n\">First proxy</th><th "
      "scope=\"col\" class=\"n\">Fitted</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Parameters");
}

std::string proxy_partial_table(const ProxyFitData& data) {
  std::string body;
  for (std::size_t k = 0; k < data.target.size(); ++k) {
    const auto &t = data.target[k], &b = data.before[k], &a = data.after[k];
    body += "<tr" + std::string(k < static_cast<std::size_t>(data.n_fitted) ? "" : " class=\"open\"") + ">" +
            number_cell(std::to_string(k + 1)) + number_cell(fixed(t.frequency_hz, 1)) +
            number_cell(signed_number(cents(b.frequency_hz, t.frequency_hz), 1)) +
            number_cell(signed_number(cents(a.frequency_hz, t.frequency_hz), 1)) +
            number_cell(rounded(t.decay_per_s, 3)) + number_cell(rounded(b.decay_per_s, 3)) +
            number_cell(rounded(a.decay_per_s, 3)) + "</tr>\n";
  }
  return scrolled(
      "<table><thead><tr><th scope=\"col\" class=\"n\">Partial</th><th scope=\"col\" class=\"n\">Body [Hz]</th><th "
      "scope=\"col\" class=\"n\">First [cents]</th><th "
      "scope=\"col\" class=\"n\">Fitted [cents]</th><th scope=\"col\" class=\"n\">Decay, body [1/s]</th><th "
      "scope=\"col\" class=\"n\">first</th><th scope=\"col\" "
      "class=\"n\">fitted</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Partials");
}

std::string proxy_key_figures(const ProxyFitData& data) {
  std::string html;
  const auto key = [&](const std::string& name, const std::string& value, const std::string& note) {
    html += "<div><dt>" + name + "</dt><dd>" + value + (note.empty() ? "" : tag("small", note)) + "</dd></div>";
  };
  key("Partials off by", rounded(partials(data).after, 3) + " cents",
      "first proxy " + rounded(partials(data).before, 3));
  for (const auto& m : data.measures)
    if (m.name == "log_spectral_distance_db")
      key("Log-spectral distance", fixed(m.after, 2) + "\u202fdB", "first proxy " + fixed(m.before, 2));
  const auto& axes = data.fitted.axes_m;
  key("Semi-axes",
      rounded(1000 * axes[0], 3) + " × " + rounded(1000 * axes[1], 3) + " × " + rounded(1000 * axes[2], 3) + "\u202fmm",
      "fitted ellipsoid");
  if (data.n_candidates && data.n_refused)
    key("Proxies heard", std::to_string(*data.n_candidates),
        std::to_string(*data.n_refused) + " worse in some measure");
  return "<dl class=\"keys\">" + html + "</dl>\n";
}

std::vector<std::string> proxy_sentences(const ProxyFitData& data) {
  const auto& p = partials(data);
  std::vector<std::string> sentences;
  if (data.improved) {
    sentences.push_back("The fitted ellipsoid's partials lie <b>" + rounded(p.after, 3) +
                        " cents</b> from the body's (rms of the first " + std::to_string(data.n_fitted) +
                        "), where the first one's lay " + rounded(p.before, 3) + ", and no other measure is worse.");
  } else {
    sentences.push_back(
        "No ellipsoid was found that is nearer in its partials and no worse in every other measure: <b>the first one "
        "is kept</b>.");
  }
  if (data.least_partial_rms_cents && *data.least_partial_rms_cents < 0.95 * p.after) {
    const ProxyFitData::Measure* most = nullptr;
    for (const auto& m : data.measures)
      if (m.n_worse && (!most || *m.n_worse > *most->n_worse)) most = &m;
    sentences.push_back("Partials alone could come as near as " + rounded(*data.least_partial_rms_cents, 3) + " cents" +
                        (most && *most->n_worse > 0 ? "; what speaks against it most often is: " +
                                                          escaped(std::string(words_of(most->name).words))
                                                    : "") +
                        ".");
  }
  return sentences;
}

}  // namespace klang::reports::detail
