// The page of klang proxy study.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/config/named_numbers.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/sound_media.hpp"
#include "validate/debris/debris_document.hpp"

namespace klang::reports::detail {
namespace {

using validate::DebrisDocument;
using validate::PieceRecord;
using validate::ThresholdRecord;
using validate::ThresholdTimes;

constexpr double kWidth = 1080, kHeight = 380, kLeft = 66, kTop = 34, kRight = 24;

std::string dash(const Number& value, int digits = 3) { return value ? rounded(*value, digits) : "—"; }

std::string head(const std::string& word, bool number = true) {
  return "<th scope=\"col\"" + std::string(number ? " class=\"n\"" : "") + ">" + word + "</th>";
}

std::string table(const std::string& heads, const std::string& body, const std::string& label) {
  return scrolled("<table><thead><tr>" + heads + "</tr></thead>\n<tbody>" + body + "</tbody></table>", label);
}

AxisSpec threshold_axis(const DebrisDocument& data) {
  double highest = 1.0;
  for (const ThresholdRecord& row : data.thresholds) highest = std::max(highest, row.threshold_hz);
  return {"ω_proxy / 2π [Hz]: pieces above it sound by their proxies", Scale::kLinear, -0.03 * highest, 1.04 * highest};
}

double seconds(const std::map<std::string, double>& stages) {
  double sum = 0;
  for (const auto& stage : stages) sum += stage.second;
  return sum;
}

/// Times of the row of the same number; none where the file has fewer.
template <class Times>
Times times_at(const std::vector<Times>& times, std::size_t i) {
  return i < times.size() ? times[i] : Times{};
}

Svg error_figure(const DebrisDocument& data) {
  struct Line {
    const char* name;
    Number ThresholdRecord::*value;
  };
  const std::array<Line, 4> lines{{{"log-spectral", &ThresholdRecord::log_spectral_distance_db},
                                   {"mel", &ThresholdRecord::mel_distance_db},
                                   {"third octaves", &ThresholdRecord::third_octave_db},
                                   {"loudness, A-weighted, either way", &ThresholdRecord::loudness_difference_db}}};
  double highest = 1e-3;
  for (const ThresholdRecord& row : data.thresholds)
    for (const Line& line : lines) highest = std::max(highest, std::abs((row.*line.value).value_or(0)));
  Svg svg(kWidth, kHeight,
          "Distances of the mix from the mix of direct sounds over the threshold: they fall as fewer pieces sound by "
          "proxies.");
  Frame frame(svg, {kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48}, threshold_axis(data),
              {"Distance from the direct mix [dB]", Scale::kLinear, 0, 1.08 * highest});
  frame.draw_axes(9, 6);
  double legend = kLeft + 8;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::vector<PlotPoint> points;
    for (const ThresholdRecord& row : data.thresholds)
      if (row.*lines[i].value) points.push_back({row.threshold_hz, std::abs(*(row.*lines[i].value))});
    frame.curve(points, "s" + std::to_string(i) + " mid");
    for (const PlotPoint& p : points)
      svg.marker(static_cast<int>(i), frame.x(p.x), frame.y(p.y), 4,
                 std::string(lines[i].name) + ": " + fixed(p.y, 2) + " dB from " + fixed(p.x, 0) + " Hz");
    svg.marker(static_cast<int>(i), legend, kTop - 16, 4, "");
    svg.text(legend + 10, kTop - 12, lines[i].name, "small");
    legend += 40 + 7.0 * static_cast<double>(std::string_view(lines[i].name).size());
  }
  return svg;
}

Svg time_figure(const DebrisDocument& data) {
  std::vector<double> times;
  for (const ThresholdTimes& row : data.timings.thresholds)
    for (const Number& value : {row.direct_s, row.with_proxies_s})
      if (value && *value > 0) times.push_back(*value);
  Svg svg(kWidth, kHeight, "Processor time with proxies over the threshold, beside the time of the direct way.");
  AxisSpec y = axis_around("Processor time [s]", Scale::kLog, times, 0.08);
  Frame frame(svg, {kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48}, threshold_axis(data), y);
  frame.draw_axes(9, 6);
  std::vector<PlotPoint> direct, with;
  for (std::size_t i = 0; i < data.thresholds.size(); ++i) {
    const ThresholdTimes times_s = times_at(data.timings.thresholds, i);
    const double hz = data.thresholds[i].threshold_hz;
    if (times_s.direct_s) direct.push_back({hz, *times_s.direct_s});
    if (times_s.with_proxies_s) with.push_back({hz, *times_s.with_proxies_s});
  }
  frame.curve(direct, "s0 mid dash2");
  frame.curve(with, "s1 mid");
  for (const PlotPoint& p : with)
    svg.marker(1, frame.x(p.x), frame.y(p.y), 4, rounded(p.y, 3) + " s from " + fixed(p.x, 0) + " Hz");
  svg.line(kLeft + 8, kTop - 16, kLeft + 28, kTop - 16, "s0 mid dash2");
  svg.text(kLeft + 34, kTop - 12, "all pieces directly", "small");
  svg.marker(1, kLeft + 180, kTop - 16, 4, "");
  svg.text(kLeft + 190, kTop - 12,
           "proxies above the threshold, the single-frequency calculation of every piece included", "small");
  return svg;
}

std::string threshold_table(const DebrisDocument& data) {
  std::string body;
  for (std::size_t i = 0; i < data.thresholds.size(); ++i) {
    const ThresholdRecord& row = data.thresholds[i];
    const ThresholdTimes times = times_at(data.timings.thresholds, i);
    const bool timed = times.direct_s && times.with_proxies_s && *times.with_proxies_s > 0;
    body += "<tr>" + number_cell(fixed(row.threshold_hz, 0), row.threshold_hz) +
            number_cell(std::to_string(row.replaced)) +
            number_cell(fixed(row.modes_replaced_percent, 1), row.modes_replaced_percent) +
            number_cell(dash(times.direct_s), times.direct_s) +
            number_cell(dash(times.with_proxies_s), times.with_proxies_s) +
            number_cell(timed ? rounded(*times.direct_s / *times.with_proxies_s, 3) : "—",
                        timed ? Number(*times.direct_s / *times.with_proxies_s) : Number()) +
            number_cell(dash(row.log_spectral_distance_db), row.log_spectral_distance_db) +
            number_cell(dash(row.mel_distance_db), row.mel_distance_db) +
            number_cell(dash(row.third_octave_db), row.third_octave_db) +
            number_cell(row.loudness_difference_db ? fixed(*row.loudness_difference_db, 2) : "—",
                        row.loudness_difference_db) +
            "</tr>\n";
  }
  return table(head("ω_proxy / 2π [Hz]") + head("Pieces replaced") + head("Modes replaced [%]") + head("Direct [s]") +
                   head("With proxies [s]") + head("Ratio") + head("Log-spectral [dB]") + head("Mel [dB]") +
                   head("Third octaves [dB]") + head("Loudness [dB(A)]"),
               body, "Thresholds");
}

std::string piece_table(const DebrisDocument& data) {
  std::string body;
  for (std::size_t i = 0; i < data.pieces.size(); ++i) {
    const PieceRecord& row = data.pieces[i];
    const validate::PieceTimes times = times_at(data.timings.pieces, i);
    const std::string note = std::string(row.clamped ? "thinner than the bank" : "") +
                             (row.clamped && row.bank_too_short ? ", " : "") +
                             (row.bank_too_short ? "the bank has too few modes" : "");
    const auto error = [&](double fit::ProxyErrors::*measure) {
      return row.errors ? dash(measured((*row.errors).*measure)) : "—";
    };
    body += "<tr>" +
            tag("th", escaped(row.name) + (note.empty() ? "" : "<br><small>" + note + "</small>"), "scope=\"row\"") +
            number_cell(row.lowest_direct_hz ? fixed(*row.lowest_direct_hz, 1) : "—", row.lowest_direct_hz) +
            number_cell(fixed(row.lowest_hz, 1), row.lowest_hz) + number_cell(std::to_string(row.modes)) +
            number_cell(std::to_string(row.proxy_modes)) + number_cell(error(&fit::ProxyErrors::partial_rms_cents)) +
            number_cell(error(&fit::ProxyErrors::log_spectral_distance_db)) +
            number_cell(error(&fit::ProxyErrors::mel_distance_db)) +
            number_cell(error(&fit::ProxyErrors::third_octave_db)) +
            number_cell(error(&fit::ProxyErrors::loudness_difference_db)) +
            number_cell(dash(times.direct_s), times.direct_s) +
            number_cell(times.proxy_s ? rounded(1e3 * *times.proxy_s, 3) : "—",
                        times.proxy_s ? Number(1e3 * *times.proxy_s) : Number()) +
            "</tr>\n";
  }
  return table(head("Piece", false) + head("Lowest, mesh [Hz]") + head("Lowest, alone [Hz]") + head("Modes") +
                   head("of the proxy") + head("Partials [cents]") + head("Log-spectral [dB]") + head("Mel [dB]") +
                   head("Third octaves [dB]") + head("Loudness [dB(A)]") + head("Direct [s]") + head("Proxy [ms]"),
               body, "Pieces");
}

std::string stage_table(const DebrisDocument& data) {
  std::string body;
  const auto add = [&](const char* way, const std::map<std::string, double>& stages) {
    const double all = seconds(stages);
    for (const auto& [name, time] : stages)
      body += "<tr>" + tag("td", way) + tag("td", escaped(name.substr(0, name.rfind("_s")))) +
              number_cell(rounded(1e3 * time, 3), 1e3 * time) +
              number_cell(all > 0 ? fixed(100 * time / all, 1) : "—", all > 0 ? Number(100 * time / all) : Number()) +
              "</tr>\n";
  };
  add("direct", numbers_of(data.timings.direct_stages));
  add("proxy", numbers_of(data.timings.proxy_stages));
  return table(head("Way", false) + head("Stage", false) + head("Processor time, all pieces [ms]") + head("Share [%]"),
               body, "Stages");
}

std::string key_figures(const DebrisDocument& data) {
  KeyFigures keys;
  keys.add("Pieces", std::to_string(data.pieces.size()), "");
  if (data.timings.speedup)
    keys.add("Proxies are cheaper by", rounded(*data.timings.speedup, 3) + "×",
             "single-frequency calculation included");
  if (data.timings.speedup_without_lowest)
    keys.add("Without that calculation", rounded(*data.timings.speedup_without_lowest, 3) + "×", "");
  if (!data.thresholds.empty()) {
    const ThresholdRecord& all = data.thresholds.front();
    if (all.log_spectral_distance_db)
      keys.add("All by proxies", fixed(*all.log_spectral_distance_db, 1) + "\u202fdB",
               "log-spectral distance of the mix");
    if (all.loudness_difference_db)
      keys.add("Their loudness", fixed(*all.loudness_difference_db, 1) + "\u202fdB(A)", "proxies minus direct");
  }
  return keys.html();
}

std::vector<std::string> sentences_of(const DebrisDocument& data) {
  std::vector<std::string> sentences;
  if (data.timings.speedup && data.timings.speedup_without_lowest)
    sentences.push_back(
        "Sounding <b>" + counted(data.pieces.size(), "piece", "pieces") + "</b> by ellipsoids took <b>" +
        rounded(*data.timings.speedup, 3) + " times</b> less processor time than the direct way in this run, " +
        rounded(*data.timings.speedup_without_lowest, 3) +
        " times without the calculation of each piece’s lowest frequency. Times do not come out the same again.");
  const auto n_clamped = static_cast<std::size_t>(
      std::count_if(data.pieces.begin(), data.pieces.end(), [](const PieceRecord& p) { return p.clamped; }));
  const auto n_short = static_cast<std::size_t>(
      std::count_if(data.pieces.begin(), data.pieces.end(), [](const PieceRecord& p) { return p.bank_too_short; }));
  if (n_clamped > 0)
    sentences.push_back(capitalised(counted(n_clamped, "piece is", "pieces are")) +
                        " thinner than the bank’s thinnest shape and took that.");
  if (n_short > 0)
    sentences.push_back(capitalised(counted(n_short, "piece", "pieces")) +
                        " took a cell whose modes all lie in the band: higher ones are missing.");
  return sentences;
}

std::string curve_html(const DebrisDocument& data, ReportFolder& folder) {
  const Svg error = error_figure(data), time = time_figure(data);
  folder.add_figure("error", error);
  folder.add_figure("time", time);
  return figure(sheet(error),
                "The mix of all pieces with proxies above the threshold against the mix of direct sounds; at the "
                "left all pieces sound by proxies.") +
         figure(sheet(time), "Processor time of all threads: modes, radiation and audio.") + threshold_table(data);
}

std::string sound_html(const DebrisDocument& data, ReportFolder& folder) {
  SoundPair sounds;
  sounds.name = "the direct mix";
  sounds.recorded = folder.sound_beside(data.direct_sound);
  sounds.computed = folder.sound_beside(data.proxy_sound);
  if (std::min(sounds.recorded.n_frames(), sounds.computed.n_frames()) < 16) return {};
  sounds.highest_hz = 20000.0;
  sounds.recorded_words = "Direct";
  sounds.computed_words = "Proxies";
  const SoundMedia media = sound_media(sounds, 1, folder);
  sounds.name.clear();
  sounds.recorded_words = "All directly";
  sounds.computed_words = "All by proxies";
  return players(media, sounds) + spectrogram_html(media, "Spectrograms of both mixes on one scale of level.");
}

Page make(const DebrisDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · sound proxies";
  page.title = "Debris by ellipsoids";
  page.verdict = {"Done", "good", counted(data.pieces.size(), "piece", "pieces")};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  page.sections = {{"curve", "Error and time", curve_html(data, folder)},
                   {"sound", "Sound", sound_html(data, folder)},
                   {"pieces", "Pieces", piece_table(data)},
                   {"stages", "Stages", stage_table(data)}};
  add_if_there("study.csv", "– pieces and thresholds", folder, page.downloads);
  add_if_there(data.direct_sound, "– all pieces directly", folder, page.downloads);
  add_if_there(data.proxy_sound, "– all pieces by proxies", folder, page.downloads);
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind proxy_study_page() { return page_kind<DebrisDocument>("proxy_study", make); }

}  // namespace klang::reports::detail
