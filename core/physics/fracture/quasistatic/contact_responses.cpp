#include "core/physics/fracture/quasistatic/contact_responses.hpp"

#include <algorithm>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

constexpr std::size_t kNodesAtOnce = 8;  // 24 columns, three blocks of the triangular solver

}  // namespace

ContactResponses::ContactResponses(FreeBodySolver& solver, std::size_t memory_limit_bytes) : solver_(solver) {
  KLANG_CHECK(solver.usable(), "a factored solver");
  const std::size_t bytes_per_node = 9 * sizeof(double) * static_cast<std::size_t>(solver.mesh().n_nodes());
  most_nodes_ = std::max<std::size_t>(1, memory_limit_bytes / bytes_per_node);
}

std::map<int, Eigen::Vector3d> ContactResponses::sum_of(const std::vector<NodeForce>& forces) const {
  std::map<int, Eigen::Vector3d> sum;
  for (const NodeForce& at : forces) {
    if (at.node < 0 || at.node >= solver_.mesh().n_nodes())
      throw InputError("contact force", "names a node that is not there", std::to_string(at.node),
                       "0 to " + std::to_string(solver_.mesh().n_nodes() - 1));
    if (!at.force_n.allFinite()) throw InputError("contact force", "is not finite");
    const auto [entry, is_new] = sum.try_emplace(at.node, at.force_n);
    if (!is_new) entry->second += at.force_n;
  }
  return sum;
}

void ContactResponses::prepare(const std::map<int, Eigen::Vector3d>& sum) {
  ++n_uses_;
  std::vector<int> missing;
  for (const auto& [node, force] : sum) {
    const auto found = kept_.find(node);
    if (found == kept_.end())
      missing.push_back(node);
    else
      found->second.last_use = n_uses_;
  }
  for (std::size_t first = 0; first < missing.size(); first += kNodesAtOnce)
    solve_for({missing.begin() + static_cast<std::ptrdiff_t>(first),
               missing.begin() + static_cast<std::ptrdiff_t>(std::min(first + kNodesAtOnce, missing.size()))});
  if (kept_.size() > most_nodes_) drop_down_to_limit();
}

Eigen::VectorXd ContactResponses::solved_whole(const std::map<int, Eigen::Vector3d>& sum) {
  Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(solver_.mesh().n_nodes()));
  for (const auto& [node, force] : sum) load.segment<3>(3 * static_cast<Eigen::Index>(node)) = force;
  const QuasistaticSolution solution = solver_.solve(load);
  largest_residual_ = std::max(largest_residual_, solution.relative_residual.maxCoeff());
  ++n_nodes_solved_;
  return solution.displacement_m.col(0);
}

void ContactResponses::solve_for(const std::vector<int>& nodes) {
  const Eigen::Index n_rows = 3 * static_cast<Eigen::Index>(solver_.mesh().n_nodes());
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(n_rows, 3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (int axis = 0; axis < 3; ++axis)
      unit(3 * static_cast<Eigen::Index>(nodes[k]) + axis, 3 * static_cast<Eigen::Index>(k) + axis) = 1.0;
  const QuasistaticSolution solution = solver_.solve(unit);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    kept_[nodes[k]] = {solution.displacement_m.middleCols<3>(3 * static_cast<Eigen::Index>(k)), n_uses_};
  largest_residual_ = std::max(largest_residual_, solution.relative_residual.maxCoeff());
  n_nodes_solved_ += static_cast<std::int64_t>(nodes.size());
}

void ContactResponses::drop_down_to_limit() {
  std::vector<std::pair<std::int64_t, int>> by_use;
  for (const auto& [node, response] : kept_)
    if (response.last_use < n_uses_) by_use.emplace_back(response.last_use, node);
  std::sort(by_use.begin(), by_use.end());
  for (const auto& [use, node] : by_use) {
    if (kept_.size() <= most_nodes_) return;
    kept_.erase(node);
  }
}

Eigen::VectorXd ContactResponses::displacement_m(const std::vector<NodeForce>& forces) {
  const std::map<int, Eigen::Vector3d> sum = sum_of(forces);
  if (sum.size() > kMostNodes) return solved_whole(sum);
  prepare(sum);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(solver_.mesh().n_nodes()));
  for (const auto& [node, force] : sum) {
    const auto& response = kept_.at(node).displacement_m_per_n;
    for (int axis = 0; axis < 3; ++axis)
      if (force[axis] != 0.0) u += force[axis] * response.col(axis);
  }
  return u;
}

StressField ContactResponses::field(const std::vector<NodeForce>& forces) {
  return solver_.stresses().field(displacement_m(forces));
}

double ContactResponses::strain_energy_j(const std::vector<NodeForce>& forces) {
  const std::map<int, Eigen::Vector3d> sum = sum_of(forces);
  double twice = 0.0;
  if (sum.size() > kMostNodes) {
    const Eigen::VectorXd u = solved_whole(sum);
    for (const auto& [node, force] : sum) twice += force.dot(u.segment<3>(3 * static_cast<Eigen::Index>(node)));
    return 0.5 * twice;
  }
  prepare(sum);
  for (const auto& [pushed, push] : sum) {
    const auto& response = kept_.at(pushed).displacement_m_per_n;
    for (const auto& [node, force] : sum)
      twice += force.dot(response.middleRows<3>(3 * static_cast<Eigen::Index>(node)) * push);
  }
  return 0.5 * twice;
}

}  // namespace klang::fracture
