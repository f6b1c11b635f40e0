// The page of klang proxy fit.
#include <algorithm>
#include <array>
#include <cmath>

#include "fit/proxy/proxy_fit_document.hpp"
#include "reports/kit/audio_clip.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/sound_media.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kWidth = 1080, kLeft = 66, kRight = 24;

double cents(double a, double b) { return 1200.0 * std::log2(a / b); }

using fit::ProxyFitDocument;
constexpr double kLongestClipS = 10.0;

/// A measure of both proxies; how many that were tried were worse in it than the first one.
struct Measure {
  const char *words, *unit;
  double before, after;
  std::optional<int> n_worse;
};
std::vector<Measure> measures_of(const ProxyFitDocument& data) {
  const fit::ProxyErrors &b = data.before, &a = data.after;
  const fit::WorseRecord& w = data.n_worse;
  return {{"Partials, rms", "cents", b.partial_rms_cents, a.partial_rms_cents, {}},
          {"Log-spectral distance", "dB", b.log_spectral_distance_db, a.log_spectral_distance_db,
           w.log_spectral_distance_db},
          {"Distance in mel bands", "dB", b.mel_distance_db, a.mel_distance_db, w.mel_distance_db},
          {"Third-octave levels, rms", "dB", b.third_octave_db, a.third_octave_db, w.third_octave_db},
          {"A-weighted energy", "dB", b.loudness_difference_db, a.loudness_difference_db, w.loudness_difference_db},
          {"Decays, rms", "%", b.decay_rms_percent, a.decay_rms_percent, w.decay_rms_percent}};
}

std::array<double, 3> axes_m(const fit::EllipsoidRecord& e) {
  return {e.axes[0] * e.scale_m, e.axes[1] * e.scale_m, e.axes[2] * e.scale_m};
}

/// The body, the first proxy and the fitted one, as they are drawn.
struct Side {
  fit::VoicePartial fit::ProxyPartialRecord::*partial;
  int series;
  const char *stroke, *words;
};
constexpr std::array<Side, 3> kSides{{{&fit::ProxyPartialRecord::target, 0, "s0 thick", "Body"},
                                      {&fit::ProxyPartialRecord::before, 1, "s1 mid dash2", "First proxy"},
                                      {&fit::ProxyPartialRecord::after, 2, "s2 thick", "Fitted proxy"}}};

double level_db(const fit::VoicePartial& line, double loudest) {
  return std::max(20 * std::log10(std::max(line.amplitude, 1e-30) / loudest), -79.0);
}

std::string signed_number(double value, int decimals) { return (value > 0 ? "+" : "") + fixed(value, decimals); }

void draw_lines(Svg& svg, Frame& lines, const ProxyFitDocument& data, double floor, double loudest) {
  double at = lines.left() + 8;
  for (const Side& side : kSides) {
    for (std::size_t k = 0; k < data.partials.size(); ++k) {
      const fit::VoicePartial& line = data.partials[k].*side.partial;
      const double place = lines.x(line.frequency_hz), level = lines.y(level_db(line, loudest));
      svg.line(place, lines.y(floor), place, level, side.stroke);
      svg.marker(side.series, place, level, 3.5,
                 std::string(side.words) + ", partial " + std::to_string(k + 1) + ": " + hertz(line.frequency_hz),
                 k >= static_cast<std::size_t>(data.n_fitted));
    }
    svg.marker(side.series, at, lines.top() - 16, 4, "");
    svg.text(at + 10, lines.top() - 12, side.words, "small");
    at += 100;
  }
  svg.text(kWidth - kRight, lines.top() - 12,
           "hollow: not among the " + std::to_string(data.n_fitted) + " that are fitted", "muted small", Anchor::kEnd);
}

void draw_differences(Svg& svg, Frame& frame, const ProxyFitDocument& data) {
  svg.line(frame.left(), frame.y(0), frame.right(), frame.y(0), "axis");
  for (std::size_t k = 0; k < data.partials.size(); ++k) {
    const fit::ProxyPartialRecord& p = data.partials[k];
    const double place = frame.x(p.target.frequency_hz);
    const double first = cents(p.before.frequency_hz, p.target.frequency_hz),
                 last = cents(p.after.frequency_hz, p.target.frequency_hz);
    svg.line(place, frame.y(first), place, frame.y(last), "rule thin");
    const bool hollow = k >= static_cast<std::size_t>(data.n_fitted);
    svg.marker(1, place, frame.y(first), 4,
               "first proxy, partial " + std::to_string(k + 1) + ": " + signed_cents(first), hollow);
    svg.marker(2, place, frame.y(last), 4, "fitted proxy, partial " + std::to_string(k + 1) + ": " + signed_cents(last),
               hollow);
  }
}

Svg partials_figure(const ProxyFitDocument& data) {
  constexpr double kTop = 34, kLines = 230, kGap = 34, kCents = 190, kHeight = kTop + kLines + kGap + kCents + 48;
  Svg svg(
      kWidth, kHeight,
      "Partials of the body, of the first proxy and of the fitted one over frequency, and their differences in cents.");
  std::vector<double> frequencies;
  double loudest = 0, lowest = -20, largest = 10;
  for (const Side& side : kSides)
    for (const fit::ProxyPartialRecord& p : data.partials) {
      frequencies.push_back((p.*side.partial).frequency_hz);
      loudest = std::max(loudest, (p.*side.partial).amplitude);
    }
  for (const Side& side : kSides)
    for (const fit::ProxyPartialRecord& p : data.partials)
      lowest = std::min(lowest, level_db(p.*side.partial, loudest));
  const double floor = 10 * std::floor((lowest - 5) / 10);
  const AxisSpec x = axis_around("Frequency of the body's partial [Hz]", Scale::kLog, frequencies, 0.05);
  AxisSpec hidden = x;
  hidden.labelled = false;
  Frame lines(svg, {kLeft, kTop, kWidth - kLeft - kRight, kLines}, hidden,
              {"Level at the strike [dB re loudest]", Scale::kLinear, floor, 5});
  lines.draw_axes(10, 6);
  draw_lines(svg, lines, data, floor, loudest);
  for (const fit::ProxyPartialRecord& p : data.partials)
    for (const double hz : {p.before.frequency_hz, p.after.frequency_hz})
      largest = std::max(largest, std::abs(cents(hz, p.target.frequency_hz)));
  Frame frame(svg, {kLeft, kTop + kLines + kGap, kWidth - kLeft - kRight, kCents}, x,
              {"Proxy above body [cents]", Scale::kLinear, -1.12 * largest, 1.12 * largest});
  frame.draw_axes(10, 5);
  draw_differences(svg, frame, data);
  return svg;
}

Svg shape_figure(const ProxyFitDocument& data) {
  constexpr double kHeight = 300, kTop = 40, kBottom = 34, kPane = (kWidth - 80) / 3;
  Svg svg(kWidth, kHeight, "Sections of the first and of the fitted ellipsoid, each through two axes.");
  const double longest = std::max(axes_m(data.start)[2], axes_m(data.fitted)[2]);
  const double pixels_per_m = std::min(kPane - 40, kHeight - kTop - kBottom) / (2 * longest);
  const char* names[] = {"a", "b", "c"};
  const std::array<std::array<std::size_t, 2>, 3> planes{{{2, 0}, {2, 1}, {1, 0}}};
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = 40 + (static_cast<double>(i) + 0.5) * kPane, y = kTop + 0.5 * (kHeight - kTop - kBottom);
    for (const bool fitted : {false, true}) {
      const std::array<double, 3> axes = axes_m(fitted ? data.fitted : data.start);
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

std::string measure_table(const ProxyFitDocument& data) {
  std::string body;
  for (const Measure& m : measures_of(data)) {
    const double change = m.before > 0 ? 100 * (m.after / m.before - 1) : 0;
    body += "<tr>" + tag("th", escaped(m.words), "scope=\"row\"") + number_cell(rounded(m.before, 4) + " " + m.unit) +
            number_cell(rounded(m.after, 4) + " " + m.unit) +
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

std::string parameter_table(const ProxyFitDocument& data) {
  std::string body;
  const auto row = [&](const std::string& words, double before, double after) {
    body += "<tr>" + tag("th", words, "scope=\"row\"") + number_cell(rounded(before, 4), before) +
            number_cell(rounded(after, 4), after) + "</tr>\n";
  };
  const char* names[] = {"Semi-axis a [mm]", "Semi-axis b [mm]", "Semi-axis c [mm]"};
  for (std::size_t i = 0; i < 3; ++i) row(names[i], 1000 * axes_m(data.start)[i], 1000 * axes_m(data.fitted)[i]);
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

std::string partial_table(const ProxyFitDocument& data) {
  std::string body;
  for (std::size_t k = 0; k < data.partials.size(); ++k) {
    const auto& [t, b, a] = data.partials[k];
    body +=
        "<tr" + std::string(k < static_cast<std::size_t>(data.n_fitted) ? "" : " class=\"open\"") + ">" +
        number_cell(std::to_string(k + 1)) + number_cell(fixed(t.frequency_hz, 1), t.frequency_hz) +
        number_cell(signed_number(cents(b.frequency_hz, t.frequency_hz), 1), cents(b.frequency_hz, t.frequency_hz)) +
        number_cell(signed_number(cents(a.frequency_hz, t.frequency_hz), 1), cents(a.frequency_hz, t.frequency_hz)) +
        number_cell(rounded(t.decay_per_s, 3), t.decay_per_s) + number_cell(rounded(b.decay_per_s, 3), b.decay_per_s) +
        number_cell(rounded(a.decay_per_s, 3), a.decay_per_s) + "</tr>\n";
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

std::string key_figures(const ProxyFitDocument& data) {
  KeyFigures keys;
  keys.add("Partials off by", rounded(data.after.partial_rms_cents, 3) + " cents",
           "first proxy " + rounded(data.before.partial_rms_cents, 3));
  keys.add("Log-spectral distance", fixed(data.after.log_spectral_distance_db, 2) + "\u202fdB",
           "first proxy " + fixed(data.before.log_spectral_distance_db, 2));
  const std::array<double, 3> axes = axes_m(data.fitted);
  keys.add(
      "Semi-axes",
      rounded(1000 * axes[0], 3) + " × " + rounded(1000 * axes[1], 3) + " × " + rounded(1000 * axes[2], 3) + "\u202fmm",
      "fitted ellipsoid");
  if (data.n_candidates && data.n_refused)
    keys.add("Proxies heard", std::to_string(*data.n_candidates),
             std::to_string(*data.n_refused) + " worse in some measure");
  return keys.html();
}

std::vector<std::string> sentences_of(const ProxyFitDocument& data) {
  std::vector<std::string> sentences;
  if (data.improved) {
    sentences.push_back("The fitted ellipsoid's partials lie <b>" + rounded(data.after.partial_rms_cents, 3) +
                        " cents</b> from the body's (rms of the first " + std::to_string(data.n_fitted) +
                        "), where the first one's lay " + rounded(data.before.partial_rms_cents, 3) +
                        ", and no other measure is worse.");
  } else {
    sentences.push_back(
        "No ellipsoid was found that is nearer in its partials and no worse in every other measure: <b>the first one "
        "is kept</b>.");
  }
  if (data.least_partial_rms_cents && *data.least_partial_rms_cents < 0.95 * data.after.partial_rms_cents) {
    const std::vector<Measure> measures = measures_of(data);
    const Measure* most = nullptr;
    for (const Measure& m : measures)
      if (m.n_worse && (!most || *m.n_worse > *most->n_worse)) most = &m;
    sentences.push_back(
        "Partials alone could come as near as " + rounded(*data.least_partial_rms_cents, 3) + " cents" +
        (most && *most->n_worse > 0 ? "; what speaks against it most often is: " + escaped(most->words) : "") + ".");
  }
  return sentences;
}

std::string figures_html(const ProxyFitDocument& data, ReportFolder& folder) {
  const Svg partials = partials_figure(data), shape = shape_figure(data);
  folder.add_figure("partials", partials);
  folder.add_figure("shape", shape);
  return figure(sheet(partials),
                "Above: the partials, amplitudes at the strike. Below: how far the proxies' partials lie above the "
                "body's, rank by rank.") +
         figure(sheet(shape), "Sections through the ellipsoids, to one scale.");
}

/// Players of the three sounds; lists their files.
std::string sounds_html(ReportFolder& folder, std::vector<Download>& downloads) {
  std::string clips;
  for (const auto& [file, what] :
       {std::pair{"target.wav", "Body"}, {"before.wav", "First proxy"}, {"after.wav", "Fitted proxy"}}) {
    const audio::Signal sound = folder.sound_beside(file);
    if (sound.n_frames() == 0) continue;
    const std::string flac = flac_clip(sound, kLongestClipS, clip_gain(sound, kLongestClipS));
    clips += std::string("<label>") + what + "<audio controls preload=\"auto\" aria-label=\"" + what + "\" src=\"" +
             data_uri("audio/flac", flac) + "\"></audio></label>";
    downloads.push_back({file, "– sound"});
  }
  if (clips.empty()) return {};
  return "<div class=\"listen\">" + clips + listen_actions() +
         "</div>\n<p class=\"how\"><small>Each at its own level.</small></p>\n";
}

Page make(const ProxyFitDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · a body replaced by an ellipsoid";
  page.title = "Ellipsoid for a body";
  page.verdict = {data.improved ? "Improved" : "Start kept", data.improved ? "good" : "fair",
                  data.header.message.value_or("")};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  const std::string figures = figures_html(data, folder), sounds = sounds_html(folder, page.downloads);
  page.sections = {{"measures", "Measures", measure_table(data)},
                   {"sounds", "Sounds", sounds},
                   {"partials", "Partials and shape", figures},
                   {"parameters", "Parameters", parameter_table(data)},
                   {"table", "Partial by partial", partial_table(data)}};
  page.downloads.push_back(kFiguresDownload);
  return page;
}

}  // namespace

PageKind proxy_fit_page() { return page_kind<ProxyFitDocument>("proxy_fit", make); }

}  // namespace klang::reports::detail
