#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/fracture/quasistatic/surface_places.hpp"

namespace klang::fracture {

/// Displacement and stress of a body that is touched again and again at the same nodes: stress is linear in the force, so that
/// a node's three responses (to 1 N along each axis) are solved once and kept. What is kept is displacements: a column
/// of element stresses is ten times as long for linear elements, and to add nine of them up (a force in a triangle) takes
/// longer than to add displacements and take the stress of the sum.
///
/// A load on more than kMostNodes nodes is solved as it is, one column, and not kept: its nodes' responses would be three each.
///
/// Results have the same bits whatever was asked before: columns are solved in any company and added in the order of nodes.
class ContactResponses {
 public:
  static constexpr std::size_t kMostNodes = 64;
  static constexpr std::size_t kDefaultMemoryBytes = std::size_t{512} << 20;

  /// Keeps a reference to the solver, which must be usable(). The responses that were used longest ago are dropped above the
  /// limit; what one load needs is always held.
  explicit ContactResponses(FreeBodySolver& solver, std::size_t memory_limit_bytes = kDefaultMemoryBytes);

  /// 3 n_nodes. @throws InputError for a node that the mesh does not have or a force that is not finite
  Eigen::VectorXd displacement_m(const std::vector<NodeForce>& forces);
  StressField field(const std::vector<NodeForce>& forces);
  /// Half the work of the forces on displacement_m(), from the nodes that they act on alone.
  double strain_energy_j(const std::vector<NodeForce>& forces);

  std::size_t n_nodes_kept() const { return kept_.size(); }
  std::int64_t n_nodes_solved() const { return n_nodes_solved_; }  ///< a load that was solved whole counts as one
  /// Largest relative residual of all responses that were solved.
  double largest_residual() const { return largest_residual_; }

 private:
  struct Response {
    Eigen::Matrix<double, Eigen::Dynamic, 3> displacement_m_per_n;
    std::int64_t last_use = 0;
  };
  /// Sum of the forces by node, ascending.
  std::map<int, Eigen::Vector3d> sum_of(const std::vector<NodeForce>& forces) const;
  void prepare(const std::map<int, Eigen::Vector3d>& sum);  ///< solves for what is missing
  Eigen::VectorXd solved_whole(const std::map<int, Eigen::Vector3d>& sum);
  void solve_for(const std::vector<int>& nodes);
  void drop_down_to_limit();

  FreeBodySolver& solver_;
  std::size_t most_nodes_;
  std::map<int, Response> kept_;
  std::int64_t n_uses_ = 0, n_nodes_solved_ = 0;
  double largest_residual_ = 0.0;
};

}  // namespace klang::fracture
