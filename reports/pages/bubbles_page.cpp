// The page of klang bubble fit.
#include <algorithm>
#include <cmath>

#include "core/foundation/config/fields_csv.hpp"
#include "fit/bubble/bubble_document.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/body_facts.hpp"
#include "reports/pages/fit_tables.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"
#include "reports/pages/sound_media.hpp"

namespace klang::reports::detail {
namespace {

std::string with_std(double value, const Number& std, double factor) {
  if (!std || !(*std > 0)) return rounded(value * factor, 4);
  const int decimals = decimals_for(*std * factor);
  return fixed(value * factor, decimals) + " ± " + fixed(*std * factor, decimals);
}

using fit::bubble::BubbleRecord;
using fit::bubble::BubblesDocument;

/// Bubbles, then other rings.
struct Ring {
  const BubbleRecord& row;
  bool is_bubble;
};
std::vector<Ring> rings_of(const BubblesDocument& data) {
  std::vector<Ring> rings;
  for (const BubbleRecord& row : data.bubbles) rings.push_back({row, true});
  for (const BubbleRecord& row : data.rejected) rings.push_back({row, false});
  return rings;
}

/// The fitted chirps as lines over a spectrogram, and a window that shows chirps of their pitch.
Ridges ridges_of(const BubblesDocument& data) {
  Ridges ridges;
  std::vector<double> pitches;
  for (const BubbleRecord& row : data.bubbles) {
    ridges.lines.emplace_back();
    for (std::size_t i = 0; i < row.track.time_s.size(); ++i)
      ridges.lines.back().push_back({row.track.time_s[i], row.track.frequency_hz[i]});
    pitches.push_back(row.frequency_start_hz);
  }
  ridges.narrow = ridges.lines.size() > 20;
  if (data.bubbles.empty() && data.rejected.empty()) return ridges;
  // About a dozen periods: as long as a bubble rings.
  std::sort(pitches.begin(), pitches.end());
  ridges.window_s = pitches.empty() ? 0.008 : std::clamp(12.0 / pitches[pitches.size() / 2], 0.002, 0.03);
  return ridges;
}

/// Measured decay over pitch against a free bubble's; empty without rings.
std::optional<Svg> bubble_decay_figure(const BubblesDocument& data) {
  const std::vector<Ring> rings = rings_of(data);
  if (rings.empty()) return {};
  constexpr double kWidth = 1080, kHeight = 420, kLeft = 66, kTop = 34, kRight = 150;
  std::vector<double> pitches, decays;
  for (const auto& [row, is_bubble] : rings) {
    pitches.push_back(row.frequency_start_hz);
    decays.push_back(row.decay_per_s);
    if (row.theory_decay_per_s) decays.push_back(*row.theory_decay_per_s);
  }
  const AxisSpec x = axis_around("Frequency at the onset [Hz]", Scale::kLog, pitches, 0.12);
  const AxisSpec y = axis_around("Decay of amplitude [1/s]", Scale::kLog, decays, 0.16);
  Svg svg(kWidth, kHeight,
          "Decay rate of each ring over its pitch on logarithmic axes, and the curve of a free bubble's damping.");
  Frame frame(svg, {kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48}, x, y);
  frame.draw_axes(9, 8);
  std::vector<PlotPoint> curve;
  double end_y = frame.bottom();
  for (std::size_t i = 0; i < data.theory.frequency_hz.size(); ++i) {
    curve.push_back({data.theory.frequency_hz[i], data.theory.decay_per_s[i]});
    if (frame.shows(curve.back().x, curve.back().y) && curve.size() > 1)
      end_y = std::min(end_y, frame.y(curve.back().y));
  }
  frame.curve(curve, "ink thick");
  svg.text(frame.right() + 8, end_y + 4, "free bubble", "small");
  for (const auto& [row, is_bubble] : rings) {
    const double spread = row.decay_std_per_s.value_or(0);
    if (row.verdict.starts_with("too short")) continue;
    if (spread > 0)
      frame.error_bar(row.frequency_start_hz, std::max(row.decay_per_s - spread, 0.05 * row.decay_per_s),
                      row.decay_per_s + spread, "s0");
    svg.marker(0, frame.x(row.frequency_start_hz), frame.y(row.decay_per_s), 4.5,
               hertz(row.frequency_start_hz, row.frequency_start_std_hz) + " at " + rounded(row.onset_s, 4) +
                   " s: " + with_std(row.decay_per_s, row.decay_std_per_s, 1) + " 1/s" +
                   (row.theory_decay_per_s ? ", free bubble " + rounded(*row.theory_decay_per_s, 3) : "") +
                   (is_bubble ? "" : "; " + row.verdict),
               !is_bubble);
  }
  return svg;
}

std::string bubble_table(const BubblesDocument& data) {
  std::string body;
  for (const auto& [row, is_bubble] : rings_of(data)) {
    body += "<tr" + std::string(is_bubble ? "" : " class=\"open\"") + ">" +
            number_cell(fixed(row.onset_s, 4), row.onset_s) +
            number_cell(is_bubble ? with_std(row.frequency_start_hz, row.frequency_start_std_hz, 1)
                                  : rounded(row.frequency_start_hz, 3)) +
            number_cell(rounded(row.frequency_end_hz, 5), row.frequency_end_hz) +
            number_cell(is_bubble ? with_std(row.radius_m, row.radius_std_m, 1e3) : "—",
                        is_bubble ? Number(row.radius_m) : Number()) +
            number_cell(is_bubble ? with_std(row.decay_per_s, row.decay_std_per_s, 1) : rounded(row.decay_per_s, 2),
                        row.decay_per_s) +
            number_cell(row.theory_decay_per_s ? rounded(*row.theory_decay_per_s, 4) : "—", row.theory_decay_per_s) +
            number_cell(row.snr_db ? fixed(*row.snr_db, 1) : "—", row.snr_db) + tag("td", escaped(row.verdict)) +
            "</tr>\n";
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

struct PitchRow {
  const fit::bubble::PitchRecord& record;
  const std::string& name;
};
/// Constants, then combinations.
std::vector<PitchRow> pitch_rows(const fit::bubble::PitchFitRecord& pitch) {
  std::vector<PitchRow> rows;
  for (const fit::bubble::PitchRecord& e : pitch.parameters) rows.push_back({e, e.name});
  for (const fit::bubble::PitchRecord& e : pitch.identifiable) rows.push_back({e, e.combination});
  return rows;
}

std::string pitch_table(const fit::bubble::PitchFitRecord& pitch) {
  std::string body;
  for (const auto& [e, name] : pitch_rows(pitch)) {
    body += "<tr" + std::string(e.identifiable ? "" : " class=\"open\"") + ">" +
            tag("th", escaped(name), "scope=\"row\"") +
            number_cell(e.value ? (e.std ? with_std(*e.value, e.std, 1) : rounded(*e.value, 5)) : "—") +
            number_cell(e.ci95 ? rounded((*e.ci95)[0], 4) + " to " + rounded((*e.ci95)[1], 4) : "—",
                        e.ci95 ? Number((*e.ci95)[0]) : Number()) +
            tag("td", e.identifiable ? "determined"
                      : e.value      ? "as given"
                                     : "not determined") +
            "</tr>\n";
  }
  std::string html = pitch.message.empty() ? "" : tag("p", escaped(capitalised(pitch.message)) + ".") + "\n";
  if (body.empty()) return html;
  return html + scrolled(
                    "<table><thead><tr><th scope=\"col\">Constant or combination</th><th scope=\"col\" "
                    "class=\"n\">Value</th><th "
                    "scope=\"col\" class=\"n\">95 % interval</th><th scope=\"col\"></th></tr></thead>\n<tbody>" +
                        body + "</tbody></table>",
                    "Pitch constants");
}

std::string key_figures(const BubblesDocument& data) {
  KeyFigures keys;
  const std::vector<BubbleRecord>& bubbles = data.bubbles;
  keys.add("Bubbles", std::to_string(bubbles.size()),
           data.rejected.empty() ? "" : counted(data.rejected.size(), "other ring", "other rings"));
  if (!bubbles.empty()) {
    const auto [least, most] = std::minmax_element(
        bubbles.begin(), bubbles.end(), [](const auto& a, const auto& b) { return a.radius_m < b.radius_m; });
    keys.add("Radius",
             rounded(1e3 * least->radius_m, 3) + (bubbles.size() > 1 ? " to " + rounded(1e3 * most->radius_m, 3) : "") +
                 "\u202fmm",
             "");
    keys.add("Pitch",
             rounded(most->frequency_start_hz, 4) +
                 (bubbles.size() > 1 ? " to " + rounded(least->frequency_start_hz, 4) : "") + "\u202fHz",
             "at the onset");
  }
  for (const fit::bubble::PitchRecord& e : data.pitch.parameters)
    if (e.identifiable && e.value)
      keys.add(e.name == "k_delta_per_m" ? "K<sub>Δ</sub>" : escaped(e.name), rounded(*e.value, 4),
               e.std ? "± " + rounded(*e.std, 2) : "");
  if (data.explained_energy)
    keys.add("Energy explained", rounded(100 * *data.explained_energy, 4) + " %", "in band, noise whitened");
  return keys.html();
}

std::vector<std::string> sentences_of(const BubblesDocument& data) {
  const std::vector<BubbleRecord>& bubbles = data.bubbles;
  if (bubbles.empty())
    return {"No bubble was heard: no ring that decays as a gas bubble of its pitch does stands above the noise."};
  if (data.header.status == "not_bubbles")
    return {"As a whole this is <b>no recording of bubbles</b>: " + escaped(data.header.message.value_or("")) +
            ". The rings below look like bubbles one by one; none of their numbers is to be relied on."};
  const auto clarity = [](const BubbleRecord& row) {
    return row.snr_db.value_or(0) - (row.verdict == "bubble" ? 0 : 200);
  };
  const BubbleRecord& loudest = *std::max_element(
      bubbles.begin(), bubbles.end(), [&](const auto& a, const auto& b) { return clarity(a) < clarity(b); });
  std::vector<std::string> sentences = {
      (bubbles.size() == 1 ? std::string("One bubble was heard")
                           : counted(bubbles.size(), "bubble was", "bubbles were") + " heard; the clearest") +
      ", at " + rounded(loudest.onset_s, 4) + " s, rings at <b>" +
      escaped(hertz(loudest.frequency_start_hz, loudest.frequency_start_std_hz)) + "</b>: a radius of <b>" +
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

SoundPair sounds_of(const BubblesDocument& data, ReportFolder& folder) {
  const fit::bubble::BubbleFiles files = data.files.value_or(fit::bubble::BubbleFiles{});
  SoundPair sounds;
  sounds.name = data.name;
  sounds.recorded = folder.sound_beside(files.recording.value_or(""));
  sounds.computed = folder.sound_beside(files.resynthesis.value_or(""));
  for (const Ring& ring : rings_of(data))
    sounds.highest_hz = std::max({sounds.highest_hz, ring.row.frequency_start_hz, ring.row.frequency_end_hz});
  if (sounds.highest_hz > 0) {
    sounds.lowest_hz = sounds.highest_hz;
    for (const BubbleRecord& row : data.bubbles)
      sounds.lowest_hz = std::min({*sounds.lowest_hz, row.frequency_start_hz, row.frequency_end_hz});
  }
  sounds.ridges = ridges_of(data);
  sounds.computed_words = "Fitted chirps";
  return sounds;
}

Page make(const BubblesDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · bubbles in a recording";
  page.title = data.name.empty() ? "Result" : data.name;
  const std::size_t n = data.bubbles.size();
  const bool refused = data.header.status == "not_bubbles";
  page.verdict = {refused ? "No recording of bubbles"
                  : n > 0 ? capitalised(counted(n, "bubble", "bubbles"))
                          : "No bubble",
                  refused ? "bad"
                  : n > 0 ? "good"
                          : "fair",
                  ""};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  std::string damping;
  if (const std::optional<Svg> decays = bubble_decay_figure(data)) {
    folder.add_figure("decays", *decays);
    damping = figure(sheet(*decays),
                     "Decay of the amplitude over the pitch at the onset; the line is a free bubble's damping by "
                     "radiation, viscosity and heat, the least that a bubble of this pitch can have. Bars are one "
                     "standard deviation; hollow marks are rings that are no bubbles.");
  }
  const SoundPair sounds = sounds_of(data, folder);
  const SoundMedia media = sound_media(sounds, 1, folder);
  BodyFacts facts;
  facts.explained_energy = data.explained_energy;
  page.sections = {{"sound", "Sound",
                    players(media, sounds) +
                        spectrogram_html(media,
                                         "Spectrograms on one scale of level; bright lines over the recording are the "
                                         "fitted chirps while they are heard. The difference is taken between "
                                         "magnitudes: what is bright there is energy that one has and the other has "
                                         "not.") +
                        facts_html(facts)},
                   {"bubbles", "Bubbles", bubble_table(data)},
                   {"damping", "Damping", damping},
                   {"pitch", "Pitch constants", pitch_table(data.pitch)}};
  // No measured partials: the table's head alone, as every page of a recording has it.
  add_table("partials.csv", csv_table(std::vector<PartialRow>{}), data.header.provenance.inputs, folder,
            page.downloads);
  if (data.files) {
    add_if_there(data.files->recording, "– recording", folder, page.downloads);
    add_if_there(data.files->resynthesis, "– fitted model’s sound", folder, page.downloads);
  }
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind bubbles_page() { return page_kind<BubblesDocument>("bubbles", make); }

}  // namespace klang::reports::detail
