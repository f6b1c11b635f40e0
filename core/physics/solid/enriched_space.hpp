#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::solid {

/// What the elements of the next degree add to those of a mesh, hierarchically and on the same (curved) geometry:
/// to linear elements l_i l_j on each edge; to quadratic ones l_i l_j (l_i - l_j) on each edge and l_i l_j l_k on
/// each face. V is the space of the mesh, W what is added. No matrix is stored.
///
/// Fields of m vectors are (3 m) x n, one column per node or added function, entry axis m + k for vector k, so that
/// an element's part is contiguous.
class EnrichedSpace {
 public:
  EnrichedSpace(const mesh::TetMesh& mesh, const AssembledSolid& assembled, const Material& material);

  int n_nodes() const { return n_nodes_; }
  int n_added() const { return n_added_; }

  /// (K_WV - value_k M_WV) u_k of each vector; zero for functions on what the support holds.
  Eigen::MatrixXd residual(const Eigen::MatrixXd& u, const Eigen::VectorXd& value) const;
  /// K_VW w and K_WW w.
  void stiffness_of_added(const Eigen::MatrixXd& w, Eigen::MatrixXd& on_nodes, Eigen::MatrixXd& on_added) const;
  /// K_WV v.
  Eigen::MatrixXd stiffness_on_added(const Eigen::MatrixXd& v) const;
  /// The inverse 3 x 3 diagonal blocks of K_WW times each column.
  Eigen::MatrixXd block_jacobi(const Eigen::MatrixXd& w) const;

 private:
  struct Fields {
    const Eigen::MatrixXd* nodes = nullptr;
    const Eigen::MatrixXd* added = nullptr;
  };
  void apply(const Fields& in, const Eigen::VectorXd* value, Eigen::MatrixXd* on_nodes,
             Eigen::MatrixXd* on_added) const;
  void number_added(const std::vector<char>& held);
  void make_diagonal();

  const mesh::TetMesh& mesh_;
  Material material_;
  int n_nodes_ = 0, n_added_ = 0, n_local_ = 0;  // n_local_: added functions of one element
  std::vector<int> added_;                       // n_elements x n_local_
  std::vector<signed char> sign_;                // the same, +-1: odd edge functions have a direction
  std::vector<char> added_held_;
  std::vector<Eigen::Matrix3d> inverse_diagonal_;
};

}  // namespace klang::solid
