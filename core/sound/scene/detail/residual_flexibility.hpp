#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/modal/modal_model.hpp"

namespace klang::scene::detail {

/// Static compliance of the modes that a modal body does not keep, K^-1 of the free body less that of the kept ones, between nodes of its surface.
/// The factor is made, and columns are solved for, when something is first asked for.
class ResidualFlexibility {
 public:
  /// @param model  on the mesh, mass-normalised shapes; the first n_modes are kept
  ResidualFlexibility(const modal::ModalModel& model, const Eigen::VectorXd& lambda, const solid::Material& material);
  /// Displacement at a node [m] under unit forces at another, in the body's frame; between(a, b) is the transpose of between(b, a) to the bit.
  /// @throws InputError, NumericalError: a mesh or material without a factor
  Eigen::Matrix3d between(int a, int b);
  /// What those modes give way along the normal at any place of the surface under what presses there, less the dent of a half-space: whatever presses has that
  /// already (Hertz' spring). Places nearer than a quarter of the mesh's edges to one that was asked for have its value. Not below 0.
  /// @param place_m  in the mesh's frame. @param along  the kept modes along the outward unit normal there
  double beyond_dent_m_per_n(const Eigen::Vector3d& place_m, const Eigen::Vector3d& outward,
                             const Eigen::VectorXd& along);

 private:
  fracture::FreeBodySolver& solver();
  const Eigen::MatrixXd& columns_of(int node);
  struct Found {
    Eigen::Vector3d place_m, outward;
    double edge_m = 0.0, soft_m_per_n = 0.0;
  };

  mesh::TetMesh mesh_;
  solid::Material material_;
  std::unique_ptr<fracture::FreeBodySolver> solver_;
  Eigen::MatrixXd all_shapes_, shapes_;      ///< of the kept modes; at the surface's nodes
  Eigen::VectorXd lambda_, inverse_lambda_;  ///< that the body moves by; of the mesh
  std::vector<Eigen::Index> rows_;           ///< of the surface's nodes, 3 each
  std::vector<Eigen::Index> order_;          ///< of nodes: which of the surface's, or -1
  std::map<int, Eigen::MatrixXd> columns_;
  std::vector<Found> found_;
};

}  // namespace klang::scene::detail
