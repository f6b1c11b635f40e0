#include "reports/pages/proxy_study_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kWidth = 1080, kHeight = 380, kLeft = 66, kTop = 34, kRight = 24;

std::string dash(const Number& value, int digits = 3) { return value ? rounded(*value, digits) : "—"; }

std::string head(const std::string& word, bool number = true) {
  return "<th scope=\"col\"" + std::string(number ? " class=\"n\"" : "") + ">" + word + "</th>";
}

std::string table(const std::string& heads, const std::string& body, const std::string& label) {
  return scrolled("<table><thead><tr>" + heads + "</tr></thead>\n<tbody>" + body + "</tbody></table>", label);
}

AxisSpec threshold_axis(const ProxyStudyData& data) {
  double highest = 1.0;
  for (const ProxyThresholdRow& row : data.thresholds) highest = std::max(highest, row.threshold_hz);
  return {"ω_proxy / 2π [Hz]: pieces above it sound by their proxies", Scale::kLinear, -0.03 * highest, 1.04 * highest};
}

double seconds(const std::vector<std::pair<std::string, double>>& stages) {
  double sum = 0;
  for (const auto& stage : stages) sum += stage.second;
  return sum;
}

}  // namespace

Svg proxy_error_figure(const ProxyStudyData& data) {
  struct Line {
    const char* name;
    Number ProxyThresholdRow::*value;
  };
  const std::array<Line, 4> lines{{{"log-spectral", &ProxyThresholdRow::log_spectral_distance_db},
                                   {"mel", &ProxyThresholdRow::mel_distance_db},
                                   {"third octaves", &ProxyThresholdRow::third_octave_db},
                                   {"loudness, A-weighted, either way", &ProxyThresholdRow::loudness_difference_db}}};
  double highest = 1e-3;
  for (const ProxyThresholdRow& row : data.thresholds)
    for (const Line& line : lines) highest = std::max(highest, std::abs((row.*line.value).value_or(0)));
  Svg svg(kWidth, kHeight,
          "Distances of the mix from the mix of direct sounds over the threshold: they fall as fewer pieces sound by "
          "proxies.");
  Frame frame(svg, kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48, threshold_axis(data),
              {"Distance from the direct mix [dB]", Scale::kLinear, 0, 1.08 * highest});
  frame.draw_axes(9, 6);
  double legend = kLeft + 8;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::vector<PlotPoint> points;
    for (const ProxyThresholdRow& row : data.thresholds)
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

Svg proxy_time_figure(const ProxyStudyData& data) {
  std::vector<double> times;
  for (const ProxyThresholdRow& row : data.thresholds)
    for (const Number& value : {row.direct_s, row.with_proxies_s})
      if (value && *value > 0) times.push_back(*value);
  Svg svg(kWidth, kHeight, "Processor time with proxies over the threshold, beside the time of the direct way.");
  AxisSpec y = axis_around("Processor time [s]", Scale::kLog, times, 0.08);
  Frame frame(svg, kLeft, kTop, kWidth - kLeft - kRight, kHeight - kTop - 48, threshold_axis(data), y);
  frame.draw_axes(9, 6);
  std::vector<PlotPoint> direct, with;
  for (const ProxyThresholdRow& row : data.thresholds) {
    if (row.direct_s) direct.push_back({row.threshold_hz, *row.direct_s});
    if (row.with_proxies_s) with.push_back({row.threshold_hz, *row.with_proxies_s});
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

std::string proxy_threshold_table(const ProxyStudyData& data) {
  std::string body;
  for (const ProxyThresholdRow& row : data.thresholds) {
    const bool timed = row.direct_s && row.with_proxies_s && *row.with_proxies_s > 0;
    body += "<tr>" + number_cell(fixed(row.threshold_hz, 0)) + number_cell(std::to_string(row.n_replaced)) +
            number_cell(fixed(row.modes_replaced_percent, 1)) + number_cell(dash(row.direct_s)) +
            number_cell(dash(row.with_proxies_s)) +
            number_cell(timed ? rounded(*row.direct_s / *row.with_proxies_s, 3) : "—") +
            number_cell(dash(row.log_spectral_distance_db)) + number_cell(dash(row.mel_distance_db)) +
            number_cell(dash(row.third_octave_db)) +
            number_cell(row.loudness_difference_db ? fixed(*row.loudness_difference_db, 2) : "—") + "</tr>\n";
  }
  return table(head("ω_proxy / 2π [Hz]") + head("Pieces replaced") + head("Modes replaced [%]") + head("Direct [s]") +
                   head("With proxies [s]") + head("Ratio") + head("Log-spectral [dB]") + head("Mel [dB]") +
                   head("Third octaves [dB]") + head("Loudness [dB(A)]"),
               body, "Thresholds");
}

std::string proxy_piece_table(const ProxyStudyData& data) {
  std::string body;
  for (const ProxyPieceRow& row : data.pieces) {
    const std::string note = std::string(row.clamped ? "thinner than the bank" : "") +
                             (row.clamped && row.bank_too_short ? ", " : "") +
                             (row.bank_too_short ? "the bank has too few modes" : "");
    body += "<tr>" +
            tag("th", escaped(row.name) + (note.empty() ? "" : "<br><small>" + note + "</small>"), "scope=\"row\"") +
            number_cell(row.lowest_direct_hz ? fixed(*row.lowest_direct_hz, 1) : "—") +
            number_cell(fixed(row.lowest_hz, 1)) + number_cell(std::to_string(row.n_modes)) +
            number_cell(std::to_string(row.n_proxy_modes)) + number_cell(dash(row.partial_rms_cents)) +
            number_cell(dash(row.log_spectral_distance_db)) + number_cell(dash(row.mel_distance_db)) +
            number_cell(dash(row.third_octave_db)) + number_cell(dash(row.loudness_difference_db)) +
            number_cell(dash(row.direct_s)) + number_cell(row.proxy_s ? rounded(1e3 * *row.proxy_s, 3) : "—") +
            "</tr>\n";
  }
  return table(head("Piece", false) + head("Lowest, mesh [Hz]") + head("Lowest, alone [Hz]") + head("Modes") +
                   head("of the proxy") + head("Partials [cents]") + head("Log-spectral [dB]") + head("Mel [dB]") +
                   head("Third octaves [dB]") + head("Loudness [dB(A)]") + head("Direct [s]") + head("Proxy [ms]"),
               body, "Pieces");
}

std::string proxy_stage_table(const ProxyStudyData& data) {
  std::string body;
  const auto add = [&](const char* way, const std::vector<std::pair<std::string, double>>& stages) {
    const double all = seconds(stages);
    for (const auto& [name, time] : stages)
      body += "<tr>" + tag("td", way) + tag("td", escaped(name)) + number_cell(rounded(1e3 * time, 3)) +
              number_cell(all > 0 ? fixed(100 * time / all, 1) : "—") + "</tr>\n";
  };
  add("direct", data.direct_stages);
  add("proxy", data.proxy_stages);
  return table(head("Way", false) + head("Stage", false) + head("Processor time, all pieces [ms]") + head("Share [%]"),
               body, "Stages");
}

std::string proxy_study_key_figures(const ProxyStudyData& data) {
  std::string html;
  const auto key = [&](const std::string& name, const std::string& value, const std::string& note) {
    html += "<div><dt>" + name + "</dt><dd>" + value + (note.empty() ? "" : tag("small", note)) + "</dd></div>";
  };
  key("Pieces", std::to_string(data.pieces.size()), "");
  if (data.speedup)
    key("Proxies are cheaper by", rounded(*data.speedup, 3) + "×", "single-frequency calculation included");
  if (data.speedup_without_lowest) key("Without that calculation", rounded(*data.speedup_without_lowest, 3) + "×", "");
  if (!data.thresholds.empty()) {
    const ProxyThresholdRow& all = data.thresholds.front();
    if (all.log_spectral_distance_db)
      key("All by proxies", fixed(*all.log_spectral_distance_db, 1) + "\u202fdB", "log-spectral distance of the mix");
    if (all.loudness_difference_db)
      key("Their loudness", fixed(*all.loudness_difference_db, 1) + "\u202fdB(A)", "proxies minus direct");
  }
  return "<dl class=\"keys\">" + html + "</dl>\n";
}

std::vector<std::string> proxy_study_sentences(const ProxyStudyData& data) {
  std::vector<std::string> sentences;
  if (data.speedup && data.speedup_without_lowest)
    sentences.push_back(
        "Sounding <b>" + counted(data.pieces.size(), "piece", "pieces") + "</b> by ellipsoids took <b>" +
        rounded(*data.speedup, 3) + " times</b> less processor time than the direct way in this run, " +
        rounded(*data.speedup_without_lowest, 3) +
        " times without the calculation of each piece’s lowest frequency. Times do not come out the same again.");
  const auto n_clamped = static_cast<std::size_t>(
      std::count_if(data.pieces.begin(), data.pieces.end(), [](const ProxyPieceRow& p) { return p.clamped; }));
  const auto n_short = static_cast<std::size_t>(
      std::count_if(data.pieces.begin(), data.pieces.end(), [](const ProxyPieceRow& p) { return p.bank_too_short; }));
  if (n_clamped > 0)
    sentences.push_back(capitalised(counted(n_clamped, "piece is", "pieces are")) +
                        " thinner than the bank’s thinnest shape and took that.");
  if (n_short > 0)
    sentences.push_back(capitalised(counted(n_short, "piece", "pieces")) +
                        " took a cell whose modes all lie in the band: higher ones are missing.");
  return sentences;
}

}  // namespace klang::reports::detail
