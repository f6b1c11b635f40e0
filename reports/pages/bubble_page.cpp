#include "reports/pages/bubble_page.hpp"

#include <algorithm>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

std::string with_std(double value, const Number& std, double factor) {
  if (!std || !(*std > 0)) return rounded(value * factor, 4);
  const int decimals = decimals_for(*std * factor);
  return fixed(value * factor, decimals) + " ± " + fixed(*std * factor, decimals);
}

std::vector<const BubbleRow*> bubbles_of(const BubbleData& data) {
  std::vector<const BubbleRow*> list;
  for (const BubbleRow& row : data.rows)
    if (row.is_bubble) list.push_back(&row);
  return list;
}

}  // namespace

Ridges ridges_of(const BubbleData& bubbles) {
  Ridges ridges;
  std::vector<double> pitches;
  for (const BubbleRow* row : bubbles_of(bubbles)) {
    ridges.lines.emplace_back();
    for (std::size_t i = 0; i < row->track_time_s.size(); ++i)
      ridges.lines.back().push_back({row->track_time_s[i], row->track_frequency_hz[i]});
    pitches.push_back(row->frequency_start_hz);
  }
  ridges.narrow = ridges.lines.size() > 20;
  if (bubbles.rows.empty()) return ridges;
  // About a dozen periods: as long as a bubble rings.
  std::sort(pitches.begin(), pitches.end());
  ridges.window_s = pitches.empty() ? 0.008 : std::clamp(12.0 / pitches[pitches.size() / 2], 0.002, 0.03);
  return ridges;
}

std::optional<Svg> bubble_decay_figure(const BubbleData& bubbles) {
  if (bubbles.rows.empty()) return {};
  constexpr double kWidth = 1080, kHeight = 420, kLeft = 66, kTop = 34, kRight = 150;
  std::vector<double> pitches, decays;
  for (const BubbleRow& row : bubbles.rows) {
    pitches.push_back(row.frequency_start_hz);
    decays.push_back(row.decay_per_s);
    if (row.theory_decay_per_s) decays.push_back(*row.theory_decay_per_s);
  }
  const AxisSpec x = axis_around("Frequency at the onset [Hz]", Scale::kLog, pitches, 0.12);
  const AxisSpec y = axis_around("Decay of amplitude [1/s]", Scale::kLog, decays, 0.16);
  Svg svg(kWidth, kHeight,
          "Decay rate of each ring over its pitch on logarithmic axes, and the curve of a free bubble's damping.");
  Frame frame(svg, kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48, x, y);
  frame.draw_axes(9, 8);
  std::vector<PlotPoint> curve;
  double end_y = frame.bottom();
  for (std::size_t i = 0; i < bubbles.theory_frequency_hz.size(); ++i) {
    curve.push_back({bubbles.theory_frequency_hz[i], bubbles.theory_decay_per_s[i]});
    if (frame.shows(curve.back().x, curve.back().y) && curve.size() > 1)
      end_y = std::min(end_y, frame.y(curve.back().y));
  }
  frame.curve(curve, "ink thick");
  svg.text(frame.right() + 8, end_y + 4, "free bubble", "small");
  for (const BubbleRow& row : bubbles.rows) {
    const double spread = row.decay_std_per_s.value_or(0);
    if (row.verdict.starts_with("too short")) continue;
    if (spread > 0)
      frame.error_bar(row.frequency_start_hz, std::max(row.decay_per_s - spread, 0.05 * row.decay_per_s),
                      row.decay_per_s + spread, "s0");
    svg.marker(0, frame.x(row.frequency_start_hz), frame.y(row.decay_per_s), 4.5,
               hertz(row.frequency_start_hz, row.frequency_std_hz) + " at " + rounded(row.onset_s, 4) +
                   " s: " + with_std(row.decay_per_s, row.decay_std_per_s, 1) + " 1/s" +
                   (row.theory_decay_per_s ? ", free bubble " + rounded(*row.theory_decay_per_s, 3) : "") +
                   (row.is_bubble ? "" : "; " + row.verdict),
               !row.is_bubble);
  }
  return svg;
}

std::string bubble_table(const BubbleData& bubbles) {
  std::string body;
  for (const BubbleRow& row : bubbles.rows) {
    body +=
        "<tr" + std::string(row.is_bubble ? "" : " class=\"open\"") + ">" + number_cell(fixed(row.onset_s, 4)) +
        number_cell(row.is_bubble ? with_std(row.frequency_start_hz, row.frequency_std_hz, 1)
                                  : rounded(row.frequency_start_hz, 3)) +
        number_cell(rounded(row.frequency_end_hz, 5)) +
        number_cell(row.is_bubble ? with_std(row.radius_m, row.radius_std_m, 1e3) : "—") +
        number_cell(row.is_bubble ? with_std(row.decay_per_s, row.decay_std_per_s, 1) : rounded(row.decay_per_s, 2)) +
        number_cell(row.theory_decay_per_s ? rounded(*row.theory_decay_per_s, 4) : "—") +
        number_cell(row.snr_db ? fixed(*row.snr_db, 1) : "—") + tag("td", escaped(row.verdict)) + "</tr>\n";
  }
  if (body.empty()) return "<p>No ring stands above the noise.</p>\n";
  return scrolled(
      "<table><thead><tr><th scope=\"col\" class=\"n\">Onset [s]</th><th scope=\"col\" class=\"n\">Frequency "
      "[Hz]</th><th scope=\"col\" "
      "class=\"n\">at the end</th><th scope=\"col\" class=\"n\">Radius [mm]</th><th scope=\"col\" class=\"n\">Decay "
      "[1/s]</th><th "
      "scope=\"col\" class=\"n\">free bubble</th><th scope=\"col\" class=\"n\">SNR [dB]</th><th "
      "scope=\"col\">Verdict</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Bubbles");
}

std::string pitch_table(const BubbleData& bubbles) {
  std::string body;
  for (const Estimate& e : bubbles.pitch) {
    body += "<tr" + std::string(e.identifiable ? "" : " class=\"open\"") + ">" +
            tag("th", escaped(e.name), "scope=\"row\"") +
            number_cell(e.value ? (e.std ? with_std(*e.value, e.std, 1) : rounded(*e.value, 5)) : "—") +
            number_cell(e.ci95 ? rounded((*e.ci95)[0], 4) + " to " + rounded((*e.ci95)[1], 4) : "—") +
            tag("td", e.identifiable ? "determined"
                      : e.value      ? "as given"
                                     : "not determined") +
            "</tr>\n";
  }
  std::string html =
      bubbles.pitch_message.empty() ? "" : tag("p", escaped(capitalised(bubbles.pitch_message)) + ".") + "\n";
  if (body.empty()) return html;
  return html + scrolled(
                    "<table><thead><tr><th scope=\"col\">Constant or combination</th><th scope=\"col\" "
                    "class=\"n\">Value</th><th "
                    "scope=\"col\" class=\"n\">95 % interval</th><th scope=\"col\"></th></tr></thead>\n<tbody>" +
                        body + "</tbody></table>",
                    "Pitch constants");
}

std::string bubble_key_figures(const ResultData& data) {
  std::string html;
  const auto key = [&](const std::string& name, const std::string& value, const std::string& note) {
    html += "<div><dt>" + name + "</dt><dd>" + value + (note.empty() ? "" : tag("small", note)) + "</dd></div>";
  };
  const auto bubbles = bubbles_of(data.bubbles);
  key("Bubbles", std::to_string(bubbles.size()),
      data.bubbles.rows.size() > bubbles.size()
          ? counted(data.bubbles.rows.size() - bubbles.size(), "other ring", "other rings")
          : "");
  if (!bubbles.empty()) {
    const auto [least, most] =
        std::minmax_element(bubbles.begin(), bubbles.end(), [](auto* a, auto* b) { return a->radius_m < b->radius_m; });
    key("Radius",
        rounded(1e3 * (*least)->radius_m, 3) +
            (bubbles.size() > 1 ? " to " + rounded(1e3 * (*most)->radius_m, 3) : "") + "\u202fmm",
        "");
    key("Pitch",
        rounded((*most)->frequency_start_hz, 4) +
            (bubbles.size() > 1 ? " to " + rounded((*least)->frequency_start_hz, 4) : "") + "\u202fHz",
        "at the onset");
  }
  for (const Estimate& e : data.bubbles.pitch)
    if (!e.derived && e.identifiable && e.value)
      key(e.name == "k_delta_per_m" ? "K<sub>Δ</sub>" : escaped(e.name), rounded(*e.value, 4),
          e.std ? "± " + rounded(*e.std, 2) : "");
  if (!data.specimens.empty() && data.specimens.front().explained_energy)
    key("Energy explained", rounded(100 * *data.specimens.front().explained_energy, 4) + " %",
        "in band, noise whitened");
  return "<dl class=\"keys\">" + html + "</dl>\n";
}

std::vector<std::string> bubble_sentences(const ResultData& data) {
  const auto bubbles = bubbles_of(data.bubbles);
  if (bubbles.empty())
    return {"No bubble was heard: no ring that decays as a gas bubble of its pitch does stands above the noise."};
  const auto clarity = [](const BubbleRow* row) {
    return row->snr_db.value_or(0) - (row->verdict == "bubble" ? 0 : 200);
  };
  const BubbleRow& loudest =
      **std::max_element(bubbles.begin(), bubbles.end(), [&](auto* a, auto* b) { return clarity(a) < clarity(b); });
  std::vector<std::string> sentences = {
      (bubbles.size() == 1 ? std::string("One bubble was heard")
                           : counted(bubbles.size(), "bubble was", "bubbles were") + " heard; the clearest") +
      ", at " + rounded(loudest.onset_s, 4) + " s, rings at <b>" +
      escaped(hertz(loudest.frequency_start_hz, loudest.frequency_std_hz)) + "</b>: a radius of <b>" +
      with_std(loudest.radius_m, loudest.radius_std_m, 1e3) + " mm</b>. Its amplitude falls by " +
      rounded(loudest.decay_per_s, 3) + " per second" +
      (loudest.theory_decay_per_s ? "; a free bubble of this pitch by " + rounded(*loudest.theory_decay_per_s, 3)
                                  : "") +
      "."};
  const double rise = loudest.frequency_end_hz / loudest.frequency_start_hz;
  if (std::abs(rise - 1) > 0.005)
    sentences.push_back("While it is heard its pitch " + std::string(rise > 1 ? "rises" : "falls") + " by " +
                        rounded(100 * std::abs(rise - 1), 2) + " %.");
  return sentences;
}

}  // namespace klang::reports::detail
