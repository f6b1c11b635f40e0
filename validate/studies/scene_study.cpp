#include <array>
#include <cmath>
#include <functional>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/solid/statics.hpp"
#include "core/sound/scene/scene_motion.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace scene_levels {
namespace {

using Eigen::Vector3d;

constexpr double kGravity_m_s2 = 9.81;

rigid::Skin skin(double restitution, double friction) {
  rigid::Skin s;
  s.restitution = restitution;
  s.friction = friction;
  return s;
}

rigid::RigidWorldOptions world_options(double rate_hz, const rigid::Skin& floor) {
  rigid::RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.floor = floor;
  return options;
}

struct SeriesWords {
  const char *id, *title, *reference, *steps, *error;
};

Series series_of(const SeriesWords& words, double order, double error_tolerance) {
  Series series;
  series.id = words.id;
  series.title = words.title;
  series.reference = words.reference;
  series.step_words = words.steps;
  series.error_words = words.error;
  series.expected_order = order;
  series.error_tolerance = error_tolerance;
  return series;
}

/// A value and what it should be.
struct Found {
  double value = 0.0, exact = 0.0, error = 0.0, n_unknowns = 0.0;
};

template <std::size_t N>
void add_levels(Series& series, const std::array<double, N>& steps, bool metres, const StudyOptions& options,
                Monitor& monitor, const std::function<Found(double)>& find) {
  const std::size_t n = level_count(options, N);
  // Stated for the finest of all levels.
  if (series.kind == Convergence::kAlgebraic)
    series.error_tolerance *=
        std::pow(std::max(steps[n - 1] / steps[N - 1], steps[N - 1] / steps[n - 1]), series.expected_order);
  if (series.kind == Convergence::kGeometric)
    series.error_tolerance *= std::exp(series.expected_order * (steps[N - 1] - steps[n - 1]));
  for (std::size_t i = 0; i < n; ++i) {
    monitor.throw_if_stopped();
    monitor.progress(series.id, static_cast<double>(i) / static_cast<double>(n));
    const Stopwatch watch;
    const Found found = find(steps[i]);
    Level level;
    (metres ? level.h_m : level.n) = steps[i];
    level.value = found.value;
    level.exact = found.exact;
    level.error = found.error;
    level.n_unknowns = found.n_unknowns;
    level.wall_time_s = watch.seconds();
    series.levels.push_back(level);
  }
}

// ---- Mesh: a free bar that is pushed at one end ----

constexpr double kBarLength_m = 0.04, kBarWidth_m = 0.01, kForce_n = 100.0, kYoung_pa = 62e9;

/// Without Poisson effect: tests/reference/quasistatic.json, free_bar_end_push.
Found pushed_bar(double edge_m, int order) {
  const int n = static_cast<int>(std::lround(kBarWidth_m / edge_m));
  const mesh::ShapeSpec spec{
      "box", {{"length_m", kBarLength_m}, {"width_m", kBarWidth_m}, {"height_m", kBarWidth_m}}, {}};
  mesh::TetMesh bar = mesh::mesh_shape(spec, mesh::ShapeDivisions{{4 * n, n, n}}, 2);
  if (order == 1) bar = mesh::to_linear(bar);
  const double area_m2 = kBarWidth_m * kBarWidth_m;
  const Eigen::VectorXd force = solid::traction_force_n(bar, [&](const Vector3d&, const Vector3d& normal) -> Vector3d {
    return normal[0] < -0.5 ? Vector3d(kForce_n / area_m2, 0, 0) : Vector3d(0, 0, 0);
  });
  const double n_unknowns = 3.0 * static_cast<double>(bar.nodes_m.rows());
  fracture::FreeBodySolver solver(std::move(bar), solid::from_youngs_modulus(kYoung_pa, 0.0, 2600.0));
  if (!solver.usable()) throw NumericalError("converge scene: " + solver.message());
  const double exact = kForce_n * kForce_n * kBarLength_m / (6.0 * kYoung_pa * area_m2);
  const double value = solver.solve(force).strain_energy_j[0];
  return {value, exact, std::abs(value / exact - 1.0), n_unknowns};
}

// ---- Steps: motion ----

/// A thin rod without friction that falls while it turns, and lands on one end: angular velocity after the impact.
struct FallingRod {
  double mass_kg = 0.05, half_m = 0.1, spin_rad_s = 4.0, angle_rad = 0.3, restitution = 0.5;
  double inertia_kg_m2() const { return mass_kg * half_m * half_m / 3.0; }
  double lowest_m(double height_m, double t) const {
    return height_m - 0.5 * kGravity_m_s2 * t * t - half_m * std::abs(std::sin(angle_rad + spin_rad_s * t));
  }
  /// Closed form at the moment of touch: J = -(1 + e) u / (1/m + arm^2/I).
  double spin_after(double height_m) const {
    double before = 0.0, after = 0.0;
    while (lowest_m(height_m, after) > 0.0) after += 1e-3;
    before = after - 1e-3;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (before + after);
      (lowest_m(height_m, middle) > 0.0 ? before : after) = middle;
    }
    const double angle = angle_rad + spin_rad_s * after;
    const double arm = (std::sin(angle) > 0.0 ? -1.0 : 1.0) * half_m * std::cos(angle);
    const double approach = -kGravity_m_s2 * after + spin_rad_s * arm;
    const double impulse = -(1.0 + restitution) * approach / (1.0 / mass_kg + arm * arm / inertia_kg_m2());
    return spin_rad_s + impulse * arm / inertia_kg_m2();
  }
  double simulated(double height_m, double rate_hz) const {
    rigid::RigidBodySpec rod;
    rod.name = "rod";
    rod.mass_kg = mass_kg;
    rod.inertia_kg_m2 = Vector3d(1e-12, inertia_kg_m2(), inertia_kg_m2()).asDiagonal();
    rigid::ConvexPart part;
    part.corners_m.resize(3, 2);
    part.corners_m << -half_m, half_m, 0, 0, 0, 0;
    rod.parts.push_back(part);
    rod.skin = skin(restitution, 0.0);
    rod.position_m = Vector3d(0, 0, height_m);
    rod.orientation = Eigen::AngleAxisd(angle_rad, -Vector3d::UnitY());
    rod.angular_velocity_rad_s = -spin_rad_s * Vector3d::UnitY();
    rigid::RigidWorld world(world_options(rate_hz, rod.skin));
    world.add(rod);
    while (world.time_s() < 1.0)
      if (!world.step().contacts.empty()) return -world.angular_velocity_rad_s(0).y();
    return std::nan("");
  }
};

/// Root mean square over heights, for which the rod touches at different phases of the step.
Found landing(double rate_hz) {
  constexpr int kHeights = 16;
  const FallingRod rod;
  Found found;
  double sum = 0.0;
  for (int i = 0; i < kHeights; ++i) {
    const double height_m = 0.3 + 0.02 * i / kHeights;
    const double exact = rod.spin_after(height_m), value = rod.simulated(height_m, rate_hz);
    if (i == 0) found = {value, exact, 0.0, rate_hz};
    sum += std::pow(value / exact - 1.0, 2);
  }
  found.error = std::sqrt(sum / kHeights);
  return found;
}

/// A block tips over an edge from rest: 4 R theta'' = 3 g sin(theta), theta the angle of the diagonal (half R) from upright. How far it
/// has turned after 0.2 s.
Found tipping(double rate_hz) {
  constexpr double kWidth = 0.05, kHeight = 0.1, kTilt = 0.6, kUntil_s = 0.2;
  const double half = 0.5 * std::hypot(kWidth, kHeight), upright = std::atan(kWidth / kHeight);
  const auto pull = [&](double theta) { return 0.75 * kGravity_m_s2 / half * std::sin(theta); };
  double theta = kTilt - upright, speed = 0.0;
  constexpr int kSteps = 4000;  // of Runge and Kutta: error below 1e-14
  for (int i = 0; i < kSteps; ++i) {
    const double dt = kUntil_s / kSteps;
    const double k1 = speed, l1 = pull(theta);
    const double k2 = speed + 0.5 * dt * l1, l2 = pull(theta + 0.5 * dt * k1);
    const double k3 = speed + 0.5 * dt * l2, l3 = pull(theta + 0.5 * dt * k2);
    const double k4 = speed + dt * l3, l4 = pull(theta + dt * k3);
    theta += dt / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4);
    speed += dt / 6.0 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  const rigid::Skin rough = skin(0.0, 1.0);
  rigid::RigidWorld world(world_options(rate_hz, rough));
  rigid::RigidBodySpec block = rigid::cuboid("block", {kWidth, 0.08, kHeight}, 0.5);
  block.skin = rough;
  block.orientation = Eigen::AngleAxisd(kTilt, Vector3d::UnitY());
  block.position_m = Vector3d(0, 0, half * std::cos(kTilt - upright));
  world.add(block);
  for (long i = std::lround(kUntil_s * rate_hz); i > 0; --i) world.step();
  const Eigen::Matrix3d turn = world.pose(0).orientation().toRotationMatrix();
  const double value = std::atan2(turn(0, 2), turn(2, 2)) - kTilt, exact = theta + upright - kTilt;
  return {value, exact, std::abs(value / exact - 1.0), kUntil_s * rate_hz};
}

/// A free body with three different moments of inertia: its angular velocity in its own axes after 1 s.
Found tumbling(double rate_hz) {
  const Vector3d exact(-9.249002832728621, 3.8034124940871097, 9.756093026067045);
  rigid::RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.gravity_m_s2.setZero();
  rigid::RigidWorld world(options);
  rigid::RigidBodySpec top = rigid::ball("top", 0.01, 0.1);
  top.inertia_kg_m2 = Vector3d(1e-5, 2e-5, 3e-5).asDiagonal();
  top.angular_velocity_rad_s = Vector3d(10, 0.1, 10);
  world.add(top);
  for (long i = std::lround(rate_hz); i > 0; --i) world.step();
  const Vector3d spin = world.pose(0).orientation().conjugate() * world.angular_velocity_rad_s(0);
  return {spin.x(), exact.x(), (spin - exact).norm() / exact.norm(), rate_hz};
}

/// Ten balls on each other: what the floor carries in the very first step, over their weight.
Found column(double sweeps) {
  constexpr int kBalls = 10;
  constexpr double kMass_kg = 0.05, kRadius_m = 0.01, kRate_hz = 1000.0;
  rigid::RigidWorldOptions options = world_options(kRate_hz, skin(0.0, 0.0));
  options.iterations = static_cast<int>(sweeps);
  rigid::RigidWorld world(options);
  for (int i = 0; i < kBalls; ++i) {
    rigid::RigidBodySpec ball = rigid::ball("ball", kRadius_m, kMass_kg);
    ball.skin = *options.floor;
    ball.position_m = Vector3d(0, 0, (2 * i + 1) * kRadius_m);
    world.add(ball);
  }
  double carried = 0.0;
  for (const rigid::ContactImpulse& contact : world.step().contacts)
    if (contact.b == rigid::kFloor) carried += contact.impulse_n_s.z();
  const double share = carried / (kBalls * kMass_kg * kGravity_m_s2 / kRate_hz);
  return {share, 1.0, std::abs(share - 1.0), sweeps};
}

// ---- Steps and mesh: a tile that breaks ----

constexpr const char* kTile = R"(
duration_s = 0.36
[world.floor]
material = "stone"
[[material]]
name = "tile"
youngs_modulus_pa = 7.2e10
poissons_ratio = 0.19
density_kg_m3 = 2700
restitution = 0.4
friction = 0.4
tensile_strength_pa = 10e6
fracture_energy_j_m2 = 50
damping = { model = "loss_factor", loss_factor = 1e-3 }
[[material]]
name = "stone"
youngs_modulus_pa = 30e9
poissons_ratio = 0.2
density_kg_m3 = 2400
restitution = 0.4
friction = 0.6
[[body]]
name = "tile"
shape = { kind = "box", length_m = 0.1, width_m = 0.1, height_m = 0.008 }
material = "tile"
model = "breakable"
stress_edge_m = 0.02
position_m = [0, 0, 0.61]
rotation_deg = [8, 25, 0]
)";

struct BrokenTile {
  double break_s = std::nan(""), hertz_s = 0.0, strain_j = std::nan(""), fracture_j = std::nan("");
  int n_pieces = 0;
};

BrokenTile broken_tile(double rate_hz, double stress_edge_m, Monitor& monitor) {
  scene::Scene tile = scene::parse_scene(kTile, "converge-scene.toml");
  tile.solver.rate_hz = rate_hz;
  tile.bodies[0].stress_edge_m = stress_edge_m;
  const scene::SceneMotion motion = scene::move(tile, {}, 1, {}, monitor);
  BrokenTile out;
  for (const events::Impulse& impulse : motion.log.impulses)
    if (impulse.body == 0 && impulse.kind == events::ImpulseKind::kImpact) out.hertz_s = impulse.duration_s;
  if (motion.breaks.empty()) return out;
  const scene::BreakEvent& event = motion.breaks[0];
  out.break_s = event.time_s;
  out.strain_j = event.energies.strain_j;
  out.fracture_j = event.energies.fracture_j;
  out.n_pieces = event.n_pieces;
  return out;
}

/// When its lowest corner touches after free fall from rest.
double touch_s() {
  const Eigen::Matrix3d turn = scene::orientation_of({8, 25, 0}).toRotationMatrix();
  const double low_m = 0.61 - turn.row(2).cwiseAbs().dot(Eigen::RowVector3d(0.05, 0.05, 0.004));
  return std::sqrt(2.0 * low_m / kGravity_m_s2);
}

void add_breaking(Study& study, const StudyOptions& options, Monitor& monitor) {
  Series series =
      series_of({"step-break", "Energy of the cracks of a tile that is dropped on its corner",
                 "the same at 2500 steps per second", "steps per second", "relative difference of the cracks' energy"},
                0.0, 1e-9);
  if (!wanted(options, series.id)) return;
  series.kind = Convergence::kRoundOff;
  constexpr double kEdge_m = 0.02;
  const BrokenTile first = broken_tile(2500.0, kEdge_m, monitor);
  double earliest = first.break_s, latest = first.break_s;
  int fewest = first.n_pieces, most = first.n_pieces;
  add_levels(series, std::array{5000.0, 10000.0, 20000.0, 40000.0}, false, options, monitor, [&](double rate_hz) {
    const BrokenTile tile = broken_tile(rate_hz, kEdge_m, monitor);
    earliest = std::min(earliest, tile.break_s);
    latest = std::max(latest, tile.break_s);
    fewest = std::min(fewest, tile.n_pieces);
    most = std::max(most, tile.n_pieces);
    return Found{tile.fracture_j, first.fracture_j, std::abs(tile.fracture_j / first.fracture_j - 1.0), rate_hz};
  });
  study.series.push_back(std::move(series));
  study.claims.push_back(judged({"step-break.time-spread",
                                 "latest less earliest first break at all rates [s]",
                                 latest - earliest,
                                 {},
                                 1e-9,
                                 {},
                                 false}));
  study.claims.push_back(judged({"step-break.after-touch",
                                 "first break, less the fall's closed form and half of Hertz' contact time [s]",
                                 first.break_s - touch_s() - 0.5 * first.hertz_s,
                                 {},
                                 1e-9,
                                 {},
                                 false}));
  study.claims.push_back(judged({"step-break.pieces",
                                 "pieces at every rate, most less fewest",
                                 static_cast<double>(most - fewest),
                                 0.0,
                                 0.0,
                                 {},
                                 false}));
}

void add_mesh(Study& study, const StudyOptions& options, Monitor& monitor) {
  Series linear = series_of({"mesh-bar", "Strain energy of a free bar pushed at its end, linear elements",
                             "F^2 L / (6 E A)", "element size [m]", "relative error of the strain energy"},
                            2.0, 1e-3);
  if (wanted(options, linear.id)) {
    add_levels(linear, std::array{5e-3, 2.5e-3, 1.25e-3, 0.625e-3}, true, options, monitor,
               [](double edge_m) { return pushed_bar(edge_m, 1); });
    study.series.push_back(std::move(linear));
  }
  Series quadratic =
      series_of({"mesh-quadratic", "The same, quadratic elements: the stress is linear, which they hold exactly",
                 "F^2 L / (6 E A)", "element size [m]", "relative error of the strain energy"},
                0.0, 1e-9);
  quadratic.kind = Convergence::kRoundOff;
  if (wanted(options, quadratic.id)) {
    add_levels(quadratic, std::array{1e-2, 5e-3, 2.5e-3, 1.25e-3}, true, options, monitor,
               [](double edge_m) { return pushed_bar(edge_m, 2); });
    study.series.push_back(std::move(quadratic));
  }
}

void add_motion(Study& study, const StudyOptions& options, Monitor& monitor) {
  constexpr std::array kRates{500.0, 1000.0, 2000.0, 4000.0, 8000.0};
  const auto add = [&](Series series, const auto& steps, const std::function<Found(double)>& find) {
    if (!wanted(options, series.id)) return;
    add_levels(series, steps, false, options, monitor, find);
    study.series.push_back(std::move(series));
  };
  Series touch = series_of({"step-landing", "A turning rod that lands on its end", "closed form at the moment of touch",
                            "steps per second", "relative error of the angular velocity after the impact, 16 heights"},
                           0.0, 1e-9);
  touch.kind = Convergence::kRoundOff;
  add(std::move(touch), kRates, landing);
  add(series_of({"step-tipping", "A block that tips over an edge", "equation of motion, to 1e-14", "steps per second",
                 "relative error of the angle after 0.2 s"},
                1.0, 5e-3),
      kRates, tipping);
  add(series_of({"step-tumbling", "A body that turns freely about no axis of its own",
                 "ODE to 12 digits (tests/reference/contact.json, free_top)", "steps per second",
                 "relative error of the angular velocity after 1 s"},
                4.0, 1e-9),
      std::array{100.0, 200.0, 400.0, 800.0}, tumbling);
}

/// The same by Gauss and Seidel's sweeps, upward, over (2 on the diagonal, 1 at the floor; -1 beside it) J = g dt: each ball's floor.
double swept_column(int sweeps) {
  constexpr int kBalls = 10;
  std::array<double, kBalls + 1> carried{};  // over the weight of one ball; above the last: none
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    carried[0] = 1.0 + carried[1];
    // Two balls that fall alike bring each other nothing: what is between them is the mean of what is below and above.
    for (std::size_t i = 1; i < kBalls; ++i) carried[i] = 0.5 * (carried[i - 1] + carried[i + 1]);
  }
  return carried[0] / kBalls;
}

void add_sweeps(Study& study, const StudyOptions& options, Monitor& monitor) {
  Series series =
      series_of({"iterations-column", "What the floor carries in the first step of a column of ten balls",
                 "Gauss and Seidel's sweeps over the chain, written down apart",
                 "sweeps over the contacts, before outcomes are mixed", "difference of the shares of the weight"},
                0.0, 1e-12);
  if (!wanted(options, series.id)) return;
  series.kind = Convergence::kRoundOff;
  add_levels(series, std::array{2.0, 4.0, 8.0, 11.0}, false, options, monitor, [](double sweeps) {
    const Found found = column(sweeps);
    const double swept = swept_column(static_cast<int>(sweeps));
    return Found{found.value, swept, std::abs(found.value - swept), sweeps};
  });
  study.series.push_back(std::move(series));
  // Sweeps alone are off by a quarter there; of a linear problem with ten unknowns mixing needs at most eleven outcomes.
  study.claims.push_back(judged({"iterations-column.mixed",
                                 "what the floor carries after 48 sweeps, less the weight, over it",
                                 column(48.0).value - 1.0,
                                 {},
                                 1e-6,
                                 {},
                                 false}));
}

}  // namespace
}  // namespace scene_levels

/// What a scene of rigid and breaking bodies owes to its steps, its mesh and the sweeps over its contacts.
Study scene_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Scenes that move and break";
  study.question =
      "How do motion, strain and breakage of a scene depend on its steps per second, on the mesh for stress and on the "
      "sweeps over lasting contacts?";
  scene_levels::add_mesh(study, options, monitor);
  scene_levels::add_motion(study, options, monitor);
  scene_levels::add_breaking(study, options, monitor);
  scene_levels::add_sweeps(study, options, monitor);
  return study;
}

}  // namespace klang::validate
