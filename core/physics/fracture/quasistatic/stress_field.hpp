#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::fracture {

/// xx, yy, zz, xy, yz, zx [Pa], tension positive.
using StressTensor = Eigen::Matrix<double, 6, 1>;

/// Cauchy stress of small strains in every element.
struct StressField {
  Eigen::Matrix<double, 6, Eigen::Dynamic> stress_pa;  ///< mean over each element; the stress itself of linear ones
  /// Quadratic elements: at each element's corners, column 4 element + corner. A straight one has its extremes there, since its
  /// stress is linear; of a curved one the linear function that is nearest in the mean square. Empty for linear elements.
  Eigen::Matrix<double, 6, Eigen::Dynamic> corner_stress_pa;
  Eigen::VectorXd energy_density_j_m3;  ///< mean over each element of stress : strain / 2
  Eigen::VectorXd volume_m3;            ///< of each element
  double strain_energy_j = 0.0;         ///< energy_density_j_m3 . volume_m3 = u . K u / 2

  int n_elements() const { return static_cast<int>(stress_pa.cols()); }
  int n_corners() const { return corner_stress_pa.size() > 0 ? 4 : 1; }
  /// What the extremes of an element are taken from: its corners', or its one stress.
  auto corner(int element, int c) const {
    return corner_stress_pa.size() > 0 ? corner_stress_pa.col(4 * static_cast<Eigen::Index>(element) + c)
                                       : stress_pa.col(element);
  }
};

Eigen::Matrix3d matrix_of(const StressTensor& stress_pa);
/// Eigenvalues, descending [Pa].
Eigen::Vector3d principal_stresses_pa(const StressTensor& stress_pa);
/// sqrt(3 J2), J2 of the deviator.
double von_mises_pa(const StressTensor& stress_pa);

/// An extreme of a field over its elements; of equal ones that of the first element.
struct StressExtreme {
  double stress_pa = 0.0;
  int element = -1;                                     ///< -1: no element was looked at
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();    ///< the element's centre (mean of its corners)
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, of that principal stress; largest component positive
};

/// Largest principal stress (tension opens a crack across its direction), smallest (compression) and von Mises' largest.
StressExtreme largest_principal_stress(const mesh::TetMesh& mesh, const StressField& field);
StressExtreme smallest_principal_stress(const mesh::TetMesh& mesh, const StressField& field);
StressExtreme largest_von_mises_stress(const mesh::TetMesh& mesh, const StressField& field);

/// The first of them among elements with keep[element] != 0.
StressExtreme largest_principal_stress(const mesh::TetMesh& mesh, const StressField& field,
                                       const std::vector<char>& keep);

/// Rankine: it breaks where the largest principal stress reaches the strength.
/// @throws InputError unless strength_pa > 0
bool breaks(const StressExtreme& largest, double tensile_strength_pa);

Eigen::Vector3d element_centre_m(const mesh::TetMesh& mesh, int element);

}  // namespace klang::fracture
