#include <cmath>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/stage/bubble_scene.hpp"

namespace klang::stage {
namespace {

using bubble::BubbleMedium;
using bubble::BubbleMotion;
using bubble::BubbleTheory;
using bubble::kLargestRadiusM;
using bubble::kSmallestRadiusM;
using bubble::PitchKind;
using bubble::RiseKind;
using bubble::RiseOptions;
using bubble::TimeSeries;
using bubble::TransferSeries;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxBubbles = 1'000'000;

const TomlField kSchema[] = {
    {"", "name", TomlType::kText, "the file's name", -kInf, kInf, "title"},
    {"", "liquid", TomlType::kTable, "water", -kInf, kInf, "the liquid"},
    {"", "gas", TomlType::kTable, "air", -kInf, kInf, "the gas in the bubbles"},
    {"", "air", TomlType::kTable, "air at 20 °C", -kInf, kInf, "around the listener"},
    {"", "sound", TomlType::kTable, "the defaults below", -kInf, kInf, "rate, length, level, formulas"},
    {"", "pitch", TomlType::kTable, "the defaults below", -kInf, kInf, "how the pitch rises near the surface"},
    {"", "listener", TomlType::kTable, "the defaults below", -kInf, kInf, "where it is heard"},
    {"", "bubble", TomlType::kTables, "none", -kInf, kInf, "one `[[bubble]]` each, up to 1000000"},
    {"", "population", TomlType::kTables, "none", -kInf, kInf, "one `[[population]]` each, up to 1000: seeded bubbles"},

    {"liquid", "density_kg_m3", TomlType::kNumber, "1000", 100, 2e4, "density"},
    {"liquid", "sound_speed_m_s", TomlType::kNumber, "1497", 100, 1e4, "sound speed"},
    {"liquid", "viscosity_pa_s", TomlType::kNumber, "0.00089", 0, 10, "shear viscosity"},
    {"liquid", "surface_tension_n_m", TomlType::kNumber, "0.0726", 0, 1, "surface tension"},
    {"liquid", "static_pressure_pa", TomlType::kNumber, "101325", 1e3, 1e8, "pressure"},

    {"gas", "heat_capacity_ratio", TomlType::kNumber, "1.4", 1.01, 1.7, "γ"},
    {"gas", "diffusivity_m2_s", TomlType::kNumber, "2.122e-05", 1e-8, 1e-2, "thermal diffusivity"},
    {"gas", "density_kg_m3", TomlType::kNumber, "1.2041", 0, 100, "density"},

    {"air", "density_kg_m3", TomlType::kNumber, "1.2041", 1e-3, 1e4, "density"},
    {"air", "sound_speed_m_s", TomlType::kNumber, "343", 10, 1e4, "sound speed"},

    {"sound", "sample_rate_hz", TomlType::kNumber, "48000", 4000, 768000, "sample rate"},
    {"sound", "duration_s", TomlType::kNumber, "until the last bubble has ended", 0.001, 3600, "length"},
    {"sound", "peak_db_re_full_scale", TomlType::kNumber, "-3", -120, 0, "level of the highest peak in the file"},
    {"sound", "theory", TomlType::kText, "`leighton`", -kInf, kInf,
     "`leighton`, `prosperetti` (exact thermal damping) or `paper` (as printed)"},
    {"sound", "excitation", TomlType::kText, "`pressure_step`", -kInf, kInf, "`pressure_step` or `paper` (as printed)"},
    {"sound", "attack", TomlType::kText, "`soft`", -kInf, kInf, "`soft` (eq. 39) or `none`"},
    {"sound", "transfer", TomlType::kText, "`half_space`", -kInf, kInf,
     "`half_space`: below a wide plane surface; `unit`: |P| = 1, for comparison"},

    {"pitch", "model", TomlType::kText, "`harmonic_fluids`", -kInf, kInf,
     "`harmonic_fluids` (eq. 6), `harmonic_fluids_frozen` (ω of the start in the increment), `strasberg`, "
     "`two_sphere` (exact plane), `constant`"},
    {"pitch", "k_delta_per_m", TomlType::kNumber, "72.95", 0, 1e4, "K_Δ of eq. (6)"},
    {"pitch", "eta", TomlType::kNumber, "1.24", 0.01, 100, "η of eq. (6)"},
    {"pitch", "phi0_m", TomlType::kNumber, "-0.008", -1, -1e-5, "φ0 of eq. (6), negative"},
    {"pitch", "largest_factor", TomlType::kNumber, "3", 1, 1000, "no model raises the pitch above this"},

    {"listener", "position_m", TomlType::kVector, "[0, -1, 0.5]", -1e4, 1e4, "centre of the head, z above 0"},
    {"listener", "facing", TomlType::kVector, "[0, 1, 0]", -1e4, 1e4,
     "direction of the nose; its horizontal part counts"},
    {"listener", "path_csv", TomlType::kText, "none", -kInf, kInf,
     "of a listener who moves, instead of the position: `time_s,x_m,y_m,z_m` and, where it turns, "
     "`facing_x,facing_y,facing_z`"},
    {"listener", "mode", TomlType::kText, "`stereo`", -kInf, kInf,
     "`stereo` (two ears of a spherical head) or `mono` (modulus of the transfer)"},
    {"listener", "head_radius_m", TomlType::kNumber, "0.0875", 0.01, 0.5, "radius of the head"},
    {"listener", "ear_azimuth_deg", TomlType::kNumber, "100", 0, 180, "of each ear from the nose"},
    {"listener", "propagation_delay", TomlType::kBoolean, "false", -kInf, kInf, "sound arrives distance / c later"},

    {"bubble", "radius_m", TomlType::kNumber, "required", kSmallestRadiusM, kLargestRadiusM, "radius"},
    {"bubble", "birth_s", TomlType::kNumber, "0", 0, 3600, "when it is hit"},
    {"bubble", "strength", TomlType::kNumber, "1", -1e6, 1e6, "times the excitation by its surface tension"},
    {"bubble", "position_m", TomlType::kVector, "with path_csv: from there", -1e4, 1e4,
     "centre at birth; the surface is z = 0, the liquid below"},
    {"bubble", "rise", TomlType::kText, "`fixed`", -kInf, kInf,
     "`fixed`, `constant` speed, or `terminal`: buoyancy, drag and the added mass of the liquid"},
    {"bubble", "rise_speed_m_s", TomlType::kNumber, "0", -100, 100, "upwards: the constant speed, or that at birth"},
    {"bubble", "drag_coefficient", TomlType::kNumber, "0.2", 1e-3, 100, "of the rise, on the area 4 π r²"},
    {"bubble", "stop_depth_radii", TomlType::kNumber, "1.05", 1, 100,
     "depth at which a rising bubble comes to rest, in radii"},
    {"bubble", "path_csv", TomlType::kText, "none", -kInf, kInf,
     "instead of position and rise: `time_s,x_m,y_m,z_m` and, where the surface is not plane, `phi_m`; even time "
     "steps"},
    {"bubble", "phi_csv", TomlType::kText, "none", -kInf, kInf,
     "with a position, instead of a rise: `time_s,phi_m`; even time steps"},
    {"bubble", "phi_lowpass_hz", TomlType::kNumber, "200", 1, 1e9, "low-pass of the φ of a file"},
    {"bubble", "transfer_file", TomlType::kText, "none", -kInf, kInf,
     "pressure at the listener for unit vibration amplitude: CSV `time_s,frequency_hz,re,im`, or JSON with "
     "`transfer[]`: {time_s, "
     "frequency_hz, re, im}"},

    {"population", "count", TomlType::kNumber, "required", 1, 1e6, "number of bubbles"},
    {"population", "distribution", TomlType::kText, "`lognormal`", -kInf, kInf,
     "of the radii: `lognormal`, `gaussian` or `uniform`; drawn again outside the limits"},
    {"population", "radius_m", TomlType::kNumber, "0.001", kSmallestRadiusM, kLargestRadiusM,
     "median (lognormal) or mean (gaussian)"},
    {"population", "spread", TomlType::kNumber, "0.4", 0, 10, "standard deviation over `radius_m`, or of ln radius"},
    {"population", "smallest_radius_m", TomlType::kNumber, "0.0003", kSmallestRadiusM, kLargestRadiusM,
     "limit of the radii"},
    {"population", "largest_radius_m", TomlType::kNumber, "0.005", kSmallestRadiusM, kLargestRadiusM,
     "limit of the radii"},
    {"population", "time_start_s", TomlType::kNumber, "0", 0, 3600, "births are uniform from here"},
    {"population", "time_end_s", TomlType::kNumber, "required", 0, 3600, "to here"},
    {"population", "box_low_m", TomlType::kVector, "required", -1e4, 1e4, "births are uniform in this box"},
    {"population", "box_high_m", TomlType::kVector, "required", -1e4, 1e4, "its other corner; z below 0"},
    {"population", "strength_std_db", TomlType::kNumber, "0", 0, 40, "scatter of the strength (normal in dB)"},
    {"population", "rise", TomlType::kText, "`fixed`", -kInf, kInf,
     "`fixed`, `constant` speed, or `terminal`: buoyancy, drag and the added mass of the liquid"},
    {"population", "rise_speed_m_s", TomlType::kNumber, "0", -100, 100,
     "upwards: the constant speed, or that at birth"},
    {"population", "drag_coefficient", TomlType::kNumber, "0.2", 1e-3, 100, "of the rise, on the area 4 π r²"},
    {"population", "stop_depth_radii", TomlType::kNumber, "1.05", 1, 100,
     "depth at which a rising bubble comes to rest, in radii"},
};

RiseOptions read_rise(const TomlTable& table) {
  RiseOptions rise;
  rise.kind = *enum_from_text<RiseKind>(table.choice("rise", {"fixed", "constant", "terminal"}));
  if (rise.kind == RiseKind::kFixed && table.has("rise_speed_m_s"))
    throw InputError(table.place("rise_speed_m_s"), "has no meaning without a rise", "",
                     "rise = \"constant\" or \"terminal\"");
  rise.speed_m_s = table.number("rise_speed_m_s", 0.0);
  rise.drag_coefficient = table.number("drag_coefficient", rise.drag_coefficient);
  rise.stop_depth_radii = table.number("stop_depth_radii", rise.stop_depth_radii);
  return rise;
}

// Adds the line of the scene to complaints that know another file, or none.
template <class Function>
auto located(const std::string& place, Function&& function) {
  try {
    return function();
  } catch (const InputError& error) {
    throw InputError(place, error.what());
  }
}

std::shared_ptr<const BubbleMotion> read_path(const TomlTable& table, const std::filesystem::path& base,
                                              double birth_s) {
  const bool path = table.has("path_csv");
  const std::string_view key = path ? "path_csv" : "phi_csv";
  for (const std::string_view other : {"rise", "rise_speed_m_s", "drag_coefficient", "stop_depth_radii"}) {
    if (table.has(other)) throw InputError(table.place(other), "has no meaning beside a file", std::string(key));
  }
  if (path && (table.has("position_m") || table.has("phi_csv")))
    throw InputError(table.place("path_csv"), "says the position itself", "", "no position_m, no phi_csv");
  const std::filesystem::path file = base / table.text(key);
  static constexpr std::string_view kPlaces[] = {"x_m", "y_m", "z_m"}, kPhi[] = {"phi_m"};
  const TimeSeries series = located(table.place(key), [&] {
    return path ? bubble::read_time_series(file, kPlaces, kPhi, true) : bubble::read_time_series(file, kPhi, {}, true);
  });
  if (series.times_s.front() > birth_s) {
    throw InputError(table.place(key), file.string() + " starts after the bubble's birth",
                     to_text(series.times_s.front()) + " s", "up to " + to_text(birth_s) + " s");
  }
  bubble::SampledMotion samples;
  samples.cutoff_hz = table.number("phi_lowpass_hz", samples.cutoff_hz);
  for (std::size_t i = 0; i < series.times_s.size(); ++i) {
    samples.times_s.push_back(series.times_s[i] - birth_s);
    if (path) samples.positions_m.emplace_back(series.columns[0][i], series.columns[1][i], series.columns[2][i]);
  }
  samples.phi_m = series.columns[path ? 3 : 0];
  if (!path) samples.positions_m = {table.vector("position_m")};
  const auto motion = bubble::sampled_motion(std::move(samples));
  if (!(motion->phi_m(0.0).v < 0.0)) {
    throw InputError(table.place(key), file.string() + ": the bubble is not in the liquid at its birth",
                     "phi = " + to_text(motion->phi_m(0.0).v) + " m", "below 0");
  }
  return motion;
}

using TransferFiles = std::map<std::filesystem::path, std::shared_ptr<const TransferSeries>>;

SceneBubble read_bubble(const TomlTable& table, const std::filesystem::path& base, const BubbleScene& scene,
                        TransferFiles& files) {
  SceneBubble bubble;
  bubble.radius_m = table.number("radius_m");
  bubble.birth_s = table.number("birth_s", 0.0);
  bubble.strength = table.number("strength", 1.0);
  if (bubble.strength == 0.0) throw InputError(table.place("strength"), "hits no bubble", "0", "not 0");
  if (table.has("path_csv") || table.has("phi_csv")) {
    bubble.motion = read_path(table, base, bubble.birth_s);
  } else {
    const RiseOptions rise = read_rise(table);
    const Eigen::Vector3d position = table.vector("position_m");
    bubble.motion = located(table.place("position_m"),
                            [&] { return bubble::analytic_rise(position, bubble.radius_m, rise, scene.medium); });
  }
  if (table.has("transfer_file")) {
    const std::filesystem::path file = base / table.text("transfer_file");
    std::shared_ptr<const TransferSeries>& transfer = files[file];
    if (!transfer) {
      transfer = located(table.place("transfer_file"),
                         [&] { return std::make_shared<const TransferSeries>(bubble::read_transfer_series(file)); });
    }
    bubble.transfer = transfer;
  }
  located(table.place("radius_m"),
          [&] { return bubble::bubble_oscillation(bubble.radius_m, scene.medium, scene.theory); });
  return bubble;
}

void add_population(const TomlTable& table, std::uint64_t seed, std::uint64_t number, BubbleScene& scene) {
  const double wanted = table.number("count");
  if (wanted != std::floor(wanted)) throw InputError(table.place("count"), "is no whole number", to_text(wanted));
  const auto count = static_cast<std::size_t>(wanted);
  if (scene.bubbles.size() + count > kMaxBubbles)
    throw InputError(table.place("count"), "makes too many bubbles", "", std::to_string(kMaxBubbles));
  const std::string distribution = table.choice("distribution", {"lognormal", "gaussian", "uniform"});
  const double middle = table.number("radius_m", 1e-3), spread = table.number("spread", 0.4);
  const double smallest = table.number("smallest_radius_m", 3e-4), largest = table.number("largest_radius_m", 5e-3);
  if (!(smallest <= largest))
    throw InputError(table.place("largest_radius_m"), "is below the smallest", to_text(largest),
                     to_text(smallest) + " or more");
  if (distribution != "uniform" && !(smallest <= middle && middle <= largest)) {
    throw InputError(table.place("radius_m"), "lies outside the limits of the radii", to_text(middle),
                     to_text(smallest) + " to " + to_text(largest));
  }
  const double from = table.number("time_start_s", 0.0), until = table.number("time_end_s");
  if (!(until >= from))
    throw InputError(table.place("time_end_s"), "lies before the start", to_text(until), "from " + to_text(from));
  const Eigen::Vector3d low = table.vector("box_low_m"), high = table.vector("box_high_m");
  if (!(low.array() <= high.array()).all() || !(high.z() < 0.0))
    throw InputError(table.place("box_high_m"), "is no box below the surface", "z = " + to_text(high.z()),
                     "box_low_m up to z below 0");
  const double strength_std_db = table.number("strength_std_db", 0.0);
  const RiseOptions rise = read_rise(table);
  located(table.place("smallest_radius_m"),
          [&] { return bubble::bubble_oscillation(smallest, scene.medium, scene.theory); });
  for (std::size_t i = 0; i < count; ++i) {
    RandomStream random(seed, (number << 32) | i);
    SceneBubble bubble;
    for (int turn = 0; turn < 1000; ++turn) {  // a spread of any size finds its way into the limits
      const double draw = distribution == "uniform"    ? random.uniform(smallest, largest)
                          : distribution == "gaussian" ? middle * (1.0 + spread * random.normal())
                                                       : middle * std::exp(spread * random.normal());
      bubble.radius_m = middle;
      if (draw >= smallest && draw <= largest) {
        bubble.radius_m = draw;
        break;
      }
    }
    bubble.birth_s = random.uniform(from, until);
    Eigen::Vector3d position;
    for (int axis = 0; axis < 3; ++axis) position[axis] = random.uniform(low[axis], high[axis]);
    bubble.strength = std::pow(10.0, strength_std_db * random.normal() / 20.0);
    bubble.motion = bubble::analytic_rise(position, bubble.radius_m, rise, scene.medium);
    scene.bubbles.push_back(std::move(bubble));
  }
}

void read_media(const TomlTable& root, BubbleScene& scene) {
  const TomlTable liquid = root.table("liquid"), gas = root.table("gas"), air = root.table("air");
  BubbleMedium& m = scene.medium;
  m.liquid_density_kg_m3 = liquid.number("density_kg_m3", m.liquid_density_kg_m3);
  m.liquid_sound_speed_m_s = liquid.number("sound_speed_m_s", m.liquid_sound_speed_m_s);
  m.liquid_viscosity_pa_s = liquid.number("viscosity_pa_s", m.liquid_viscosity_pa_s);
  m.surface_tension_n_m = liquid.number("surface_tension_n_m", m.surface_tension_n_m);
  m.static_pressure_pa = liquid.number("static_pressure_pa", m.static_pressure_pa);
  m.heat_capacity_ratio = gas.number("heat_capacity_ratio", m.heat_capacity_ratio);
  m.gas_diffusivity_m2_s = gas.number("diffusivity_m2_s", m.gas_diffusivity_m2_s);
  m.gas_density_kg_m3 = gas.number("density_kg_m3", m.gas_density_kg_m3);
  scene.air_density_kg_m3 = air.number("density_kg_m3", scene.air_density_kg_m3);
  scene.air_sound_speed_m_s = air.number("sound_speed_m_s", scene.air_sound_speed_m_s);
}

void read_sound(const TomlTable& sound, BubbleScene& scene) {
  scene.sample_rate_hz = sound.number("sample_rate_hz", scene.sample_rate_hz);
  scene.duration_s = sound.optional_number("duration_s");
  scene.peak_db_re_full_scale = sound.number("peak_db_re_full_scale", scene.peak_db_re_full_scale);
  const std::string theory = sound.choice("theory", {"leighton", "prosperetti", "paper"});
  scene.theory = theory == "leighton" ? BubbleTheory::kLeighton
                 : theory == "paper"  ? BubbleTheory::kPaper
                                      : BubbleTheory::kProsperetti;
  scene.printed_excitation = sound.choice("excitation", {"pressure_step", "paper"}) == "paper";
  scene.soft_attack = sound.choice("attack", {"soft", "none"}) == "soft";
}

void read_pitch(const TomlTable& pitch, BubbleScene& scene) {
  const std::string model =
      pitch.choice("model", {"harmonic_fluids", "harmonic_fluids_frozen", "strasberg", "two_sphere", "constant"});
  bubble::PitchModel& p = scene.pitch;
  p.kind = model == "harmonic_fluids"          ? PitchKind::kHarmonicFluids
           : model == "harmonic_fluids_frozen" ? PitchKind::kHarmonicFluidsFrozen
           : model == "strasberg"              ? PitchKind::kStrasberg
           : model == "two_sphere"             ? PitchKind::kTwoSphere
                                               : PitchKind::kConstant;
  p.k_delta_per_m = pitch.number("k_delta_per_m", p.k_delta_per_m);
  p.eta = pitch.number("eta", p.eta);
  p.phi0_m = pitch.number("phi0_m", p.phi0_m);
  p.largest_factor = pitch.number("largest_factor", p.largest_factor);
}

/// A path with straight lines between the times.
struct HeadPath {
  std::vector<double> times_s;
  Eigen::Matrix3Xd centres_m, facings;  // facings: as many, or empty: the direction stays
};

HeadPath read_head_path(const TomlTable& listener, const std::filesystem::path& base) {
  if (listener.has("position_m"))
    throw InputError(listener.place("path_csv"), "says the position itself", "", "no position_m");
  const std::filesystem::path file = base / listener.text("path_csv");
  static constexpr std::string_view kPlaces[] = {"x_m", "y_m", "z_m"}, kFacing[] = {"facing_x", "facing_y", "facing_z"};
  const TimeSeries series =
      located(listener.place("path_csv"), [&] { return bubble::read_time_series(file, kPlaces, kFacing, false); });
  const bool turns = !series.columns[3].empty();
  if (turns != !series.columns[4].empty() || turns != !series.columns[5].empty())
    throw InputError(listener.place("path_csv"), file.string() + " has a part of the columns of the direction", "",
                     "facing_x, facing_y, facing_z");
  const std::size_t n = series.times_s.size();
  HeadPath path{series.times_s, Eigen::Matrix3Xd(3, n), Eigen::Matrix3Xd(3, turns ? n : 0)};
  for (std::size_t i = 0; i < n; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const std::string at = file.string() + ", at " + to_text(series.times_s[i]) + " s";
    path.centres_m.col(column) << series.columns[0][i], series.columns[1][i], series.columns[2][i];
    if (!(series.columns[2][i] > 0.0))
      throw InputError(at, "the listener is not in the air", "z = " + to_text(series.columns[2][i]), "above 0");
    if (!turns) continue;
    path.facings.col(column) << series.columns[3][i], series.columns[4][i], series.columns[5][i];
    if (!(path.facings.col(column).head<2>().norm() > 0.0))
      throw InputError(at, "the listener faces no horizontal direction");
  }
  return path;
}

void read_listener_table(const TomlTable& listener, const std::filesystem::path& base, BubbleScene& scene) {
  SphericalHead head;
  HeadPath path;
  if (listener.has("path_csv")) path = read_head_path(listener, base);
  head.centre_m = listener.vector("position_m", head.centre_m);
  if (!(head.centre_m.z() > 0.0))
    throw InputError(listener.place("position_m"), "is not in the air", "z = " + to_text(head.centre_m.z()) + " m",
                     "above 0");
  head.facing = listener.vector("facing", head.facing);
  head.radius_m = listener.number("head_radius_m", head.radius_m);
  head.ear_azimuth_deg = listener.number("ear_azimuth_deg", head.ear_azimuth_deg);
  head.sound_speed_m_s = scene.air_sound_speed_m_s;
  located(listener.place("facing"), [&] {
    head.validate();
    return 0;
  });
  if (path.times_s.empty()) path = {{0.0}, head.centre_m, {}};
  scene.listener = listener.choice("mode", {"stereo", "mono"}) == "stereo"
                       ? Listener::head(std::move(path.times_s), path.centres_m, path.facings, head)
                       : Listener::ears(std::move(path.times_s), path.centres_m);
  scene.listener.propagation_delay = listener.boolean("propagation_delay", false);
}

}  // namespace

std::vector<TomlField> bubble_settings_fields() {
  std::vector<TomlField> fields;
  for (const TomlField& field : kSchema) {
    const std::string_view name = field.table.empty() ? field.key : field.table;
    const bool own =
        name == "name" || name == "bubble" || name == "population" || (name == "sound" && field.key == "transfer");
    if (!own) fields.push_back(field);
  }
  return fields;
}

void read_bubble_settings(const TomlTable& root, const std::filesystem::path& base_folder, BubbleScene& scene) {
  read_media(root, scene);
  read_sound(root.table("sound"), scene);
  read_pitch(root.table("pitch"), scene);
  read_listener_table(root.table("listener"), base_folder, scene);
}

BubbleScene parse_bubble_scene(std::string_view toml, const std::string& name, const std::filesystem::path& base_folder,
                               std::uint64_t seed) {
  const TomlTable root = TomlTable::parse(toml, name, kSchema);
  BubbleScene scene;
  scene.name = root.text("name", name);
  read_bubble_settings(root, base_folder, scene);
  scene.transfer = root.table("sound").choice("transfer", {"half_space", "unit"}) == "unit" ? SceneTransfer::kUnit
                                                                                            : SceneTransfer::kHalfSpace;
  TransferFiles files;  // bubbles may share one
  for (const TomlTable& bubble : root.tables("bubble", kMaxBubbles))
    scene.bubbles.push_back(read_bubble(bubble, base_folder, scene, files));
  std::uint64_t number = 1;
  for (const TomlTable& population : root.tables("population", 1000)) add_population(population, seed, number++, scene);
  if (scene.bubbles.empty()) throw InputError(name, "has no bubbles", "", "[[bubble]] or [[population]]");
  return scene;
}

BubbleScene read_bubble_scene(const std::filesystem::path& toml, std::uint64_t seed) {
  return parse_bubble_scene(read_file(toml, std::size_t{64} << 20), toml.filename().string(), toml.parent_path(), seed);
}

std::string bubble_scene_schema_markdown() { return toml_schema_markdown(kSchema); }

}  // namespace klang::stage
