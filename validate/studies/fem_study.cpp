#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/solid/assembly.hpp"
#include "datasets-synthetic/ritz_box.hpp"
#include "datasets-synthetic/ritz_tube.hpp"
#include "validate/studies/elastic_sphere.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using mesh::ShapeSpec;

// The materials of tests/reference/sphere_lamb.json and free_solids.json.
const solid::Material kSteel = solid::from_youngs_modulus(200e9, 0.29, 7850.0);
const solid::Material kCeramic{18541610192.46408, 30252100840.336136, 2700.0, "", ""};
const solid::Material kAluminium{4.98e10, 2.57e10, 2700.0, "", ""};
constexpr double kBallRadius_m = 0.03, kBarLength_m = 0.1;

/// A body, its exact frequencies and the meshes that are to come near them.
struct Problem {
  std::string id, title;
  ShapeSpec shape;
  solid::Material material;
  int order = 2;
  int n_modes = 10;                           ///< judged
  int n_computed = 10;                        ///< up to a gap of the spectrum, where the solver is at its best
  std::vector<std::array<int, 3>> divisions;  ///< coarse to fine, all in one proportion (bar: along it)
  double error_tolerance = 0.0;               ///< at the finest
  std::string reference;
  double reference_accuracy = 0.0;            ///< relative, of omega^2
  std::function<Eigen::VectorXd()> exact_hz;  ///< ascending; one alone: the mode nearest to it is judged
  bool counts = true;
};

Eigen::VectorXd hertz(const Eigen::VectorXd& angular_frequency_rad_s) { return angular_frequency_rad_s / (2.0 * kPi); }

std::vector<Problem> problems() {
  const ShapeSpec ball{"sphere", {{"radius_m", kBallRadius_m}}, {}};
  const ShapeSpec block{"box", {{"length_m", 0.03}, {"width_m", 0.04}, {"height_m", 0.05}}, {}};
  const ShapeSpec tile{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.008}}, {}};
  const ShapeSpec bar{"box", {{"length_m", kBarLength_m}, {"width_m", 0.016}, {"height_m", 0.016}}, {}};
  const solid::Material no_poisson = solid::from_youngs_modulus(70e9, 0.0, 2700.0);
  const auto lamb = [] { return elastic_sphere_frequency_hz(kBallRadius_m, kSteel, 10); };
  const auto wave = [no_poisson] {
    return Eigen::VectorXd::Constant(
               1, std::sqrt(no_poisson.youngs_modulus_pa() / no_poisson.density_kg_m3) / (2.0 * kBarLength_m))
        .eval();
  };
  const auto ritz_block = [] {
    return hertz(datasets::RitzBox({0.03, 0.04, 0.05}, kAluminium, {{13, 13, 13}, 56000.0}).angular_frequency_rad_s());
  };
  const auto ritz_tile = [] {
    return hertz(datasets::RitzBox({0.1, 0.1, 0.008}, kCeramic, {{24, 24, 8}, 14500.0}).angular_frequency_rad_s());
  };
  const std::string lamb_words = "Lamb’s characteristic equations of the free ball (13 digits)";
  const std::string box_words = "Ritz method with Legendre polynomials (upper bounds, 1e-6)";
  return {
      {"ball-p2",
       "Ball, curved quadratic elements",
       ball,
       kSteel,
       2,
       10,
       13,
       {{2, 2, 1}, {3, 3, 1}, {4, 4, 1}, {5, 5, 1}},
       1e-4,
       lamb_words,
       1e-12,
       lamb},
      {"ball-p1",
       "Ball, linear elements",
       ball,
       kSteel,
       1,
       10,
       13,
       {{2, 2, 1}, {3, 3, 1}, {4, 4, 1}, {5, 5, 1}, {6, 6, 1}},
       2e-2,
       lamb_words,
       1e-12,
       lamb},
      {"bar-p2",
       "Bar without Poisson effect, quadratic elements",
       bar,
       no_poisson,
       2,
       1,
       10,
       {{4, 2, 2}, {6, 2, 2}, {8, 2, 2}, {12, 2, 2}, {16, 2, 2}},
       4e-6,
       "longitudinal wave, c / 2 L exactly",
       1e-12,
       wave},
      {"block-p2",
       "Block 30 × 40 × 50 mm, quadratic elements",
       block,
       kAluminium,
       2,
       10,
       10,
       {{6, 6, 6}, {8, 8, 8}, {10, 10, 10}, {12, 12, 12}},
       2.5e-4,
       box_words,
       1e-6,
       ritz_block},
      {"block-p1",
       "Block 30 × 40 × 50 mm, linear elements",
       block,
       kAluminium,
       1,
       10,
       10,
       {{6, 6, 6}, {8, 8, 8}, {12, 12, 12}, {16, 16, 16}},
       4e-2,
       box_words,
       1e-6,
       ritz_block},
      {"tile-p2",
       "Thin tile 100 × 100 × 8 mm, quadratic elements",
       tile,
       kCeramic,
       2,
       8,
       8,
       {{4, 4, 2}, {8, 8, 4}, {12, 12, 6}, {16, 16, 8}},
       3e-3,
       box_words,
       1e-6,
       ritz_tile,
       false},
  };
}

/// The edge of the regular tetrahedron that has the mean volume of the elements.
double element_size_m(const mesh::TetMesh& mesh) {
  return std::cbrt(6.0 * std::sqrt(2.0) * mesh::mesh_volume_m3(mesh) / mesh.n_elements());
}

modal::EigenResult solved(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled, const Problem& problem,
                          Monitor& monitor) {
  modal::EigenOptions options;
  options.count = problem.n_computed;
  options.prove_none_missing = false;  // a missing mode would be an error of per cents
  options.tolerance = 1e-7;            // its square is the error of the eigenvalue
  modal::EigenResult result = modal::solve_modes(mesh, assembled, problem.material, {}, options, monitor);
  if (!result.usable() || result.model.n_modes() < problem.n_computed)
    throw NumericalError("converge fem, " + problem.id + ": " + result.message);
  return result;
}

/// Mean of omega_h^2 / omega^2 - 1 over the judged modes; where one frequency is given, of the mode nearest to it.
Eigen::VectorXd judged_modes(const Eigen::VectorXd& computed_hz, const Eigen::VectorXd& exact_hz) {
  if (exact_hz.size() > 1) return computed_hz.head(exact_hz.size());
  Eigen::Index nearest = 0;
  (computed_hz.array() / exact_hz[0] - 1.0).abs().minCoeff(&nearest);
  return computed_hz.segment(nearest, 1);
}

/// How far the exact torsional mode of degree 2 (m = 0) lies from the five computed ones: |u - P u| over the largest |u|, P the
/// projection in the sense of the mass.
SurfaceField torsion_error(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled,
                           const modal::ModalModel& model, const Problem& problem) {
  const double x =
      2.0 * kPi * elastic_sphere_frequency_hz(kBallRadius_m, kSteel, 1)[0] * kBallRadius_m / kSteel.shear_speed_m_s();
  Eigen::VectorXd exact(3 * mesh.n_nodes());
  for (int i = 0; i < mesh.n_nodes(); ++i)
    exact.segment<3>(3 * i) = torsional_displacement(2, x, kBallRadius_m, mesh.nodes_m.row(i).transpose());
  const auto five = model.shapes.leftCols(5);
  const Eigen::VectorXd moved = assembled.mass_unit_density.selfadjointView<Eigen::Lower>() * exact;
  const Eigen::VectorXd share = problem.material.density_kg_m3 * (five.transpose() * moved);
  const Eigen::VectorXd off = exact - five * share;
  const double largest = exact.cwiseAbs().maxCoeff();
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
  SurfaceField field;
  field.name = "torsion-error-" + problem.id;
  field.title = problem.order == 2 ? "Torsional mode, quadratic elements" : "Torsional mode, linear elements";
  field.caption =
      "Distance of the exact torsional mode of degree 2 from the five computed ones, over its largest displacement; " +
      std::to_string(mesh.n_elements()) + " elements.";
  field.quantity = "relative_error";
  const bool quadratic = surface.triangles.cols() == 6;
  constexpr int kPieces[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
  std::vector<int> vertex_of(static_cast<std::size_t>(mesh.n_nodes()), -1);
  std::vector<int> used;
  const auto vertex = [&](int node) {
    int& index = vertex_of[static_cast<std::size_t>(node)];
    if (index < 0) index = static_cast<int>(used.size()), used.push_back(node);
    return index;
  };
  field.triangles.resize(surface.triangles.rows() * (quadratic ? 4 : 1), 3);
  Eigen::Index row = 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    for (int piece = 0; piece < (quadratic ? 4 : 1); ++piece, ++row) {
      for (int c = 0; c < 3; ++c)
        field.triangles(row, c) = vertex(surface.triangles(t, quadratic ? kPieces[piece][c] : c));
    }
  }
  field.vertices_m.resize(static_cast<Eigen::Index>(used.size()), 3);
  field.values.resize(static_cast<Eigen::Index>(used.size()));
  for (std::size_t i = 0; i < used.size(); ++i) {
    field.vertices_m.row(static_cast<Eigen::Index>(i)) = mesh.nodes_m.row(used[i]);
    field.values[static_cast<Eigen::Index>(i)] = off.segment<3>(3 * used[i]).norm() / largest;
  }
  return field;
}

}  // namespace

/// Eigenvalues of linear and quadratic tetrahedra, straight and curved, against exact and Ritz solutions.
Study fem_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Eigenfrequencies of the finite elements";
  study.question =
      "Do the eigenvalues ω² of linear and of quadratic tetrahedra converge at their theoretical orders, 2 and 4, on "
      "straight and on curved bodies? The error is how far the computed ω² lie above the exact ones, in the mean over "
      "the "
      "lowest modes.";
  std::vector<Problem> list = problems();
  std::erase_if(list, [&](const Problem& p) { return !wanted(options, p.id); });
  double n_done = 0.0, n_all = 0.0;
  // Progress by an estimate of the work: unknowns to the power 1.5.
  const auto work = [](const Problem& p, std::size_t i) {
    const auto& n = p.divisions[i];
    const double cells =
        (p.shape.kind == "sphere" ? 26.0 * n[0] * n[0] * n[0] : 1.0 * n[0] * n[1] * n[2]) * (p.order == 2 ? 8.0 : 1.0);
    return std::pow(cells, 1.5);
  };
  for (const Problem& problem : list) {
    for (std::size_t i = 0; i < level_count(options, problem.divisions.size()); ++i) n_all += work(problem, i);
  }
  for (const Problem& problem : list) {
    Series series;
    series.id = problem.id;
    series.title = problem.title;
    series.reference = problem.reference;
    series.step_words = "element size [m]";
    series.error_words = problem.n_modes == 1 ? "relative error of ω² of the longitudinal mode"
                                              : "mean relative error of ω² over the lowest " +
                                                    std::to_string(problem.n_modes) + " modes";
    series.counts = problem.counts;
    series.expected_order = 2.0 * problem.order;
    series.order_tolerance = problem.order == 1 ? 0.3 : 0.4;
    series.error_floor = 20.0 * problem.reference_accuracy;
    series.floor_words = "20 times the accuracy of the reference";
    const Eigen::VectorXd exact_hz = problem.exact_hz().head(problem.n_modes);
    series.exact_value = exact_hz.mean();
    const std::size_t n_levels = level_count(options, problem.divisions.size());
    series.error_tolerance = problem.error_tolerance * std::pow(static_cast<double>(problem.divisions.back()[0]) /
                                                                    problem.divisions[n_levels - 1][0],
                                                                series.expected_order);
    for (std::size_t i = 0; i < n_levels; ++i) {
      monitor.throw_if_stopped();
      monitor.progress(problem.title, n_done / n_all);
      const Stopwatch watch;
      const mesh::TetMesh mesh =
          mesh::mesh_shape(problem.shape, mesh::ShapeDivisions{problem.divisions[i]}, problem.order);
      const solid::AssembledSolid assembled = solid::assemble(mesh);
      const modal::EigenResult modes = solved(mesh, assembled, problem, silent_monitor());
      Level level;
      level.h_m = problem.id == "bar-p2" ? kBarLength_m / problem.divisions[i][0] : element_size_m(mesh);
      const Eigen::VectorXd f_hz = judged_modes(modes.model.frequency_hz(), exact_hz);
      level.error = ((f_hz.array() / exact_hz.array()).square() - 1.0).mean();
      level.value = f_hz.mean();
      level.n_unknowns = static_cast<double>(assembled.n_dofs());
      level.wall_time_s = watch.seconds();
      series.levels.push_back(level);
      n_done += work(problem, i);
      if (options.fields && i + 1 == n_levels && problem.shape.kind == "sphere")
        study.fields.surfaces.push_back(torsion_error(mesh, assembled, modes.model, problem));
    }
    study.series.push_back(std::move(series));
  }
  return study;
}

}  // namespace klang::validate
