#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/foundation/la/sparse_cholesky.hpp"
#include "core/foundation/la/sparse_matrix.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/quasistatic/element_stresses.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::fracture {

/// How a load that accelerates the body is balanced before it strains it.
enum class Relief {
  kConsistentMass,  ///< f' = f - M R (R^T M R)^-1 R^T f, M the elements' mass: inertia relief, what a free body feels
  kLumpedMass,      ///< the same with the diagonal mass
  kEuclidean        ///< f' = f - R (R^T R)^-1 R^T f, as SB eqs. 2 and 3 print it (docs/errata.md item 47)
};

/// What the load does to the body as a whole.
struct RigidAcceleration {
  Eigen::Vector3d net_force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d net_moment_n_m = Eigen::Vector3d::Zero();     ///< about the centre of mass
  Eigen::Vector3d acceleration_m_s2 = Eigen::Vector3d::Zero();  ///< of the centre of mass
  Eigen::Vector3d spin_rad_s2 = Eigen::Vector3d::Zero();  ///< angular acceleration of a body that does not turn yet
};

struct QuasistaticSolution {
  Eigen::MatrixXd displacement_m;   ///< 3 n_nodes x n_loads, without rigid part (orthogonal to it by the relief's mass)
  Eigen::VectorXd strain_energy_j;  ///< u . f' / 2
  Eigen::VectorXd
      relative_residual;  ///< ||K u - f'|| / ||f'||, 0 for f' = 0; round-off makes it (length / thickness)^3 times 1e-16
  Eigen::VectorXd backward_error;  ///< ||K u - f'|| / (k ||u|| + ||f'||), k the largest diagonal entry of K
};

/// Quasistatic stress of a free body under forces (SB section 3.1): K u = f', K of rank 3 n_nodes - 6. Six displacements are
/// set to zero (three at a node, two at a second, one at a third), which leaves a regular matrix; one Cholesky factor serves
/// all loads. Since f' is balanced the pins carry nothing, and the stress does not depend on them.
class FreeBodySolver {
 public:
  /// Assembles and factors. @throws InputError: bad material; an element without volume; a node of no element; elements that do
  /// not hang together by faces (several bodies; by an edge or a node they turn about it)
  FreeBodySolver(mesh::TetMesh mesh, const solid::Material& material, Relief relief = Relief::kConsistentMass);
  FreeBodySolver(const FreeBodySolver&) = delete;
  FreeBodySolver& operator=(const FreeBodySolver&) = delete;

  /// False when the factorization failed (memory, elements so flat that K is not positive definite); message() says why.
  bool usable() const { return usable_; }
  const std::string& message() const { return message_; }

  const mesh::TetMesh& mesh() const { return mesh_; }
  const ElementStresses& stresses() const { return stresses_; }
  double mass_kg() const { return mass_kg_; }
  const Eigen::Vector3d& centre_m() const { return centre_m_; }  ///< of mass
  const std::array<int, 6>& pins() const { return pins_; }       ///< degrees of freedom 3 node + axis
  double n_factor_entries() const { return factor_.n_factor_entries(); }

  /// @param force_n  3 n_nodes x n_loads
  Eigen::MatrixXd relieved(const Eigen::MatrixXd& force_n) const;
  /// By the relief's mass; the Euclidean one has no accelerations (zero).
  RigidAcceleration acceleration(const Eigen::VectorXd& force_n) const;
  /// All columns with the one factor, in blocks of 8. A column whose backward error is above 1e-14 is refined once. For three columns
  /// or more each column's bits do not depend on the others. Not to be called by two threads at once.
  /// @throws InputError for a wrong number of rows or numbers that are not finite
  QuasistaticSolution solve(const Eigen::MatrixXd& force_n);
  Eigen::MatrixXd stiffness_times(const Eigen::MatrixXd& u) const;

 private:
  void set_rigid_motions(const la::SparseMatrix& mass, Relief relief);
  void choose_pins();
  Eigen::MatrixXd solve_pinned(Eigen::MatrixXd load);

  mesh::TetMesh mesh_;
  ElementStresses stresses_;
  Relief relief_;
  la::SparseMatrix stiffness_;          // lower triangle
  double largest_diagonal_ = 0.0;       // of it
  Eigen::MatrixXd rigid_, mass_rigid_;  // 3 n_nodes x 6: R and M R, turns about the centre
  Eigen::LDLT<Eigen::MatrixXd> inertia_;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
  double mass_kg_ = 0.0;
  std::array<int, 6> pins_{};
  la::SparseCholesky factor_;
  bool usable_ = false;
  std::string message_;
};

}  // namespace klang::fracture
