#include "core/physics/fracture/quasistatic/body_stress.hpp"

#include <cmath>
#include <cstdio>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/fracture/quasistatic/mesh_energy_error.hpp"

namespace klang::fracture {
namespace {

constexpr double kResidualToRefuse = 1e-6, kResidualToWarn = 1e-8;
constexpr double kEnergyShareToWarn = 0.05;
constexpr double kLoadShareToWarn = 0.1;
constexpr double kLargestStrain = 0.01;        // of linear theory
constexpr double kLargestDisplacement = 0.05;  // of the diagonal

template <class... Values>
std::string sentence(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

double largest_at(const StressField& field, int element) {
  double most = principal_stresses_pa(field.corner(element, 0))[0];
  for (int c = 1; c < field.n_corners(); ++c) most = std::max(most, principal_stresses_pa(field.corner(element, c))[0]);
  return most;
}

/// Elements that hold a node that is pushed.
std::vector<char> elements_at_loads(const mesh::TetMesh& mesh, const Eigen::VectorXd& nodal_force_n) {
  std::vector<char> at(static_cast<std::size_t>(mesh.n_elements()), 0);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (Eigen::Index k = 0; k < mesh.elements.cols(); ++k)
      if (!nodal_force_n.segment<3>(3 * static_cast<Eigen::Index>(mesh.elements(e, k))).isZero(0.0))
        at[static_cast<std::size_t>(e)] = 1;
  return at;
}

/// Sum of |F| / (2 pi r^2): what the forces do to a half-space at that distance.
double own_stress_pa(const std::vector<SurfacePlace>& places, const std::vector<PointForce>& forces,
                     const Eigen::Vector3d& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i)
    sum += forces[i].force_n.norm() / (2.0 * kPi * (x - places[i].place_m).squaredNorm());
  return sum;
}

void judge_loads(const mesh::TetMesh& mesh, const std::vector<PointForce>& forces, BodyStress& result) {
  const std::vector<char> at_load = elements_at_loads(mesh, result.nodal_force_n);
  std::vector<char> elsewhere(at_load.size(), 0);
  double energy_at_loads = 0.0;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    if (at_load[static_cast<std::size_t>(e)] != 0)
      energy_at_loads += result.field.energy_density_j_m3[e] * result.field.volume_m3[e];
    else
      elsewhere[static_cast<std::size_t>(e)] =
          largest_at(result.field, e) > 2.0 * own_stress_pa(result.places, forces, element_centre_m(mesh, e));
  }
  result.tension_is_at_a_load = elsewhere[static_cast<std::size_t>(result.tension.element)] == 0;
  const StressExtreme largest = largest_principal_stress(mesh, result.field, elsewhere);
  if (largest.element >= 0) result.tension_elsewhere = largest;
  if (result.field.strain_energy_j > 0.0) result.energy_share_at_loads = energy_at_loads / result.field.strain_energy_j;
}

void warn(const mesh::TetMesh& mesh, const solid::Material& material, BodyStress& result) {
  std::vector<std::string>& warnings = result.warnings;
  if (result.tension_is_at_a_load)
    warnings.push_back(
        "the largest tension sits at a point force, whose stress grows without bound as the mesh is refined: it is no "
        "property of the body" +
        (result.tension_elsewhere ? sentence(" (largest elsewhere: %.4g Pa)", result.tension_elsewhere->stress_pa)
                                  : std::string()));
  if (!(result.energy_share_at_loads <= kLoadShareToWarn))
    warnings.push_back(
        sentence("%.0f %% of the strain energy lies in the elements under the forces; that of a point force "
                 "grows without bound as the mesh is refined",
                 100.0 * result.energy_share_at_loads));
  if (!(result.energy_share_missing <= kEnergyShareToWarn))
    warnings.push_back(
        sentence("the mesh misses about %.0f %% of the strain energy by its own estimate%s; a finer mesh "
                 "(--refine, --max-edge-m) brings it down",
                 100.0 * result.energy_share_missing,
                 mesh.order() == 1 ? " (linear elements lock in bending: --element p2)" : ""));
  if (!(result.relative_residual <= kResidualToWarn))
    warnings.push_back(sentence("the residual of K u = f' is %.1e of the load", result.relative_residual));
  const double strain =
      std::max(result.tension.stress_pa, -result.compression.stress_pa) / material.youngs_modulus_pa();
  const double diagonal = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  if (!(strain <= kLargestStrain) || !(result.max_displacement_m <= kLargestDisplacement * diagonal))
    warnings.push_back(sentence("strains of about %.2g and displacements of %.2g m are beyond linear theory", strain,
                                result.max_displacement_m));
}

}  // namespace

BodyStress body_stress(FreeBodySolver& solver, const solid::Material& material, const std::vector<PointForce>& forces) {
  if (forces.empty()) throw InputError("forces", "none is given");
  const mesh::TetMesh& mesh = solver.mesh();
  BodyStress result;
  result.mass_kg = solver.mass_kg();
  result.centre_m = solver.centre_m();
  const SurfacePlaces surface(mesh);
  const std::vector<NodeForce> at_nodes = surface.at_nodes(forces);
  for (const PointForce& force : forces) result.places.push_back(surface.at(force.place_m));
  result.nodal_force_n = nodal_force_n(mesh, at_nodes);
  if (result.nodal_force_n.isZero(0.0)) throw InputError("forces", "are all zero");
  if (!solver.usable()) {
    result.status = BodyStress::Status::kFailed;
    result.message = "the stiffness matrix could not be factored: " + solver.message();
    return result;
  }
  const QuasistaticSolution solution = solver.solve(result.nodal_force_n);
  result.displacement_m = solution.displacement_m.col(0);
  result.relative_residual = solution.relative_residual[0];
  if (!result.displacement_m.allFinite() || !(result.relative_residual <= kResidualToRefuse)) {
    result.status = BodyStress::Status::kFailed;
    result.message = sentence("the residual of K u = f' is %.1e of the load: the mesh is too badly shaped",
                              result.relative_residual);
    return result;
  }
  result.acceleration = solver.acceleration(result.nodal_force_n);
  result.field = solver.stresses().field(result.displacement_m);
  result.tension = largest_principal_stress(mesh, result.field);
  result.compression = smallest_principal_stress(mesh, result.field);
  result.von_mises = largest_von_mises_stress(mesh, result.field);
  for (int i = 0; i < mesh.n_nodes(); ++i)
    result.max_displacement_m =
        std::max(result.max_displacement_m, result.displacement_m.segment<3>(3 * static_cast<Eigen::Index>(i)).norm());
  judge_loads(mesh, forces, result);
  result.energy_share_missing = energy_share_missing(mesh, result.field, material);
  warn(mesh, material, result);
  result.status = BodyStress::Status::kSolved;
  return result;
}

}  // namespace klang::fracture
