// The page of klang scene run with a liquid.
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"
#include "core/sound/liquid_scene/run_document.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"
#include "reports/pages/sound_media.hpp"
#include "reports/scenes/liquid_pictures.hpp"

namespace klang::reports::detail {
namespace {

using entrainment::BubblePath;
using liquid_scene::RunDocument;
using liquid_scene::StageRecord;

constexpr std::size_t kCurvePoints = 1200, kPictures = 8, kMostRidges = 400, kMostRows = 20, kMostCurves = 6;
constexpr double kHeight = 320, kRidge_s = 0.04;

using Columns = std::map<std::string, std::vector<double>>;

/// Columns of a table beside the result by name, NaN where a cell is empty; none where there is no such table.
Columns columns_of(const std::string& name, ReportFolder& folder) {
  Columns columns;
  if (!folder.has(name)) return columns;
  CsvFile file(folder.path() / name);
  if (!file.next()) return columns;
  std::vector<std::string> names;
  for (const std::string_view cell : file.cells()) names.emplace_back(cell);
  while (file.next()) {
    if (file.cells().size() != names.size()) return {};
    for (std::size_t c = 0; c < names.size(); ++c)
      columns[names[c]].push_back(csv_number(file.cells()[c]).value_or(std::nan("")));
  }
  return columns;
}

std::vector<PlotPoint> points_of(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<PlotPoint> points;
  const std::size_t stride = std::max<std::size_t>(1, x.size() / kCurvePoints);
  for (std::size_t i = 0; i < x.size(); i += stride) points.push_back({x[i], y[i]});
  if (!x.empty()) points.push_back({x.back(), y.back()});
  return points;
}

using NamedCurve = std::pair<std::string, std::vector<PlotPoint>>;

std::optional<Svg> curves_figure(const std::string& words, const std::string& y_label, Scale scale,
                                 const std::vector<NamedCurve>& curves, bool from_zero) {
  std::vector<double> all;
  double last = 0.0;
  std::vector<std::string> names;
  for (const auto& [name, points] : curves) {
    names.push_back(name);
    for (const PlotPoint& p : points) {
      all.push_back(p.y);
      last = std::max(last, p.x);
    }
  }
  if (all.size() < 2 || !(last > 0.0)) return {};
  Svg svg(kPageWidth, kHeight, words);
  AxisSpec y = axis_around(y_label, scale, all);
  if (from_zero) y.low = 0.0;
  Frame frame = axes_under_legend(svg, kHeight, names, {"Time [s]", Scale::kLinear, 0.0, last}, y);
  for (std::size_t i = 0; i < curves.size(); ++i) frame.curve(curves[i].second, series_class("s", i) + " mid");
  return svg;
}

/// What is there against what should be.
std::optional<Svg> volume_figure(const RunDocument& data, ReportFolder& folder) {
  const Columns flow = columns_of("flow.csv", folder);
  const auto time = flow.find("time_s");
  if (time == flow.end() || time->second.size() < 2) return {};
  std::vector<double> there, drift;
  for (std::size_t i = 0; i < time->second.size(); ++i) {
    const double should = data.volume.start_m3 + flow.at("inflow_m3")[i] - flow.at("outflow_m3")[i];
    there.push_back(1e3 * flow.at("volume_m3")[i]);
    drift.push_back(1e3 * should);
  }
  return curves_figure(
      "Volume of the liquid over time beside start plus inflow less outflow.", "Volume [l]", Scale::kLinear,
      {{"liquid", points_of(time->second, there)}, {"start + inflow − outflow", points_of(time->second, drift)}},
      false);
}

std::optional<Svg> energy_figure(ReportFolder& folder) {
  const Columns energy = columns_of("energy.csv", folder);
  const auto time = energy.find("time_s");
  if (time == energy.end() || time->second.size() < 2) return {};
  std::vector<double> potential = energy.at("potential_j");
  const double lowest = *std::min_element(potential.begin(), potential.end());
  for (double& value : potential) value -= lowest;
  std::vector<NamedCurve> curves;
  if (std::isfinite(energy.at("kinetic_j").front()))  // frames of other programs may not say how the liquid moves
    curves.emplace_back("kinetic", points_of(time->second, energy.at("kinetic_j")));
  curves.emplace_back("potential", points_of(time->second, potential));
  return curves_figure("Energy of the liquid over time.", "Energy [J]", Scale::kLinear, curves, true);
}

std::optional<Svg> radii_figure(ReportFolder& folder) {
  const Columns radii = columns_of("radii.csv", folder);
  const auto low = radii.find("low_m");
  if (low == radii.end() || low->second.empty()) return {};
  std::vector<double> places, shares = {0.0};
  for (std::size_t i = 0; i < low->second.size(); ++i)
    places.push_back(1e3 * std::sqrt(low->second[i] * radii.at("high_m")[i]));
  std::vector<NamedCurve> curves;
  for (const char* name : {"asked", "made", "recorded"}) {
    std::vector<PlotPoint> points;
    double sum = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double share = 100.0 * radii.at(name)[i];
      if (!std::isfinite(share)) continue;
      points.push_back({places[i], share});
      shares.push_back(share);
      sum += share;
    }
    if (sum > 0.0) curves.emplace_back(name, std::move(points));
  }
  if (curves.empty()) return {};
  Svg svg(kPageWidth, kHeight, "Share of bubbles by radius: asked, made, recorded.");
  std::vector<std::string> names;
  for (const auto& [name, points] : curves) names.push_back(name);
  AxisSpec y = axis_around("Share per third of an octave [%]", Scale::kLinear, shares);
  y.low = 0.0;
  Frame frame = axes_under_legend(svg, kHeight, names, axis_around("Radius [mm]", Scale::kLog, places), y);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    frame.curve(curves[i].second, series_class("s", i) + " mid");
    for (const PlotPoint& p : curves[i].second)
      svg.marker(static_cast<int>(i), frame.x(p.x), frame.y(p.y), 3,
                 rounded(p.x, 3) + " mm: " + rounded(p.y, 3) + " %");
  }
  return svg;
}

/// Births per second over time.
std::optional<Svg> births_figure(const std::vector<BubblePath>& paths, double end_s) {
  if (paths.empty() || !(end_s > 0.0)) return {};
  const int n = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(paths.size()))) * 4, 10, 100);
  std::vector<double> counts(static_cast<std::size_t>(n), 0.0);
  for (const BubblePath& path : paths)
    counts[static_cast<std::size_t>(std::clamp(static_cast<int>(path.birth_s() / end_s * n), 0, n - 1))] += n / end_s;
  std::vector<PlotPoint> steps;
  for (int i = 0; i < n; ++i) {
    steps.push_back({end_s * i / n, counts[static_cast<std::size_t>(i)]});
    steps.push_back({end_s * (i + 1) / n, counts[static_cast<std::size_t>(i)]});
  }
  return curves_figure("Births of bubbles per second over time.", "Births per second", Scale::kLinear,
                       {{"births", steps}}, true);
}

/// |P| of the longest-lived bubbles; where the pitch is near a mode of the tank a hollow mark stands.
std::optional<Svg> transfer_figure(const RunDocument& data, ReportFolder& folder) {
  const Columns rows = columns_of("transfer.csv", folder);
  const auto ids = rows.find("bubble");
  if (ids == rows.end()) return {};
  struct Curve {
    std::vector<PlotPoint> points;
    std::vector<bool> at_mode;
  };
  std::map<int, Curve> of_bubble;
  for (std::size_t i = 0; i < ids->second.size(); ++i) {
    Curve& curve = of_bubble[static_cast<int>(ids->second[i])];
    const double time = rows.at("time_s")[i], modulus = std::hypot(rows.at("re")[i], rows.at("im")[i]);
    if (!curve.points.empty() && curve.points.back().x == time) continue;  // the lower of two bins
    curve.points.push_back({time, modulus});
    curve.at_mode.push_back(
        data.transfer && std::any_of(data.transfer->tank_modes_hz.begin(), data.transfer->tank_modes_hz.end(),
                                     [&](double f) { return std::abs(rows.at("frequency_hz")[i] / f - 1.0) < 0.06; }));
  }
  std::vector<std::pair<int, Curve>> longest(of_bubble.begin(), of_bubble.end());
  std::stable_sort(longest.begin(), longest.end(),
                   [](const auto& a, const auto& b) { return a.second.points.size() > b.second.points.size(); });
  longest.resize(std::min(longest.size(), kMostCurves));
  std::vector<double> all, times;
  std::vector<std::string> names;
  for (const auto& [id, curve] : longest) {
    names.push_back("bubble " + std::to_string(id));
    for (const PlotPoint& p : curve.points) {
      all.push_back(p.y);
      times.push_back(p.x);
    }
  }
  if (all.size() < 2) return {};
  Svg svg(kPageWidth, kHeight, "Modulus of the transfer of the longest-lived bubbles over time.");
  Frame frame = axes_under_legend(svg, kHeight, names, axis_around("Time [s]", Scale::kLinear, times),
                                  axis_around("|P| [Pa per m of the bubble's wall]", Scale::kLog, all));
  for (std::size_t c = 0; c < longest.size(); ++c) {
    const Curve& curve = longest[c].second;
    frame.curve(curve.points, series_class("s", c) + " mid");
    for (std::size_t i = 0; i < curve.points.size(); ++i)
      if (curve.at_mode[i] && frame.shows(curve.points[i].x, curve.points[i].y))
        svg.marker(static_cast<int>(c), frame.x(curve.points[i].x), frame.y(curve.points[i].y), 4,
                   "near a mode of the tank", true);
  }
  return svg;
}

/// From the first frame to the last, half of them spread over time and half over the bubbles' lives.
std::vector<std::size_t> shown_frames(const liquid_scene::LiquidScene& scene, const std::vector<BubblePath>& paths,
                                      std::size_t n_frames) {
  std::vector<double> alive(n_frames, 0.0);
  double all = 0.0;
  for (std::size_t f = 0; f < n_frames; ++f)
    for (const BubblePath& path : paths)
      if (path.birth_s() <= scene.frame_s(f) && path.end_s() >= scene.frame_s(f)) {
        alive[f] += 1.0;
        all += 1.0;
      }
  std::vector<std::size_t> shown{0};
  double sum = 0.0;  // of shares of frames up to here
  for (std::size_t f = 1; f < n_frames; ++f) {
    const double even = 1.0 / static_cast<double>(n_frames - 1);
    sum += all > 0.0 ? 0.5 * even + 0.5 * alive[f] / all : even;
    const double wanted = static_cast<double>(shown.size()) / static_cast<double>(kPictures - 1);
    if (shown.size() < kPictures && (sum >= wanted - 1e-9 || n_frames - f <= kPictures - shown.size()))
      shown.push_back(f);
  }
  if (shown.back() + 1 < n_frames) shown.back() = n_frames - 1;
  return shown;
}

/// Eight frames with the bubbles that are there, to scale.
std::string filmstrip(const RunDocument& data, const std::vector<BubblePath>& paths, ReportFolder& folder) {
  if (!folder.options().pictures || data.n_frames < 1 || !folder.has("scene.toml")) return {};
  const liquid_scene::LiquidScene scene = liquid_scene::read_liquid_scene(folder.path() / "scene.toml");
  const liquid_scene::RunFolder run(folder.path());
  const Eigen::Vector3d size = scene.setup.shape.size_m();
  double low = HUGE_VAL, high = 0.0;
  for (const BubblePath& path : paths)
    for (const double f : path.frequency_hz) {
      low = std::min(low, f);
      high = std::max(high, f);
    }
  std::vector<LiquidPictureRequest> requests;
  std::vector<double> times;
  for (const std::size_t frame : shown_frames(scene, paths, static_cast<std::size_t>(data.n_frames))) {
    LiquidPictureRequest request{run.frame_file(frame), {size.x(), size.y(), size.z()}, {}};
    const double time = scene.frame_s(frame);
    for (const BubblePath& path : paths) {
      if (path.birth_s() > time || path.end_s() < time) continue;
      const auto at = std::min(static_cast<std::size_t>(std::lower_bound(path.time_s.begin(), path.time_s.end(), time) -
                                                        path.time_s.begin()),
                               path.time_s.size() - 1);
      const Eigen::Vector3d x = path.position_m[at];
      const double pitch = at < path.frequency_hz.size() ? path.frequency_hz[at] : low;
      request.bubbles.push_back(
          {{x.x(), x.y(), x.z()}, path.radius_m, high > low ? std::log(pitch / low) / std::log(high / low) : 0.5});
    }
    requests.push_back(std::move(request));
    times.push_back(time);
  }
  DrawnPictures drawn = render_liquid(requests, folder.monitor());
  if (!drawn.warning.empty()) folder.warn(drawn.warning);
  std::string html;
  for (std::size_t p = 0; p < drawn.pictures.size(); ++p) {
    const DrawnPicture& picture = drawn.pictures[p];
    if (picture.png.empty()) continue;
    folder.add_file("figures/frame-" + std::to_string(p) + ".png", picture.png);
    html += "<figure><img alt=\"The liquid at " + rounded(times[p], 3) + " s\" width=\"" +
            std::to_string(picture.width / 2) + "\" height=\"" + std::to_string(picture.height / 2) + "\" src=\"" +
            data_uri("image/png", picture.png) + "\"><figcaption><b>" + rounded(times[p], 3) + " s</b> " +
            std::to_string(requests[p].bubbles.size()) + (requests[p].bubbles.size() == 1 ? " bubble" : " bubbles") +
            "</figcaption></figure>\n";
  }
  if (html.empty()) return {};
  return "<div class=\"shapes\">" + html +
         "</div><p class=\"how\"><small>Free surface clear, solids opaque, walls as lines; bubbles to scale (at least "
         "a dot), the brighter the higher. Half of the frames are spread over time, half over the bubbles' "
         "lives.</small></p>\n";
}

std::string sound_html(const RunDocument& data, const std::vector<BubblePath>& paths, ReportFolder& folder) {
  if (!data.sound) return {};
  SoundPair pair;
  pair.name = data.name;
  pair.recorded_words = "At the listener";
  pair.recorded = folder.sound_beside(data.sound->file);
  std::vector<const BubblePath*> largest;
  for (const BubblePath& path : paths)
    if (!path.frequency_hz.empty()) {
      largest.push_back(&path);
      pair.highest_hz = std::max(pair.highest_hz, path.frequency_hz.front());
    }
  std::stable_sort(largest.begin(), largest.end(),
                   [](const auto* a, const auto* b) { return a->radius_m > b->radius_m; });
  largest.resize(std::min(largest.size(), kMostRidges));
  for (const BubblePath* path : largest) {
    pair.ridges.lines.emplace_back();
    for (std::size_t i = 0; i < path->time_s.size() && path->time_s[i] <= path->birth_s() + kRidge_s; ++i) {
      pair.ridges.lines.back().push_back({path->time_s[i], path->frequency_hz[i]});
      pair.highest_hz = std::max(pair.highest_hz, path->frequency_hz[i]);
      pair.lowest_hz = std::min(pair.lowest_hz.value_or(HUGE_VAL), path->frequency_hz[i]);
    }
  }
  pair.ridges.narrow = true;
  const SoundMedia media = sound_media(pair, 1, folder);
  std::string html = players(media, pair);
  const int n_channels = data.sound->n_channels;
  if (media.spectrogram && data.sound->peak_pressure_pa > 0.0)
    html += figure(sheet(*media.spectrogram),
                   std::string("Spectrogram of ") + (n_channels > 1 ? "the louder ear" : "sound.wav") +
                       ". Lines begin at births and follow a bubble's pitch for " + rounded(1e3 * kRidge_s, 2) +
                       " ms (the " + std::to_string(largest.size()) + " largest of " + std::to_string(paths.size()) +
                       ")." + (n_channels > 1 ? " sound.wav has both ears." : ""));
  return html;
}

std::string bubble_table(ReportFolder& folder) {
  const Columns rows = columns_of("bubbles.csv", folder);
  const auto radius = rows.find("radius_m");
  if (radius == rows.end() || radius->second.empty()) return {};
  std::vector<std::size_t> order(radius->second.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return radius->second[a] > radius->second[b]; });
  order.resize(std::min(order.size(), kMostRows));
  std::string body;
  for (const std::size_t i : order)
    body += "<tr>" + tag("th", std::to_string(static_cast<long long>(rows.at("id")[i])), "scope=\"row\"") +
            number_cell(rounded(1e3 * radius->second[i], 3), 1e3 * radius->second[i]) +
            number_cell(rounded(rows.at("birth_s")[i], 4), rows.at("birth_s")[i]) +
            number_cell(rounded(1e3 * (rows.at("end_s")[i] - rows.at("birth_s")[i]), 3),
                        1e3 * (rows.at("end_s")[i] - rows.at("birth_s")[i])) +
            number_cell(rounded(1e3 * rows.at("depth_m")[i], 3), 1e3 * rows.at("depth_m")[i]) +
            number_cell(rounded(rows.at("frequency_start_hz")[i], 4), rows.at("frequency_start_hz")[i]) +
            number_cell(rounded(rows.at("frequency_end_hz")[i], 4), rows.at("frequency_end_hz")[i]) + "</tr>\n";
  const auto head = [](const char* words) { return tag("th", words, "scope=\"col\" class=\"n\""); };
  return scrolled("<table><thead><tr><th scope=\"col\">Bubble</th>" + head("Radius [mm]") + head("Birth [s]") +
                      head("Life [ms]") + head("Depth [mm]") + head("Pitch at birth [Hz]") + head("at its end [Hz]") +
                      "</tr></thead>\n<tbody>" + body + "</tbody></table>",
                  "The largest bubbles");
}

std::string stage_table(const RunDocument& data) {
  std::string body;
  const auto row = [&](const char* name, const std::optional<StageRecord>& stage) {
    if (stage)
      body += "<tr>" + tag("th", name, "scope=\"row\"") + tag("td", to_text(stage->status)) +
              number_cell(std::to_string(stage->n_steps)) +
              number_cell(rounded(stage->wall_time_s, 3), stage->wall_time_s) +
              number_cell(rounded(stage->cpu_time_s, 3), stage->cpu_time_s) + "</tr>\n";
  };
  row("flow", data.stages.flow);
  row("bubbles", data.stages.bubbles);
  row("transfer", data.stages.transfer);
  row("sound", data.stages.sound);
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Stage</th><th scope=\"col\"></th><th scope=\"col\" "
      "class=\"n\">Steps</th><th scope=\"col\" class=\"n\">Wall "
      "time [s]</th><th scope=\"col\" class=\"n\">Processor time [s]</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Stages");
}

std::string error_words(const liquid_scene::TransferRecord& transfer) {
  if (!transfer.error_estimate) return ", without an estimate of its error.";
  const auto percent = [](double share) { return rounded(100.0 * share, 2); };
  if (!transfer.error_interval)
    return "; how far it is off is not determined: " + std::to_string(transfer.n_checked) + " solves were checked.";
  return ", off by an estimated " + percent(*transfer.error_estimate) + " % (median of " +
         std::to_string(transfer.n_checked) + " solves, between " + percent((*transfer.error_interval)[0]) + " and " +
         percent((*transfer.error_interval)[1]) + " %).";
}

std::vector<std::string> sentences_of(const RunDocument& data) {
  std::vector<std::string> sentences;
  if (data.n_frames == 0)
    sentences.push_back(rounded(data.end_s, 4) + " s of bubbles that another program tracked.");
  else
    sentences.push_back(
        rounded(data.end_s, 4) + " s of a liquid of " + rounded(1e3 * data.volume.start_m3, 3) + " l in " +
        std::to_string(data.n_cells) + " cells; " +
        (data.imported ? "its frames are another program's (" + escaped(data.imported->kind) + ")."
                       : "its volume is off by " + rounded(100.0 * data.volume.max_drift_relative, 2) + " % at most."));
  sentences.push_back(
      data.n_bubbles == 0
          ? std::string("No bubble was born: it is silent.")
          : "<b>" + std::to_string(data.n_bubbles) + " bubbles</b> were born, " + rounded(data.births_per_s, 3) +
                " per second" +
                (data.entrainment
                     ? "; the number of those that were entrained follows the rate of attempts that the scene gives."
                     : "; the scene or its file says where."));
  if (data.transfer)
    sentences.push_back("Transfer by the method " + escaped(data.transfer->method) + error_words(*data.transfer));
  if (data.transfer && data.transfer->n_airs > 0)
    sentences.push_back("The air was solved " +
                        (data.transfer->n_airs == 1 ? "once" : std::to_string(data.transfer->n_airs) + " times") +
                        ", around the liquid's body and the solids as they stood then; walls that rise above the "
                        "liquid are not in it.");
  return sentences;
}

std::string key_figures(const RunDocument& data) {
  KeyFigures keys;
  if (data.n_frames > 0) keys.add("Liquid", rounded(1e3 * data.volume.end_m3, 3) + "\u202fl", "at the end");
  keys.add("Bubbles", std::to_string(data.n_bubbles), rounded(data.births_per_s, 3) + " per second");
  if (!data.imported && data.n_frames > 0)
    keys.add("Volume kept to", rounded(100.0 * data.volume.max_drift_relative, 2) + "\u202f%", "largest drift");
  if (data.transfer && data.transfer->error_estimate)
    keys.add("Transfer off by",
             data.transfer->error_interval ? rounded(100.0 * *data.transfer->error_estimate, 2) + "\u202f%" : "–",
             data.transfer->error_interval ? "estimate, median of " + std::to_string(data.transfer->n_checked)
                                           : "not determined");
  if (data.sound)
    keys.add("Peak at the ear", rounded(data.sound->peak_pressure_pa, 3) + "\u202fPa",
             data.sound->peak_pressure_pa > 0.0
                 ? fixed(20.0 * std::log10(data.sound->peak_pressure_pa / kReferencePressurePa), 1) + " dB re 20 µPa"
                 : "");
  return keys.html();
}

Page make(const RunDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · liquids that sound";
  page.title = data.name.empty() ? "Liquid" : data.name;
  const bool doubtful = data.transfer && data.transfer->error_estimate &&
                        (!data.transfer->error_interval || !(*data.transfer->error_estimate <= 0.2));
  page.verdict = doubtful ? Verdict{"Transfer doubtful", "fair", ""} : Verdict{"Done", "good", ""};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  std::vector<BubblePath> paths;
  if (data.n_bubbles > 0 && folder.has("bubbles.trk"))
    paths = entrainment::read_tracked_bubbles(folder.path() / "bubbles.trk").paths;
  const auto shown = [&](const char* stem, const std::optional<Svg>& svg, const std::string& caption) {
    if (!svg) return std::string();
    folder.add_figure(stem, *svg);
    return figure(sheet(*svg), caption);
  };
  const std::string flow = shown("volume", volume_figure(data, folder),
                                 "Volume of the liquid, and what it should be by what came in and went out.") +
                           shown("energy", energy_figure(folder),
                                 "Energy of the liquid at its frames; the potential energy counts from its lowest "
                                 "value. Solids in it are left out of account.");
  const std::string bubbles =
      shown("births", births_figure(paths, data.end_s), "Births per second.") +
      shown(
          "radii", radii_figure(folder),
          "Radii: as the scene asks, as made (rejection takes some), and of the recording where they come from one.") +
      bubble_table(folder);
  const std::string transfer =
      shown("transfer", transfer_figure(data, folder),
            "Modulus of the transfer of the longest-lived bubbles at the solved frequency below their pitch; hollow: "
            "within 6 % of a mode of the tank, where its level is what the loss factor makes it.");
  page.sections = {{"sound", "Sound", sound_html(data, paths, folder)},
                   {"frames", "Frames", filmstrip(data, paths, folder)},
                   {"flow", "Flow", flow},
                   {"bubbles", "Bubbles", bubbles},
                   {"transfer", "Transfer", transfer},
                   {"stages", "Stages", stage_table(data)}};
  add_if_there(data.sound ? std::optional<std::string>(data.sound->file) : std::nullopt, "– sound at the listener",
               folder, page.downloads);
  for (const auto& [file, what] :
       {std::pair("bubbles.csv", "– every bubble"), std::pair("flow.csv", "– volume, a row per step"),
        std::pair("solids.csv", "– where moving solids were"), std::pair("frames.pvd", "– surfaces, for ParaView")})
    if (folder.has(file)) page.downloads.push_back({file, what});
  page.downloads.push_back(kFiguresDownload);
  page.footer =
      "How many bubbles there are is set by the rate of attempts; levels near the tank's modes by its loss factor.";
  return page;
}

}  // namespace

PageKind liquid_scene_page() { return page_kind<RunDocument>("liquid_scene", make); }

}  // namespace klang::reports::detail
