#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/quasistatic/stress_field.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::fracture {

/// Stress of every element from a displacement: strain = sym grad u, stress = lambda tr(strain) I + 2 mu strain. What depends on
/// the mesh alone is computed once. Linear elements and straight quadratic ones are exact; curved ones use the 14 points of the
/// stiffness matrix, so that energies add up to u . K u / 2.
class ElementStresses {
 public:
  /// Keeps a reference to the mesh. @throws InputError for an element of volume <= 0 or a bad material
  ElementStresses(const mesh::TetMesh& mesh, const solid::Material& material);

  /// @param displacement_m  3 n_nodes. The same bits on any number of threads.
  StressField field(const Eigen::Ref<const Eigen::VectorXd>& displacement_m) const;
  StressTensor stress_pa(const Eigen::Matrix3d& displacement_gradient) const;
  const Eigen::VectorXd& volume_m3() const { return volume_m3_; }

 private:
  /// stress : strain / 2 [J/m^3], the strain from the displacement's gradient.
  double energy_density(const StressTensor& stress_pa, const Eigen::Matrix3d& gradient) const;
  void linear(int element, const double* u, StressField& field) const;
  void quadratic(int element, const double* u, StressField& field) const;

  const mesh::TetMesh& mesh_;
  double lambda_pa_, mu_pa_;
  Eigen::VectorXd volume_m3_;
  std::vector<Eigen::Matrix3d>
      inverse_jacobian_;  ///< of the corners' straight tetrahedron: row b = grad of coordinate b + 1
  std::vector<char> is_curved_;
};

}  // namespace klang::fracture
