#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/geometry/shapes/section.hpp"
#include "core/physics/solid/assembly.hpp"

namespace klang::solid {

/// One circumferential harmonic of a free body of revolution:
///   u_r = U cos(m theta), u_theta = V sin(m theta), u_z = W cos(m theta)
/// with U, V, W on the section's nodes; and its turned copy (sin, -cos, sin) where m >= 1. At m = 0 the torsion V alone is
/// a system of its own. The integral over theta is done: 2 pi at m = 0, pi above.
struct HarmonicSystem {
  int harmonic = 0;
  bool torsion = false;
  int multiplicity = 1;           ///< 2 for harmonic >= 1
  SparseMatrix stiffness_lambda;  ///< lower triangle; K = lambda K_lambda + mu K_mu
  SparseMatrix stiffness_mu;
  SparseMatrix mass_unit_density;
  Eigen::MatrixXd rigid;  ///< n_dofs x 0 to 2: the rigid motions that are of this harmonic

  /// Degree of freedom of a node's component (U, V, W), -1 where it vanishes, and its sign: on the axis U = -V at m = 1.
  struct Slot {
    int dof = -1;
    double sign = 1.0;
  };
  std::vector<std::array<Slot, 3>> slots;  ///< n_nodes

  Eigen::Index n_dofs() const { return mass_unit_density.rows(); }
  /// U, V, W of every node, n_nodes x 3.
  Eigen::Matrix<double, Eigen::Dynamic, 3> components(const Eigen::VectorXd& dofs) const;
};

/// Semi-analytical finite elements (Fourier in the angle, elements of the section's degree in the half-plane). Strains in
/// cylindrical coordinates; Gauss points degree + 2 in each direction, none of them on the axis.
/// @param torsion  only at harmonic 0
HarmonicSystem assemble_harmonic(const mesh::Section& section, int harmonic, bool torsion = false);

/// Volume of the turned section by the same quadrature.
double section_volume_m3(const mesh::Section& section);

}  // namespace klang::solid
