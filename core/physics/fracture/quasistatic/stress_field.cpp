#include "core/physics/fracture/quasistatic/stress_field.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

double mean_stress_pa(const StressTensor& s) { return (s[0] + s[1] + s[2]) / 3.0; }

/// Upper bound of the largest principal stress, one square root: mean + 2 sqrt(J2 / 3), reached in uniaxial tension. A
/// little above, so that round-off never hides an element.
double principal_bound_pa(const StressTensor& s) {
  const double von_mises = von_mises_pa(s);
  return mean_stress_pa(s) + (2.0 / 3.0) * von_mises + 1e-14 * (std::abs(mean_stress_pa(s)) + von_mises);
}

/// The largest value(stress) of the elements kept; of values that cannot reach what is found already only the bound is taken.
template <class Bound, class Value>
StressExtreme largest(const mesh::TetMesh& mesh, const StressField& field, const std::vector<char>* keep,
                      const Bound& bound, const Value& value, StressTensor& there) {
  StressExtreme found;
  for (int e = 0; e < field.n_elements(); ++e) {
    if (keep != nullptr && (*keep)[static_cast<std::size_t>(e)] == 0) continue;
    for (int c = 0; c < field.n_corners(); ++c) {
      const StressTensor stress = field.corner(e, c);
      if (found.element >= 0 && bound(stress) <= found.stress_pa) continue;
      const double here = value(stress);
      if (found.element >= 0 && here <= found.stress_pa) continue;
      found.stress_pa = here;
      found.element = e;
      there = stress;
    }
  }
  if (found.element >= 0) found.place_m = element_centre_m(mesh, found.element);
  return found;
}

/// Of the eigenvalue number k, ascending.
Eigen::Vector3d principal_direction(const StressTensor& stress, int k) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix_of(stress));
  Eigen::Vector3d direction = solver.eigenvectors().col(k);
  Eigen::Index most = 0;
  direction.cwiseAbs().maxCoeff(&most);
  if (direction[most] < 0.0) direction = -direction;
  return direction;
}

StressExtreme largest_principal(const mesh::TetMesh& mesh, const StressField& field, const std::vector<char>* keep) {
  StressTensor there = StressTensor::Zero();
  StressExtreme found = largest(
      mesh, field, keep, principal_bound_pa, [](const StressTensor& s) { return principal_stresses_pa(s)[0]; }, there);
  if (found.element >= 0) found.direction = principal_direction(there, 2);
  return found;
}

}  // namespace

Eigen::Matrix3d matrix_of(const StressTensor& s) {
  Eigen::Matrix3d matrix;
  matrix << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  return matrix;
}

Eigen::Vector3d principal_stresses_pa(const StressTensor& stress_pa) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix_of(stress_pa), Eigen::EigenvaluesOnly)
      .eigenvalues()
      .reverse();
}

double von_mises_pa(const StressTensor& s) {
  const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * s.tail<3>().squaredNorm());
}

Eigen::Vector3d element_centre_m(const mesh::TetMesh& mesh, int element) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int c = 0; c < 4; ++c) centre += mesh.nodes_m.row(mesh.elements(element, c)).transpose();
  return 0.25 * centre;
}

StressExtreme largest_principal_stress(const mesh::TetMesh& mesh, const StressField& field) {
  return largest_principal(mesh, field, nullptr);
}

StressExtreme largest_principal_stress(const mesh::TetMesh& mesh, const StressField& field,
                                       const std::vector<char>& keep) {
  return largest_principal(mesh, field, &keep);
}

StressExtreme smallest_principal_stress(const mesh::TetMesh& mesh, const StressField& field) {
  StressTensor there = StressTensor::Zero();
  StressExtreme found = largest(
      mesh, field, nullptr, [](const StressTensor& s) { return principal_bound_pa(-s); },
      [](const StressTensor& s) { return -principal_stresses_pa(s)[2]; }, there);
  found.stress_pa = -found.stress_pa;
  if (found.element >= 0) found.direction = principal_direction(there, 0);
  return found;
}

StressExtreme largest_von_mises_stress(const mesh::TetMesh& mesh, const StressField& field) {
  StressTensor there = StressTensor::Zero();
  return largest(mesh, field, nullptr, von_mises_pa, von_mises_pa, there);
}

bool breaks(const StressExtreme& largest, double tensile_strength_pa) {
  if (!(tensile_strength_pa > 0.0) || !std::isfinite(tensile_strength_pa))
    throw InputError("tensile strength", "must be positive and finite", to_text(tensile_strength_pa), "above 0 Pa");
  return largest.element >= 0 && largest.stress_pa >= tensile_strength_pa;
}

}  // namespace klang::fracture
