#include <algorithm>
#include <cmath>
#include <limits>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/toml_normal_form.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/physics/bubble/time_series.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"

#include "core/sound/liquid_scene/from_recording.hpp"

namespace klang::liquid_scene {
namespace {

using enum TomlType;
using Eigen::Vector3d;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostThings = 1000, kMostBubbles = 1'000'000;
constexpr double kMostCells = 6.4e7;

const TomlField kSchema[] = {
    {"", "name", kText, "the file's name", -kInf, kInf, "title"},
    {"", "domain", kTable, "required", -kInf, kInf, "the box, its cells and the time"},
    {"", "pool", kTables, "none", -kInf, kInf, "one `[[pool]]` each: liquid at rest at the start"},
    {"", "drop", kTables, "none", -kInf, kInf, "one `[[drop]]` each: a ball of liquid at the start"},
    {"", "inlet", kTables, "none", -kInf, kInf, "one `[[inlet]]` each: where liquid comes in"},
    {"", "outlet", kTables, "none", -kInf, kInf, "one `[[outlet]]` each: a box in which liquid is taken away"},
    {"", "solid", kTables, "none", -kInf, kInf, "one `[[solid]]` each: rigid, it does not turn"},
    {"", "bubble", kTables, "none", -kInf, kInf, "one `[[bubble]]` each, besides those that the flow entrains"},
    {"", "entrainment", kTable, "no bubbles but `[[bubble]]`", -kInf, kInf, "how the flow makes bubbles"},
    {"", "transfer", kTable, "the defaults below", -kInf, kInf, "how bubbles are heard through the surface"},

    {"domain", "size_m", kVector, "required", 1e-3, 100, "of the box [0, size], z up; whole cells"},
    {"domain", "cell_m", kNumber, "required", 1e-5, 10, "edge of a cubic cell"},
    {"domain", "duration_s", kNumber, "required", 0, 3600, "length", true},
    {"domain", "imported", kBoolean, "false", -kInf, kInf,
     "the frames are another program's (`klang scene import`): the stage flow is not run"},
    {"domain", "frame_rate_hz", kNumber, "250", 1, 1e5, "frames per second, the first at 0"},
    {"domain", "longest_step_s", kNumber, "0.001", 1e-6, 0.1, "no step is longer"},
    {"domain", "cfl", kNumber, "2", 0.1, 5, "cells that liquid may move in a step"},
    {"domain", "flip_share", kNumber, "0", 0, 1, "0: APIC; 0.97: as much FLIP as is usual"},
    {"domain", "tension", kBoolean, "true where cell_m is at most 0.002", -kInf, kInf,
     "surface tension moves the liquid"},
    {"domain", "gravity_m_s2", kNumber, "9.81", 0, 1e3, "downwards"},
    {"domain", "keep_volume", kBoolean, "true", -kInf, kInf, "the surface is shifted so that no volume is lost"},

    {"pool", "depth_m", kNumber, "this, or low_m and high_m", 0, 100, "over the whole floor", true},
    {"pool", "low_m", kVector, "none", -100, 100, "a corner"},
    {"pool", "high_m", kVector, "none", -100, 100, "the other corner; sides at walls are no surface"},
    {"pool", "wave", kTable, "level", -kInf, kInf, "with `depth_m`: a standing wave, at rest"},
    {"pool.wave", "amplitude_m", kNumber, "required", -1, 1, "a in depth + a cos(m π x / Lx) cos(n π y / Ly)"},
    {"pool.wave", "half_waves", kNumbers, "[1, 0]", 0, 1000, "m and n", false, 2},

    {"drop", "radius_m", kNumber, "required", 0, 10, "radius", true},
    {"drop", "position_m", kVector, "required", -100, 100, "centre"},
    {"drop", "velocity_m_s", kVector, "[0, 0, 0]", -100, 100, "at the start"},

    {"inlet", "shape", kTable, "required", -kInf, kInf, "disc { radius_m } or rectangle { size_m }"},
    {"inlet.shape", "kind", kText, "required", -kInf, kInf, "`disc` or `rectangle`"},
    {"inlet.shape", "radius_m", kNumber, "of a disc", 0, 10, "radius", true},
    {"inlet.shape", "size_m", kVector, "of a rectangle", 0, 100, "extent along the axes, 0 along the flow"},
    {"inlet", "position_m", kVector, "required", -100, 100, "centre of the mouth"},
    {"inlet", "direction", kVector, "[0, 0, -1]", -1, 1, "of the flow, along an axis"},
    {"inlet", "speed_m_s", kNumber, "required", 0, 50, "speed at the mouth", true},
    {"inlet", "flow_l_s", kNumber, "area times speed", 0, 1e5, "litres per second: area times speed within 1 %", true},
    {"inlet", "start_s", kNumber, "0", 0, 3600, "from when on it flows"},

    {"outlet", "low_m", kVector, "required", -100, 100, "a corner"},
    {"outlet", "high_m", kVector, "required", -100, 100, "the other corner"},

    {"solid", "name", kText, "its number", -kInf, kInf, "for messages"},
    {"solid", "shape", kTable, "required", -kInf, kInf, "sphere { radius_m }, box { size_m } or half_space { normal }"},
    {"solid.shape", "kind", kText, "required", -kInf, kInf, "`sphere`, `box` or `half_space`"},
    {"solid.shape", "radius_m", kNumber, "of a sphere", 0, 100, "radius", true},
    {"solid.shape", "size_m", kVector, "of a box", 0, 1000, "edges"},
    {"solid.shape", "normal", kVector, "of a half space", -1e3, 1e3, "out of the solid, any length but 0"},
    {"solid", "position_m", kVector, "required", -1e3, 1e3, "centre; of a half space a point of its plane"},
    {"solid", "motion", kText, "`fixed`", -kInf, kInf,
     "`fixed`; `free` (spheres: liquid and gravity move it); `keys` with `keys_csv`, or the name of that file"},
    {"solid", "keys_csv", kText, "none", -kInf, kInf, "`time_s,x_m,y_m,z_m` of its position, straight between"},
    {"solid", "density_kg_m3", kNumber, "of a free one", 1, 1e5, "density"},
    {"solid", "velocity_m_s", kVector, "[0, 0, 0]", -100, 100, "of a free one at the start"},

    {"bubble", "radius_m", kNumber, "required", 1e-5, 0.05, "radius"},
    {"bubble", "position_m", kVector, "required", -100, 100, "at birth"},
    {"bubble", "birth_s", kNumber, "0", 0, 3600, "when it is hit"},

    {"entrainment", "attempts_per_m2_s", kNumber, "required", 0, 1e12,
     "tries to make a bubble, per area of seeded surface"},
    {"entrainment", "seed_life_s", kNumber, "0.02", 0, 10, "how long a seed lives", true},
    {"entrainment", "window_s", kNumber, "0.008", 0, 1, "over which a marker's depth is watched", true},
    {"entrainment", "threshold_m_s", kNumber, "-1.5", -100, 0, "a marker that sinks faster becomes a seed", true},
    {"entrainment", "coverage", kNumber, "0.6", 0, 1,
     "a bubble is refused where less of its surroundings is seeded; 0: never"},
    {"entrainment", "consume", kBoolean, "false", -kInf, kInf, "a birth ends the seeds around it"},
    {"entrainment", "criterion", kText, "`slope`", -kInf, kInf,
     "`slope` of the depth, or `velocity`: and the liquid itself sinks into the surface"},
    {"entrainment", "literature", kText, "`mended`", -kInf, kInf,
     "`mended`, or `paper`: rates, refusals and pitches as HF prints them"},
    {"entrainment", "drag", kText, "`contaminated`", -kInf, kInf,
     "of bubbles: `contaminated` (slightly) or `clean` water (Tomiyama 1998), or `paper`"},
    {"entrainment", "radii", kTable, "deane_stokes", -kInf, kInf, "of new bubbles"},
    {"entrainment", "patch", kTables, "none", -kInf, kInf, "one `[[entrainment.patch]]` each: markers there are seeds"},
    {"entrainment.radii", "kind", kText, "`deane_stokes`", -kInf, kInf, "`deane_stokes`, `gaussian` or `recording`"},
    {"entrainment.radii", "smallest_m", kNumber, "0.0003", 1e-5, 0.05, "limit"},
    {"entrainment.radii", "largest_m", kNumber, "0.005", 1e-5, 0.05, "limit"},
    {"entrainment.radii", "mean_m", kNumber, "of a gaussian", 1e-5, 0.05, "mean before it is cut"},
    {"entrainment.radii", "std_m", kNumber, "of a gaussian", 0, 0.05, "standard deviation before it is cut", true},
    {"entrainment.radii", "file", kText, "of a recording", -kInf, kInf, "JSON of `klang bubble fit`"},
    {"entrainment.patch", "low_m", kVector, "required", -100, 100, "a corner"},
    {"entrainment.patch", "high_m", kVector, "required", -100, 100, "the other corner"},
    {"entrainment.patch", "start_s", kNumber, "0", 0, 3600, "from"},
    {"entrainment.patch", "end_s", kNumber, "the end", 0, 3600, "until"},

    {"transfer", "method", kText, "`reciprocal`", -kInf, kInf,
     "`reciprocal`, `forward`, `half_space` (wide plane surface) or `unit` (|P| = 1, for comparison)"},
    {"transfer", "bins_per_octave", kNumber, "6", 1, 48, "frequencies at which the air is solved"},
    {"transfer", "liquid_loss_factor", kNumber, "0.02", 0, 1, "η in k² = k0² (1 − i η)"},
    {"transfer", "wall_admittance", kNumber, "0", 0, 10,
     "of walls and floor: ρc of the liquid times their speed over the pressure; 0: rigid"},
};

/// The table above and those that scenes of bubbles have, too.
const std::vector<TomlField>& schema() {
  static const std::vector<TomlField> fields = [] {
    std::vector<TomlField> all(std::begin(kSchema), std::end(kSchema));
    for (const TomlField& field : stage::bubble_settings_fields()) {
      all.push_back(field);
      if (field.table == "pitch" && field.key == "largest_factor")
        all.push_back(
            {"pitch", "from", kText, "none", -kInf, kInf, "JSON of `klang bubble fit`: the rise that it found"});
    }
    return all;
  }();
  return fields;
}

std::string words(const Vector3d& v) { return to_text(v.x()) + ", " + to_text(v.y()) + ", " + to_text(v.z()); }

/// What is allowed of places in the box.
std::string within(const Vector3d& size) { return "0, 0, 0 to " + words(size) + " m"; }

void read_domain(const TomlTable& table, LiquidScene& scene) {
  const Vector3d size = table.vector("size_m");
  const double cell = table.number("cell_m");
  liquid::GridShape& shape = scene.setup.shape;
  shape.cell_m = cell;
  int* const counts[] = {&shape.nx, &shape.ny, &shape.nz};
  double cells = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double n = size[axis] / cell;
    if (n < 1.5)
      throw InputError(table.place("cell_m"), "is too large for the box", to_text(cell), "2 cells along each edge");
    if (std::abs(n - std::round(n)) > 1e-3 * std::max(1.0, n / 100.0))
      throw InputError(table.place("size_m"), "is no whole number of cells",
                       to_text(size[axis]) + " = " + to_text(n) + " cells");
    cells *= n;
    if (cells > kMostCells)
      throw InputError(table.place("cell_m"), "makes too many cells", to_text(cell), "64 million at most");
    *counts[axis] = static_cast<int>(std::round(n));
  }
  scene.duration_s = table.number("duration_s");
  scene.imported = table.boolean("imported", false);
  scene.frame_rate_hz = table.number("frame_rate_hz", scene.frame_rate_hz);
  liquid::LiquidOptions& o = scene.setup.options;
  o.longest_step_s = table.number("longest_step_s", o.longest_step_s);
  o.cfl = table.number("cfl", o.cfl);
  o.flip_share = table.number("flip_share", o.flip_share);
  o.tension = table.boolean("tension", cell <= 0.002 * (1.0 + 1e-9));
  o.gravity_m_s2 = table.number("gravity_m_s2", o.gravity_m_s2);
  o.keep_volume = table.boolean("keep_volume", true);
}

liquid::Pool read_pool(const TomlTable& table, const LiquidScene& scene) {
  const Vector3d size = scene.setup.shape.size_m();
  liquid::Pool pool;
  if (table.has("depth_m") == (table.has("low_m") || table.has("high_m")))
    throw InputError(table.place(), "needs a depth or two corners", "", "depth_m, or low_m and high_m");
  if (table.has("depth_m")) {
    pool.low_m = Vector3d::Zero();
    pool.high_m = Vector3d(size.x(), size.y(), table.number("depth_m"));
    if (!(pool.high_m.z() < size.z()))
      throw InputError(table.place("depth_m"), "fills the box", to_text(pool.high_m.z()), "below " + to_text(size.z()));
  } else {
    pool.low_m = table.vector("low_m");
    pool.high_m = table.vector("high_m");
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = std::min(pool.high_m[axis], size[axis]) - std::max(pool.low_m[axis], 0.0);
    if (!(extent >= scene.setup.shape.cell_m * (1.0 - 1e-9)))
      throw InputError(table.place(), "the cell is larger than the pool",
                       to_text(scene.setup.shape.cell_m) + " m, pool " + to_text(extent) + " m",
                       "low_m below high_m, both in the box, cells smaller than the pool");
  }
  if (table.has("wave")) {
    const TomlTable wave = table.table("wave");
    if (!table.has("depth_m")) throw InputError(wave.place(), "needs a pool with depth_m");
    pool.wave.emplace();
    pool.wave->amplitude_m = wave.number("amplitude_m");
    const std::vector<double> n = wave.has("half_waves") ? wave.numbers("half_waves") : std::vector<double>{1.0, 0.0};
    if (n[0] != std::floor(n[0]) || n[1] != std::floor(n[1]))
      throw InputError(wave.place("half_waves"), "are no whole numbers", to_text(n[0]) + ", " + to_text(n[1]));
    pool.wave->half_waves_x = static_cast<int>(n[0]);
    pool.wave->half_waves_y = static_cast<int>(n[1]);
    const double a = std::abs(pool.wave->amplitude_m);
    if (!(a < pool.high_m.z()) || !(pool.high_m.z() + a < size.z()))
      throw InputError(wave.place("amplitude_m"), "does not fit between floor and lid", to_text(a),
                       "below " + to_text(std::min(pool.high_m.z(), size.z() - pool.high_m.z())) + " m");
  }
  return pool;
}

liquid::SolidKeys read_keys(const TomlTable& table, std::string_view key, const std::filesystem::path& base,
                            LiquidScene& scene) {
  const std::filesystem::path file = existing_file(table.text(key), table.place(key), base);
  static constexpr std::string_view kPlaces[] = {"x_m", "y_m", "z_m"};
  const bubble::TimeSeries series =
      located(table.place(key), [&] { return bubble::read_time_series(file, kPlaces, {}, false); });
  scene.key_files.push_back(file);
  liquid::SolidKeys keys;
  keys.time_s = series.times_s;
  for (std::size_t i = 0; i < series.times_s.size(); ++i)
    keys.position_m.emplace_back(series.columns[0][i], series.columns[1][i], series.columns[2][i]);
  return keys;
}

void read_motion(const TomlTable& table, const std::filesystem::path& base, liquid::Solid& solid, LiquidScene& scene) {
  const std::string motion = table.text("motion", table.has("keys_csv") ? "keys" : "fixed");
  if (motion == "fixed") {
    if (table.has("keys_csv")) throw InputError(table.place("keys_csv"), "belongs to motion = \"keys\"");
  } else if (motion == "free") {
    solid.motion = liquid::SolidMotion::kFree;
    if (solid.shape != liquid::SolidShape::kSphere)
      throw InputError(table.place("motion"), "a free solid is a sphere, it does not turn", motion, "fixed, or keys");
    if (!table.has("density_kg_m3")) throw InputError(table.place("motion"), "a free solid needs density_kg_m3");
    solid.density_kg_m3 = table.number("density_kg_m3");
    solid.velocity_m_s = table.vector("velocity_m_s", Vector3d::Zero());
  } else {
    const bool in_word = motion != "keys";
    if (in_word && !motion.ends_with(".csv"))
      throw InputError(table.place("motion"), "unknown motion", motion, "fixed, free, keys, or a .csv file");
    if (!in_word && !table.has("keys_csv")) throw InputError(table.place("motion"), "keys need a file", "", "keys_csv");
    solid.motion = liquid::SolidMotion::kKeys;
    solid.keys = read_keys(table, in_word ? "motion" : "keys_csv", base, scene);
    solid.position_m = solid.keys.position_at(0.0);
  }
}

liquid::Solid read_solid(const TomlTable& table, std::size_t number, const std::filesystem::path& base,
                         LiquidScene& scene) {
  liquid::Solid solid;
  solid.name = table.text("name", "solid " + std::to_string(number));
  if (!table.has("shape")) throw InputError(table.place("shape"), "is missing");
  const TomlTable shape = table.table("shape");
  const std::string kind = shape.text("kind");
  if (kind == "sphere") {
    solid.shape = liquid::SolidShape::kSphere;
    solid.radius_m = shape.number("radius_m");
  } else if (kind == "box") {
    solid.shape = liquid::SolidShape::kBox;
    solid.size_m = shape.vector("size_m");
    if (!(solid.size_m.minCoeff() > 0.0))
      throw InputError(shape.place("size_m"), "has no volume", words(solid.size_m), "above 0");
  } else if (kind == "half_space") {
    solid.shape = liquid::SolidShape::kHalfSpace;
    solid.normal = shape.vector("normal");
    if (!(solid.normal.norm() > 0.0)) throw InputError(shape.place("normal"), "has no direction", words(solid.normal));
    solid.normal.normalize();
  } else {
    throw InputError(shape.place("kind"), "unknown shape", kind, "sphere, box, half_space");
  }
  solid.position_m = table.vector("position_m");
  read_motion(table, base, solid, scene);
  if (solid.is_outside(scene.setup.shape.size_m()))
    throw InputError(table.place("position_m"), solid.name + " lies wholly outside the box", words(solid.position_m),
                     "some of it within " + within(scene.setup.shape.size_m()));
  return solid;
}

/// Where the rim of an inlet runs.
std::vector<Vector3d> rim(const liquid::Inlet& inlet) {
  std::vector<Vector3d> points{inlet.position_m};
  const int along = static_cast<int>(std::distance(
      inlet.direction.data(), std::max_element(inlet.direction.data(), inlet.direction.data() + 3,
                                               [](double a, double b) { return std::abs(a) < std::abs(b); })));
  const int a = (along + 1) % 3, b = (along + 2) % 3;
  for (int c = 0; c < 16; ++c) {
    Vector3d x = inlet.position_m;
    const double angle = 2.0 * 3.14159265358979 * c / 16;
    const double half_a = inlet.radius_m ? *inlet.radius_m : 0.5 * inlet.size_m[a],
                 half_b = inlet.radius_m ? *inlet.radius_m : 0.5 * inlet.size_m[b];
    x[a] += half_a * std::cos(angle);
    x[b] += half_b * std::sin(angle);
    points.push_back(x);
  }
  return points;
}

liquid::Inlet read_inlet(const TomlTable& table, const LiquidScene& scene) {
  liquid::Inlet inlet;
  if (!table.has("shape")) throw InputError(table.place("shape"), "is missing");
  const TomlTable shape = table.table("shape");
  inlet.position_m = table.vector("position_m");
  inlet.direction = table.vector("direction", -Vector3d::UnitZ());
  if (std::abs(inlet.direction.cwiseAbs().sum() - 1.0) > 1e-12 || std::abs(inlet.direction.norm() - 1.0) > 1e-12)
    throw InputError(table.place("direction"), "does not run along an axis", words(inlet.direction), "as [0, 0, -1]");
  const std::string kind = shape.text("kind");
  if (kind == "disc") {
    inlet.radius_m = shape.number("radius_m");
  } else if (kind == "rectangle") {
    inlet.size_m = shape.vector("size_m");
    for (int axis = 0; axis < 3; ++axis)
      if ((std::abs(inlet.direction[axis]) > 0.5) != (inlet.size_m[axis] == 0.0))
        throw InputError(shape.place("size_m"), "is no rectangle across the flow", words(inlet.size_m),
                         "0 along the flow, more across it");
  } else {
    throw InputError(shape.place("kind"), "unknown shape", kind, "disc, rectangle");
  }
  inlet.speed_m_s = table.number("speed_m_s");
  inlet.start_s = table.number("start_s", 0.0);
  const double flow_l_s = 1e3 * inlet.area_m2() * inlet.speed_m_s;
  if (const auto asked = table.optional_number("flow_l_s"); asked && !(std::abs(*asked / flow_l_s - 1.0) <= 0.01))
    throw InputError(table.place("flow_l_s"), "is not area times speed", to_text(*asked),
                     to_text(flow_l_s) + " within 1 %");
  const Vector3d size = scene.setup.shape.size_m();
  const double cell = scene.setup.shape.cell_m;
  for (const Vector3d& x : rim(inlet)) {
    const Vector3d ahead = x + cell * inlet.direction;
    if ((x.array() < -1e-9).any() || (x.array() > size.array() + 1e-9).any() || (ahead.array() < 0.0).any() ||
        (ahead.array() > size.array()).any())
      throw InputError(table.place("position_m"), "the inlet runs into a wall of the box", words(x));
    for (const liquid::Solid& solid : scene.setup.solids)
      if (solid.distance_m(x) < 0.0 || solid.distance_m(ahead) < 0.0)
        throw InputError(table.place("position_m"), "the inlet runs into " + solid.name, words(x));
  }
  return inlet;
}

void check_box(const TomlTable& table, const Vector3d& low, const Vector3d& high, const Vector3d& size) {
  if (!(low.array() < high.array()).all() || (high.array() <= 0.0).any() || (low.array() >= size.array()).any())
    throw InputError(table.place("low_m"), "is no box in the domain", words(low) + " to " + words(high));
}

void read_radii(const TomlTable& table, const std::filesystem::path& base, EntrainmentTable& e) {
  const std::string kind = table.choice("kind", {"deane_stokes", "gaussian", "recording"});
  e.radii = kind == "deane_stokes" ? RadiusKind::kDeaneStokes
            : kind == "gaussian"   ? RadiusKind::kGaussian
                                   : RadiusKind::kRecording;
  e.smallest_m = table.number("smallest_m", e.smallest_m);
  e.largest_m = table.number("largest_m", e.largest_m);
  if (!(e.smallest_m < e.largest_m))
    throw InputError(table.place("smallest_m"), "is not below largest_m", to_text(e.smallest_m),
                     "below " + to_text(e.largest_m));
  e.mean_m = table.optional_number("mean_m");
  e.std_m = table.optional_number("std_m");
  if (int{e.mean_m.has_value()} + int{e.std_m.has_value()} != (kind == "gaussian" ? 2 : 0))
    throw InputError(table.place("kind"), "mean_m and std_m belong to a gaussian", kind);
  if (kind == "recording") {
    e.recording = existing_file(table.text("file"), table.place("file"), base);
    const std::vector<double> radii = recorded_radii(e.recording);  // said before the flow, which takes long
    if (std::none_of(radii.begin(), radii.end(), [&](double r) { return r >= e.smallest_m && r <= e.largest_m; }))
      throw InputError(table.place("file"), "has no radius within smallest_m to largest_m",
                       to_text(*std::min_element(radii.begin(), radii.end())) + " to " +
                           to_text(*std::max_element(radii.begin(), radii.end())) + " m",
                       to_text(e.smallest_m) + " to " + to_text(e.largest_m) + " m");
  } else if (table.has("file")) {
    throw InputError(table.place("file"), "belongs to radii of a recording", kind);
  }
}

void read_entrainment(const TomlTable& table, const std::filesystem::path& base, LiquidScene& scene) {
  EntrainmentTable& e = scene.entrainment;
  e.given = true;
  e.attempts_per_m2_s = table.number("attempts_per_m2_s");
  e.seed_life_s = table.number("seed_life_s", e.seed_life_s);
  e.window_s = table.number("window_s", e.window_s);
  e.threshold_m_s = table.number("threshold_m_s", e.threshold_m_s);
  e.coverage = table.number("coverage", e.coverage);
  e.consume = table.boolean("consume", e.consume);
  e.criterion = table.choice("criterion", {"slope", "velocity"});
  e.literature = table.choice("literature", {"mended", "paper"});
  e.drag = table.choice("drag", {"contaminated", "clean", "paper"});
  if (table.has("radii")) read_radii(table.table("radii"), base, e);
  for (const TomlTable& patch : table.tables("patch", kMostThings)) {
    SeedPatch p{patch.vector("low_m"), patch.vector("high_m"), patch.number("start_s", 0.0),
                patch.number("end_s", scene.duration_s)};
    check_box(patch, p.low_m, p.high_m, scene.setup.shape.size_m());
    if (!(p.start_s < p.end_s)) throw InputError(patch.place("start_s"), "is not before end_s", to_text(p.start_s));
    e.patches.push_back(p);
  }
}

void read_liquid(const TomlTable& root, const std::filesystem::path& base, LiquidScene& scene) {
  const Vector3d size = scene.setup.shape.size_m();
  liquid::LiquidSetup& setup = scene.setup;
  for (const TomlTable& pool : root.tables("pool", kMostThings)) setup.pools.push_back(read_pool(pool, scene));
  for (const TomlTable& table : root.tables("drop", kMostThings)) {
    const liquid::Drop drop{table.number("radius_m"), table.vector("position_m"),
                            table.vector("velocity_m_s", Vector3d::Zero())};
    if ((drop.position_m.array() < 0.0).any() || (drop.position_m.array() > size.array()).any())
      throw InputError(table.place("position_m"), "lies outside the box", words(drop.position_m), within(size));
    if (drop.radius_m < setup.shape.cell_m)
      throw InputError(table.place("radius_m"), "the cell is larger than the drop's radius", to_text(drop.radius_m),
                       "from domain.cell_m = " + to_text(setup.shape.cell_m) + " m on");
    setup.drops.push_back(drop);
  }
  std::size_t number = 1;
  for (const TomlTable& solid : root.tables("solid", kMostThings))
    setup.solids.push_back(read_solid(solid, number++, base, scene));
  for (const TomlTable& inlet : root.tables("inlet", kMostThings)) setup.inlets.push_back(read_inlet(inlet, scene));
  for (const TomlTable& outlet : root.tables("outlet", kMostThings)) {
    setup.outlets.push_back({outlet.vector("low_m"), outlet.vector("high_m")});
    check_box(outlet, setup.outlets.back().low_m, setup.outlets.back().high_m, size);
  }
  if (!scene.imported && setup.pools.empty() && setup.drops.empty() && setup.inlets.empty())
    throw InputError(root.place(), "there is no liquid", "", "[[pool]], [[drop]] or [[inlet]]");
}

}  // namespace

LiquidScene parse_liquid_scene(std::string_view toml, const std::string& name, const std::filesystem::path& base) {
  const TomlTable root = TomlTable::parse(toml, name, schema());
  LiquidScene scene;
  scene.file = base / name;
  scene.name = root.text("name", std::filesystem::path(name).stem().string());
  if (!root.has("domain")) throw InputError(root.place("domain"), "is missing");
  static constexpr std::string_view kFlow[] = {"domain", "pool", "drop", "inlet", "outlet", "solid", "liquid"};
  static constexpr std::string_view kBubbles[] = {"bubble", "entrainment", "gas", "pitch", "sound"};
  scene.flow_text = toml_normal_form(toml, kFlow);
  scene.bubbles_text = scene.flow_text + toml_normal_form(toml, kBubbles);
  read_domain(root.table("domain"), scene);
  stage::read_bubble_settings(root, base, scene.sound);
  scene.sound.name = scene.name;
  scene.setup.options.density_kg_m3 = scene.sound.medium.liquid_density_kg_m3;
  scene.setup.options.surface_tension_n_m = scene.sound.medium.surface_tension_n_m;
  read_liquid(root, base, scene);
  if (root.has("entrainment")) read_entrainment(root.table("entrainment"), base, scene);
  const Vector3d size = scene.setup.shape.size_m();
  for (const TomlTable& table : root.tables("bubble", kMostBubbles)) {
    const ScriptedBubble bubble{table.number("radius_m"), table.number("birth_s", 0.0), table.vector("position_m")};
    if ((bubble.position_m.array() < 0.0).any() || (bubble.position_m.array() > size.array()).any())
      throw InputError(table.place("position_m"), "lies outside the box", words(bubble.position_m), within(size));
    for (const liquid::Solid& solid : scene.setup.solids)
      if (!solid.moves() && solid.distance_m(bubble.position_m) < 0.0)
        throw InputError(table.place("position_m"), "is in the solid " + solid.name, words(bubble.position_m));
    scene.bubbles.push_back(bubble);
  }
  const TomlTable transfer = root.table("transfer");
  scene.transfer.method =
      *enum_from_text<TransferMethod>(transfer.choice("method", {"reciprocal", "forward", "half_space", "unit"}));
  scene.transfer.bins_per_octave = static_cast<int>(std::lround(transfer.number("bins_per_octave", 6.0)));
  scene.transfer.liquid_loss_factor = transfer.number("liquid_loss_factor", scene.transfer.liquid_loss_factor);
  scene.transfer.wall_admittance = transfer.number("wall_admittance", scene.transfer.wall_admittance);
  const TomlTable pitch = root.table("pitch");
  if (pitch.has("from")) {
    for (const char* const key : {"k_delta_per_m", "eta"})
      if (pitch.has(key)) throw InputError(pitch.place(key), "comes from the recording where from is given");
    scene.pitch_from = existing_file(pitch.text("from"), pitch.place("from"), base);
    take_recorded_pitch(scene.pitch_from, scene.sound.pitch);
  }
  return scene;
}

LiquidScene read_liquid_scene(const std::filesystem::path& toml) {
  LiquidScene scene =
      parse_liquid_scene(read_file(toml, std::size_t{64} << 20), toml.filename().string(), toml.parent_path());
  scene.file = toml;
  return scene;
}

bool is_liquid_scene(std::string_view toml) {
  for (std::size_t at = 0; at < toml.size();) {
    const std::size_t end = std::min(toml.find('\n', at), toml.size());
    std::string line(toml.substr(at, end - at));
    line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == ' ' || c == '\t' || c == '\r'; }),
               line.end());
    if (line.starts_with("[domain]") || line.starts_with("domain={") || line.starts_with("domain.")) return true;
    at = end + 1;
  }
  return false;
}

std::string liquid_scene_schema_markdown() { return toml_schema_markdown(schema()); }

std::vector<std::filesystem::path> LiquidScene::inputs() const {
  std::vector<std::filesystem::path> files{file};
  for (const std::filesystem::path& path : key_files) files.push_back(path);
  for (const std::filesystem::path& path : {entrainment.recording, pitch_from})
    if (!path.empty()) files.push_back(path);
  return files;
}

std::size_t LiquidScene::n_frames() const {
  return static_cast<std::size_t>(std::floor(duration_s * frame_rate_hz + 1e-9)) + 1;
}

}  // namespace klang::liquid_scene
