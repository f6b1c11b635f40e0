#pragma once
#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/modal/modal_model.hpp"

namespace klang::scene::detail {

/// Static compliance of the modes that a modal body does not keep, K^-1 of the free body less that of the kept ones, between nodes of its surface.
/// Columns are solved for when a node is first asked for.
class ResidualFlexibility {
 public:
  /// @param model  on the mesh, mass-normalised shapes; the first n_modes are kept
  /// @throws InputError, NumericalError: a mesh or material without a factor
  ResidualFlexibility(const modal::ModalModel& model, Eigen::Index n_modes, const solid::Material& material);
  /// Displacement at a node [m] under unit forces at another, in the body's frame; between(a, b) is the transpose of between(b, a) to the bit.
  Eigen::Matrix3d between(int a, int b);

 private:
  const Eigen::MatrixXd& columns_of(int node);

  fracture::FreeBodySolver solver_;
  Eigen::MatrixXd shapes_;  ///< of the kept modes, at the surface's nodes
  Eigen::VectorXd inverse_lambda_;
  std::vector<Eigen::Index> rows_;   ///< of the surface's nodes, 3 each
  std::vector<Eigen::Index> order_;  ///< of nodes: which of the surface's, or -1
  std::map<int, Eigen::MatrixXd> columns_;
};

}  // namespace klang::scene::detail
