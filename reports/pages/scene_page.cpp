// The page of klang scene run.
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/sound/scene/scene_document.hpp"
#include "core/sound/scene/scene_frames.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/key_figures.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/pages/plot_parts.hpp"
#include "reports/pages/sound_media.hpp"
#include "reports/scenes/frame_scene.hpp"

namespace klang::reports::detail {
namespace {

using scene::BodyRecord;
using scene::SceneDocument;

constexpr std::size_t kLedgerPoints = 1200, kMostBodyRows = 200;

/// Columns of ledger.csv by name; empty where it cannot be read.
std::map<std::string, std::vector<double>> ledger_of(const SceneDocument& data, ReportFolder& folder) {
  const std::filesystem::path path = folder.beside(data.files.ledger);
  std::map<std::string, std::vector<double>> columns;
  if (path.empty()) return columns;
  CsvFile file(path);
  if (!file.next()) return columns;
  std::vector<std::string> names;
  for (const std::string_view cell : file.cells()) names.emplace_back(cell);
  while (file.next()) {
    if (file.cells().size() != names.size()) return {};
    for (std::size_t c = 0; c < names.size(); ++c)
      columns[names[c]].push_back(std::strtod(std::string(file.cells()[c]).c_str(), nullptr));
  }
  return columns;
}

struct EnergyCurve {
  const char* column;
  const char* words;
};
constexpr EnergyCurve kEnergies[] = {
    {"kinetic_j", "kinetic"},          {"potential_j", "potential"}, {"strain_j", "strain"},
    {"work_j", "work put in"},         {"viscous_j", "viscosity"},   {"plastic_j", "plastic flow"},
    {"contact_j", "lost in contacts"}, {"friction_j", "friction"},   {"fracture_j", "fracture"},
    {"vibration_j", "vibration"}};
constexpr double kMatters = 1e-6;  ///< of the largest of all: less is no curve and no part of the sentence

/// Energies over time; the potential energy counts from its lowest value, work from what bodies brought.
std::optional<Svg> energy_figure(const SceneDocument& data, ReportFolder& folder) {
  const auto columns = ledger_of(data, folder);
  const auto time = columns.find("time_s");
  if (time == columns.end() || time->second.size() < 2) return {};
  const std::vector<double>& t = time->second;
  const std::size_t stride = std::max<std::size_t>(1, t.size() / kLedgerPoints);
  std::vector<std::pair<std::string, std::vector<PlotPoint>>> curves;
  std::vector<double> all = {0.0};
  double widest = 0.0;
  const auto span_of = [&](const char* column) {
    const auto values = columns.find(column);
    if (values == columns.end() || values->second.size() != t.size()) return std::pair(0.0, 0.0);
    const auto [low, high] = std::minmax_element(values->second.begin(), values->second.end());
    return std::pair(*low, *high);
  };
  for (const EnergyCurve& curve : kEnergies)
    widest = std::max(widest, span_of(curve.column).second - span_of(curve.column).first);
  for (const auto& [column, words] : kEnergies) {
    const auto [low, high] = span_of(column);
    if (!(high - low > kMatters * widest)) continue;
    const std::vector<double>& values = columns.at(column);
    const std::string_view name = column;
    const double base = name == "potential_j" ? low : name == "work_j" ? values.front() : 0.0;
    std::vector<PlotPoint> points;
    for (std::size_t i = 0; i < t.size(); i += stride) points.push_back({t[i], values[i] - base});
    points.push_back({t.back(), values.back() - base});
    all.push_back(high - base);
    all.push_back(low - base);
    curves.emplace_back(words, std::move(points));
  }
  if (curves.empty()) return {};
  constexpr double kHeight = 340;
  Svg svg(kPageWidth, kHeight, "Energies of the scene over time.");
  std::vector<std::string> names;
  for (const auto& [words, points] : curves) names.push_back(words);
  AxisSpec y = axis_around("Energy [J]", Scale::kLinear, all);
  // A little below 0 is round-off; what holds take back is not.
  if (*std::min_element(all.begin(), all.end()) > -1e-3 * widest) y.low = 0.0;
  Frame frame = axes_under_legend(svg, kHeight, names, {"Time [s]", Scale::kLinear, t.front(), t.back()}, y);
  for (std::size_t i = 0; i < curves.size(); ++i) frame.curve(curves[i].second, series_class("s", i) + " mid");
  return svg;
}

/// Impacts: their impulse over time, a colour per body.
std::optional<Svg> impact_figure(const SceneDocument& data) {
  const auto& impacts = data.impulses_summary.hardest;
  if (impacts.empty()) return {};
  std::vector<double> sizes;
  for (const scene::ImpactRecord& impact : impacts) sizes.push_back(impact.impulse_n_s);
  constexpr double kHeight = 340;
  Svg svg(kPageWidth, kHeight, "Impulse of each impact over time on a logarithmic axis.");
  std::vector<std::string> names;
  std::map<std::string, int> number;
  for (const BodyRecord& body : data.bodies) {
    if (body.n_impacts == 0) continue;
    number.emplace(body.name, static_cast<int>(number.size()) % kSeriesCount);
    names.push_back(body.name);
  }
  if (names.size() > kSeriesCount) names.clear();  // more than there are colours for
  const double end_s = data.end_s > 0.0 ? data.end_s : 1.0;
  Frame frame = axes_under_legend(svg, kHeight, names, {"Time [s]", Scale::kLinear, 0.0, end_s},
                                  axis_around("Impulse [N s]", Scale::kLog, sizes));
  for (const scene::ImpactRecord& impact : impacts) {
    if (!frame.shows(impact.time_s, impact.impulse_n_s)) continue;
    svg.marker(number[impact.body], frame.x(impact.time_s), frame.y(impact.impulse_n_s), 4,
               impact.body + " on " + impact.other + " at " + rounded(impact.time_s, 5) +
                   " s: " + rounded(impact.impulse_n_s, 4) + " N s in " + rounded(1e6 * impact.duration_s, 3) + " µs");
  }
  return svg;
}

std::string place_text(const std::array<double, 3>& place) {
  return fixed(place[0], 3) + ", " + fixed(place[1], 3) + ", " + fixed(place[2], 3);
}

std::string body_table(const SceneDocument& data) {
  std::string body;
  for (std::size_t i = 0; i < std::min(kMostBodyRows, data.bodies.size()); ++i) {
    const BodyRecord& row = data.bodies[i];
    body += "<tr>" + tag("th", escaped(row.name), "scope=\"row\"") + tag("td", escaped(row.material)) +
            number_cell(rounded(row.mass_kg, 4), row.mass_kg) +
            number_cell(row.n_modes > 0 ? std::to_string(row.n_modes) : "—") +
            number_cell(std::to_string(row.n_impacts)) +
            number_cell(row.hardest_impact_n_s ? rounded(*row.hardest_impact_n_s, 3) : "—", row.hardest_impact_n_s) +
            number_cell(row.fixed ? "fixed" : place_text(row.final.position_m)) + "</tr>\n";
  }
  std::string html = scrolled(
      "<table><thead><tr><th scope=\"col\">Body</th><th scope=\"col\">Material</th><th scope=\"col\" class=\"n\">Mass "
      "[kg]</th><th scope=\"col\" class=\"n\">Modes heard</th><th scope=\"col\" class=\"n\">Impacts</th><th "
      "scope=\"col\" "
      "class=\"n\">Hardest [N s]</th><th scope=\"col\" class=\"n\">Ends at [m]</th></tr></thead>\n<tbody>" +
          body + "</tbody></table>",
      "Bodies");
  if (data.bodies.size() > kMostBodyRows)
    html += "<p class=\"how\"><small>The first " + std::to_string(kMostBodyRows) + " of " +
            std::to_string(data.bodies.size()) + " bodies; scene.json has all.</small></p>\n";
  return html;
}

std::string key_figures(const SceneDocument& data) {
  KeyFigures keys;
  keys.add("Bodies", std::to_string(data.bodies.size()),
           std::to_string(std::count_if(data.bodies.begin(), data.bodies.end(),
                                        [](const BodyRecord& b) { return b.n_modes > 0; })) +
               " heard");
  keys.add("Motion", rounded(data.end_s, 4) + "\u202fs", std::to_string(data.n_steps) + " steps");
  keys.add("Impacts", std::to_string(data.impulses_summary.n_impacts), "points that touch anew");
  keys.add("Energy accounted for", "to " + rounded(data.ledger.residual_relative, 2),
           "of " + rounded(data.ledger.energy_scale_j, 4) + "\u202fJ");
  if (data.sound) {
    const double level_db = 20.0 * std::log10(data.sound->peak_pressure_pa / kReferencePressurePa);
    keys.add("Peak at the ear", rounded(data.sound->peak_pressure_pa, 3) + "\u202fPa",
             data.sound->peak_pressure_pa > 0.0 ? fixed(level_db, 1) + " dB re 20 µPa" : "");
  }
  return keys.html();
}

/// Where the energy went: contacts and friction always, of the rest what is more than nothing.
std::string energy_sentence(const scene::LedgerRecord& ledger) {
  const double scale_j = ledger.energy_scale_j;
  const auto matters = [&](double energy_j) { return std::abs(energy_j) > kMatters * scale_j; };
  const auto percent = [&](double energy_j) {
    return (matters(energy_j) ? rounded(100.0 * energy_j / scale_j, 3) : "0") + " %";
  };
  std::vector<std::string> parts = {"contacts took " + percent(ledger.contact_j),
                                    "friction " + percent(ledger.friction_j)};
  for (const auto& [energy_j, words] :
       {std::pair(ledger.viscous_j, "viscosity "), std::pair(ledger.plastic_j, "plastic flow "),
        std::pair(ledger.fracture_j, "new surfaces "),
        std::pair(ledger.vibration_j.value_or(0.0), "vibration and heat of what broke ")})
    if (matters(energy_j)) parts.push_back(words + percent(energy_j));
  std::string text = "Of the energy that the scene had to spend, " + rounded(scale_j, 4) + " J, ";
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 < parts.size() ? ", " : " and ") + parts[i];
  if (matters(ledger.work_j)) text += "; what is held put in " + rounded(ledger.work_j, 4) + " J all in all";
  if (matters(ledger.most_strain_j))
    text += "; under load bodies held up to " + rounded(ledger.most_strain_j, 4) + " J of strain";
  return text + ".";
}

std::vector<std::string> sentences_of(const SceneDocument& data) {
  std::vector<std::string> sentences;
  const auto& impacts = data.impulses_summary.hardest;
  if (impacts.empty()) {
    sentences.emplace_back("Nothing struck anything.");
  } else {
    const auto hardest = std::max_element(impacts.begin(), impacts.end(),
                                          [](const auto& a, const auto& b) { return a.impulse_n_s < b.impulse_n_s; });
    sentences.push_back("The hardest impact, of " + escaped(hardest->body) + " on " + escaped(hardest->other) + " at " +
                        rounded(hardest->time_s, 4) + " s, gave <b>" + rounded(hardest->impulse_n_s, 3) +
                        " N s</b> within " + rounded(1e6 * hardest->duration_s, 3) + " µs.");
  }
  if (data.ledger.energy_scale_j > 0.0) sentences.push_back(energy_sentence(data.ledger));
  // A cracking body parts in hundreds of steps: one sentence, not one for each.
  std::map<std::string, std::vector<const scene::SceneEventRecord*>> splits;
  for (const scene::SceneEventRecord& event : data.events)
    if (event.kind == "split") splits[event.body].push_back(&event);
  for (const auto& [body, steps] : splits)
    sentences.push_back(escaped(body) + " cracked from " + rounded(steps.front()->time_s, 4) + " s to " +
                        rounded(steps.back()->time_s, 4) + " s, in " + std::to_string(steps.size()) +
                        (steps.size() == 1 ? " step" : " steps") + ", and consists of " +
                        std::to_string(steps.back()->pieces) + (steps.back()->pieces == 1 ? " piece." : " pieces."));
  for (const scene::SceneEventRecord& event : data.events)
    if (event.kind != "split")
      sentences.push_back("At " + rounded(event.time_s, 4) + " s " + escaped(event.body) + " broke into " +
                          std::to_string(event.pieces) + " pieces.");
  return sentences;
}

/// Pieces of each body that broke, how many are at least as heavy, and what they are together.
std::optional<Svg> pieces_figure(const SceneDocument& data) {
  std::map<std::string, std::vector<double>> pieces;
  for (const BodyRecord& body : data.bodies)
    if (body.parent) pieces[*body.parent].push_back(body.mass_kg);
  std::vector<std::string> names;
  std::vector<double> masses;
  double most = 1.0;
  for (auto& [name, mass_kg] : pieces) {
    std::sort(mass_kg.begin(), mass_kg.end(), std::greater<>());
    if (names.size() < kSeriesCount) names.push_back(name);
    masses.insert(masses.end(), mass_kg.begin(), mass_kg.end());
    most = std::max(most, static_cast<double>(mass_kg.size()));
  }
  if (masses.empty()) return {};
  constexpr double kHeight = 340;
  Svg svg(kPageWidth, kHeight, "How many pieces are at least as heavy as a mass, both on logarithmic axes.");
  const bool coloured = pieces.size() <= kSeriesCount;
  for (double& mass_kg : masses) mass_kg *= 1e3;
  Frame frame = axes_under_legend(svg, kHeight, coloured ? names : std::vector<std::string>{},
                                  axis_around("Mass [g]", Scale::kLog, masses),
                                  axis_around("Pieces at least as heavy", Scale::kLog, {1.0, most}));
  int series = 0;
  for (const auto& [name, mass_kg] : pieces) {
    for (std::size_t i = 0; i < mass_kg.size(); ++i)
      svg.marker(series, frame.x(1e3 * mass_kg[i]), frame.y(static_cast<double>(i + 1)), 3,
                 "piece " + std::to_string(i + 1) + " of " + name + ": " + rounded(1e3 * mass_kg[i], 4) + " g");
    series = (series + 1) % kSeriesCount;
  }
  return svg;
}

std::string pieces_sentence(const SceneDocument& data) {
  std::map<std::string, std::vector<double>> pieces;
  for (const BodyRecord& body : data.bodies)
    if (body.parent) pieces[*body.parent].push_back(body.mass_kg);
  constexpr std::size_t kMostBodies = 8;
  std::string text;
  std::size_t n = 0;
  for (auto& [name, mass_kg] : pieces) {
    if (++n > kMostBodies) break;
    std::sort(mass_kg.begin(), mass_kg.end());
    double sum_kg = 0.0;
    for (const double m : mass_kg) sum_kg += m;
    text += (text.empty() ? "" : " ") + escaped(name) + ": " + std::to_string(mass_kg.size()) + " pieces of " +
            rounded(1e3 * mass_kg.front(), 3) + " to " + rounded(1e3 * mass_kg.back(), 3) + " g, half of them below " +
            rounded(1e3 * mass_kg[mass_kg.size() / 2], 3) + " g; the heaviest is " +
            rounded(100.0 * mass_kg.back() / sum_kg, 3) + " % of the whole.";
  }
  return text;
}

std::string draws_html(const SceneDocument& data) {
  if (!data.draws) return {};
  const scene::DrawsRecord& draws = *data.draws;
  std::string names, rows;
  for (const std::string& name : draws.materials) names += (names.empty() ? "" : ", ") + escaped(name);
  for (const scene::DrawnPartial& p : draws.partials)
    rows += "<tr>" + tag("th", escaped(p.body), "scope=\"row\"") +
            number_cell(fixed(p.frequency_hz, 2), p.frequency_hz) +
            number_cell(fixed(p.low_hz, 2) + " to " + fixed(p.high_hz, 2)) +
            number_cell(rounded(p.decay_per_s, 4), p.decay_per_s) +
            number_cell(rounded(p.low_decay_per_s, 4) + " to " + rounded(p.high_decay_per_s, 4)) + "</tr>\n";
  return "<p>The sound again for " + std::to_string(draws.n) + " draws from what the fit says of " + names +
         ": nine of ten lie within " + fixed(draws.low_level_db, 2) + " to " + fixed(draws.high_level_db, 2) +
         " dB of the level, with peaks of " + rounded(draws.low_peak_pressure_pa, 3) + " to " +
         rounded(draws.high_peak_pressure_pa, 3) +
         " Pa. The motion stays; shapes and radiation stay those of the estimate.</p>\n" +
         scrolled(
             "<table><thead><tr><th scope=\"col\">Body</th><th scope=\"col\" class=\"n\">Partial [Hz]</th><th "
             "scope=\"col\" class=\"n\">90 % of draws</th><th scope=\"col\" class=\"n\">Decay [1/s]</th><th "
             "scope=\"col\" class=\"n\">90 % of draws</th></tr></thead>\n<tbody>" +
                 rows + "</tbody></table>",
             "Partials over the draws");
}

/// Times that are shown: the start, just before and after what broke first, the end; while something cracks, moments
/// at which so many of its splits have happened; else even ones.
std::vector<int> still_numbers(const SceneDocument& data) {
  constexpr int kStills = 6;
  const int last = data.frames->n_frames - 1;
  const auto frame_of = [&](double time_s) { return static_cast<int>(time_s * data.frames->rate_hz); };
  std::vector<int> numbers = {0, last};
  std::vector<double> splits_s;
  for (const scene::SceneEventRecord& event : data.events) {
    if (event.kind == "split") {
      splits_s.push_back(event.time_s);
      continue;
    }
    for (const int number : {frame_of(event.time_s), frame_of(event.time_s) + 1, frame_of(event.time_s) + 4})
      if (number <= last && numbers.size() < kStills) numbers.push_back(number);
  }
  if (!splits_s.empty()) {
    const std::size_t n = splits_s.size();
    for (const int number : {frame_of(splits_s.front()), frame_of(splits_s[n / 3]) + 1,
                             frame_of(splits_s[2 * n / 3]) + 1, (frame_of(splits_s.back()) + 1 + last) / 2})
      if (numbers.size() < kStills) numbers.push_back(std::min(number, last));
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  // Where all that happens happens at one moment, the longest gaps are halved.
  while (numbers.size() < kStills && (data.events.empty() || !splits_s.empty())) {
    std::size_t widest = 1;
    for (std::size_t i = 1; i < numbers.size(); ++i)
      if (numbers[i] - numbers[i - 1] > numbers[widest] - numbers[widest - 1]) widest = i;
    if (numbers.size() < 2 || numbers[widest] - numbers[widest - 1] < 2) break;
    numbers.insert(numbers.begin() + static_cast<std::ptrdiff_t>(widest), (numbers[widest] + numbers[widest - 1]) / 2);
  }
  return numbers;
}

std::string stills_html(const SceneDocument& data, ReportFolder& folder) {
  if (!data.frames || !data.frames->series || !folder.options().pictures) return {};
  const std::vector<int> numbers = still_numbers(data);
  std::vector<FramePictureRequest> requests;
  for (const int number : numbers)
    requests.push_back(
        {folder.path() / scene::Frames::vtp_name(static_cast<std::size_t>(number)), data.frames->low_m[2]});
  folder.monitor().throw_if_stopped();
  const DrawnPictures drawn = render_frames(requests, folder.monitor());
  if (!drawn.warning.empty()) folder.warn(drawn.warning);
  std::string body;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const DrawnPicture& picture = drawn.pictures[k];
    if (picture.png.empty()) continue;
    const std::string file = "figures/still-" + std::to_string(numbers[k]) + ".png";
    folder.add_file(file, picture.png);
    const std::string when = rounded(numbers[k] / data.frames->rate_hz, 4) + " s";
    body += "<figure><img alt=\"The scene at " + when + "\" width=\"" + std::to_string(picture.width) + "\" height=\"" +
            std::to_string(picture.height) + "\" src=\"" + data_uri("image/png", picture.png) + "\">" +
            tag("figcaption", "<b>" + when + "</b>, lines every " + rounded(100 * picture.high, 3) + " cm") +
            "</figure>\n";
  }
  return body.empty() ? "" : "<div class=\"pictures\">" + body + "</div>\n";
}

Page make(const SceneDocument& data, ReportFolder& folder) {
  Page page;
  page.over = "Klangprobe · from sound to scene";
  page.title = data.name.empty() ? "Scene" : data.name;
  const bool closes = data.ledger.residual_relative <= data.ledger.limit;
  page.verdict = {closes ? "Every joule accounted for" : "Energy does not close", closes ? "good" : "bad", ""};
  page.sentences = sentences_of(data);
  page.key_figures = key_figures(data);
  std::string sound, impacts, energy, pieces;
  if (data.sound) {
    SoundPair pair;
    pair.name = data.name;
    pair.recorded_words = "At the listener";
    pair.recorded = folder.sound_beside(data.sound->file);
    for (const scene::ImpactRecord& impact : data.impulses_summary.hardest)
      if (impact.impulse_n_s >= 0.05 * data.impulses_summary.largest_impact_n_s)
        pair.strikes_s.push_back(impact.time_s);
    for (const scene::SceneEventRecord& event : data.events)
      if (event.kind != "split") pair.breaks_s.push_back(event.time_s);
    const SoundMedia media = sound_media(pair, 1, folder);
    sound = players(media, pair);
    sound +=
        spectrogram_html(media, "",
                         std::string("Spectrogram of the sound at the listener; triangles mark the hardest impacts") +
                             (pair.breaks_s.empty() ? "." : ", a dashed line with a cross what breaks."));
  }
  if (const std::optional<Svg> svg = impact_figure(data)) {
    folder.add_figure("impacts", *svg);
    impacts = figure(sheet(*svg), "Impulse of each impact, one mark per body that it pushes.");
  }
  if (const std::optional<Svg> svg = pieces_figure(data)) {
    folder.add_figure("pieces", *svg);
    pieces = figure(sheet(*svg), pieces_sentence(data) + " A mark per piece: its mass, and how many are as heavy.");
  }
  if (const std::optional<Svg> svg = energy_figure(data, folder)) {
    folder.add_figure("energy", *svg);
    energy = figure(sheet(*svg),
                    "Where the energy is and where it went: kinetic and potential energy (this from its lowest value "
                    "on), strain of bodies that deform, and what was lost and put in since the start.");
  }
  page.sections = {{"sound", "Sound", sound},
                   {"motion", "Motion", stills_html(data, folder)},
                   {"draws", "How sure the sound is", draws_html(data)},
                   {"impacts", "Impacts", impacts},
                   {"pieces", "Pieces by mass", pieces},
                   {"energy", "Energy", energy},
                   {"bodies", "Bodies", body_table(data)}};
  add_if_there(data.sound ? std::optional<std::string>(data.sound->file) : std::nullopt, "– sound at the listener",
               folder, page.downloads);
  add_if_there(data.files.ledger, "– energies, a row per step", folder, page.downloads);
  add_if_there(data.files.events, "– impulses and poses, HDF5", folder, page.downloads);
  if (data.frames) {
    add_if_there(data.frames->animation, "– motion with keyframes, glTF (Blender)", folder, page.downloads);
    add_if_there(data.frames->series, "– frames of the motion (ParaView)", folder, page.downloads);
  }
  page.downloads.push_back(kFiguresDownload);
  page.footer = "Restitution and friction are given, not found; strength and toughness do not follow from ringing.";
  return page;
}

}  // namespace

PageKind scene_page() { return page_kind<SceneDocument>("scene", make); }

}  // namespace klang::reports::detail
