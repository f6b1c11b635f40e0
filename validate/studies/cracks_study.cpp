#include <array>
#include <cmath>

#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/fracture/dynamic/cracker.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using Eigen::Vector3d;

constexpr double kBarLength_m = 0.3, kBarWidth_m = 0.1;

/// A bar of 3 n x n x n cells of six tetrahedra.
mesh::TetMesh bar_of_cells(int n) {
  mesh::TetMesh mesh;
  const std::array<int, 3> cells = {3 * n, n, n};
  const auto number = [&](int i, int j, int k) { return (i * (n + 1) + j) * (n + 1) + k; };
  mesh.nodes_m.resize((3 * n + 1) * (n + 1) * (n + 1), 3);
  for (int i = 0; i <= cells[0]; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k)
        mesh.nodes_m.row(number(i, j, k)) << kBarLength_m * i / cells[0], kBarWidth_m * j / n, kBarWidth_m * k / n;
  constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  mesh.elements.resize(6 * 3 * n * n * n, 4);
  int row = 0;
  for (int i = 0; i < cells[0]; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        for (std::size_t order = 0; order < 6; ++order) {
          std::array<int, 3> at = {i, j, k};
          std::array<int, 4> nodes = {number(i, j, k), 0, 0, 0};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(kOrders[order][step])];
            nodes[step + 1] = number(at[0], at[1], at[2]);
          }
          if (order >= 3) std::swap(nodes[2], nodes[3]);
          mesh.elements.row(row++) << nodes[0], nodes[1], nodes[2], nodes[3];
        }
  return mesh;
}

fracture::SolidOptions rubber() {
  fracture::SolidOptions options;
  options.material.lame_lambda_pa = options.material.lame_mu_pa = 4e6;
  options.material.density_kg_m3 = 1000.0;
  options.viscosity_mu_pa_s = options.viscosity_lambda_pa_s = 400.0;
  return options;
}

/// A bar that is drawn apart steadily; what its ledger lacks at most, over the work.
fracture::ExplicitSolid drawn_bar(int cells, double speed_m_s) {
  const fracture::SolidOptions options = rubber();
  fracture::CrackMesh mesh(bar_of_cells(cells), options.material.density_kg_m3);
  for (std::size_t i = 0; i < mesh.rest_m.size(); ++i) {
    const double x = mesh.rest_m[i].x();
    if (x < 1e-9) mesh.held[i] = 0;
    if (x > kBarLength_m - 1e-9) mesh.held[i] = 1;
    mesh.velocity_m_s[i].x() = speed_m_s * x / kBarLength_m;
  }
  std::vector<fracture::HoldPath> holds(2);
  holds[1] = fracture::HoldPath(fracture::HoldKind::kVelocity, {{0.0, Vector3d(speed_m_s, 0, 0)}});
  return {std::move(mesh), options, std::move(holds)};
}

double ledger_lacks(double share, const Monitor& monitor) {
  fracture::ExplicitSolid solid = drawn_bar(2, 1.0);
  const double dt = share * solid.step_limit_s(), start = solid.energies().sum_j();
  double worst = 0.0, work = 0.0;
  while (solid.time_s() < 0.01) {
    monitor.throw_if_stopped();
    solid.step(dt);
    worst = std::max(worst, std::abs(solid.energies().sum_j() - start));
    work = std::max(work, solid.energies().work_j);
  }
  return worst / work;
}

/// Stress at which the first node parts, over the strength.
double first_break(int cells, const Monitor& monitor) {
  fracture::ExplicitSolid solid = drawn_bar(cells, 0.1);
  fracture::CrackOptions crack;
  crack.strength_pa = 1e5;
  fracture::Cracker cracker(solid, crack);
  while (solid.time_s() < 0.06 && cracker.n_splits() == 0) {
    monitor.throw_if_stopped();
    solid.step(solid.step_limit_s());
    cracker.open(solid);
  }
  // Strain that was drawn, times Young's modulus.
  return 1e7 * 0.1 * solid.time_s() / kBarLength_m / *crack.strength_pa;
}

}  // namespace

/// A bar that is drawn apart: its ledger, and when it breaks.
Study cracks_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Bodies that crack";
  study.question =
      "Is every joule of a bar that is drawn apart accounted for, and does it break at the same stress on any mesh "
      "(errata 61, 64)?";
  const double coarsest = first_break(1, monitor);  // below 1: ends that are held all round concentrate stress
  for (const int cells : {2, 3}) {
    monitor.throw_if_stopped();
    study.claims.push_back(judged({"cracks.first-break-" + std::to_string(cells),
                                   "nominal stress at the first break over the strength, " + std::to_string(cells) +
                                       " cells across, against one cell",
                                   first_break(cells, monitor),
                                   coarsest,
                                   0.05,
                                   {},
                                   false}));
  }
  Series series;
  series.id = "ledger";
  series.title = "Ledger of a bar that is drawn apart";
  series.reference = "nothing is lacking";
  series.step_words = "steps per step limit";
  series.error_words = "largest energy that does not close, over the work";
  series.expected_order = 2.0;
  series.error_tolerance = 1e-3;
  if (!wanted(options, series.id)) return study;
  constexpr std::array<double, 4> kSteps{1.25, 2.5, 5.0, 10.0};
  const std::size_t n = level_count(options, kSteps.size());
  for (std::size_t i = 0; i < n; ++i) {
    monitor.throw_if_stopped();
    const Stopwatch watch;
    Level level;
    level.n = kSteps[i];
    level.error = ledger_lacks(1.0 / kSteps[i], monitor);
    level.value = level.error;
    level.exact = 0.0;
    level.n_unknowns = kSteps[i];
    level.wall_time_s = watch.seconds();
    series.levels.push_back(level);
  }
  study.series.push_back(std::move(series));
  return study;
}

}  // namespace klang::validate
