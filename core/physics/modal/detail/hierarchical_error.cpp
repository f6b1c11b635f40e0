#include "core/physics/modal/detail/hierarchical_error.hpp"

#include <algorithm>

#include "core/physics/solid/enriched_space.hpp"

namespace klang::modal::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Modes at once: what an element needs besides is shared by them, but fields of large bodies take memory.
constexpr Index kChunk = 16, kChunkOfLarge = 8;
constexpr int kLargeNodes = 40000;
constexpr int kMaxSteps = 30;
constexpr double kLastStep = 0.03, kToCome = 0.1;  // shares: what the last step adds, what is left to come
constexpr double kSameOmegaSq = 2e-7;
constexpr double kLargestRatio = 0.9;  // of what neighbouring steps add; thin elements have 0.8 and more

// Rows 3 node + axis and one column per mode, from and to the layout of EnrichedSpace.
MatrixXd to_fields(const Eigen::Ref<const MatrixXd>& columns) {
  const Index m = columns.cols(), n = columns.rows() / 3;
  MatrixXd fields(3 * m, n);
  for (Index i = 0; i < n; ++i) {
    for (Index a = 0; a < 3; ++a) fields.col(i).segment(a * m, m) = columns.row(3 * i + a).transpose();
  }
  return fields;
}

MatrixXd free_columns(const MatrixXd& fields, const std::vector<int>& free_nodes) {
  const Index m = fields.rows() / 3, n = static_cast<Index>(free_nodes.size());
  MatrixXd columns(3 * n, m);
  for (Index i = 0; i < n; ++i) {
    const auto field = fields.col(free_nodes[static_cast<std::size_t>(i)]);
    for (Index a = 0; a < 3; ++a) columns.row(3 * i + a) = field.segment(a * m, m).transpose();
  }
  return columns;
}

MatrixXd free_to_fields(const MatrixXd& columns, const std::vector<int>& free_nodes, int n_nodes) {
  const MatrixXd packed = to_fields(columns);
  MatrixXd fields = MatrixXd::Zero(packed.rows(), n_nodes);
  for (Index i = 0; i < packed.cols(); ++i) fields.col(free_nodes[static_cast<std::size_t>(i)]) = packed.col(i);
  return fields;
}

VectorXd dot(const MatrixXd& a, const MatrixXd& b) {
  const VectorXd rows = a.cwiseProduct(b).rowwise().sum();
  return rows.reshaped(rows.size() / 3, 3).rowwise().sum();
}

// 0 / 0 once a residual has vanished.
VectorXd ratio(const VectorXd& a, const VectorXd& b) { return (b.array() > 0).select(a.array() / b.array(), 0.0); }

// The first of the modes that share a frequency. Those of a symmetric body's pairs have one exact frequency too, and so
// one error: it is worked out once.
std::vector<Index> representatives(const VectorXd& omega_sq) {
  std::vector<Index> result;
  for (Index k = 0; k < omega_sq.size(); ++k) {
    const bool same = k > 0 && omega_sq[k] - omega_sq[result.back()] <= kSameOmegaSq * omega_sq[k];
    result.push_back(same ? result.back() : k);
  }
  return result;
}

}  // namespace

VectorXd hierarchical_frequency_error(const ModalModel& model, const solid::AssembledSolid& assembled,
                                      EigenProblem& problem) {
  const solid::EnrichedSpace space(model.mesh, assembled, model.material);
  const VectorXd omega_sq = model.angular_frequency_rad_s.array().square();
  const std::vector<Index> of_mode = representatives(omega_sq);
  std::vector<Index> distinct = of_mode;
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  const auto n_distinct = static_cast<Index>(distinct.size());
  VectorXd estimate(model.n_modes());
  const Index chunk = model.mesh.n_nodes() < kLargeNodes ? kChunk : kChunkOfLarge;
  for (Index first = 0; first < n_distinct; first += chunk) {
    const Index m = std::min(chunk, n_distinct - first);
    const std::vector<Index> modes(distinct.begin() + first, distinct.begin() + first + m);
    const VectorXd value = omega_sq(modes);
    MatrixXd r = space.residual(to_fields(model.shapes(Eigen::all, modes)), value);
    MatrixXd z = space.block_jacobi(r), p = z, q, on_nodes;
    VectorXd rz = dot(r, z);
    Eigen::ArrayXd energy = Eigen::ArrayXd::Zero(m), before = energy;
    for (int step = 1;; ++step) {
      space.stiffness_of_added(p, on_nodes, q);
      const MatrixXd moved = problem.solve(free_columns(on_nodes, assembled.free_nodes));
      q -= space.stiffness_on_added(free_to_fields(moved, assembled.free_nodes, model.mesh.n_nodes()));
      const VectorXd alpha = ratio(rz, dot(p, q));
      const Eigen::ArrayXd added = alpha.cwiseProduct(rz).array();
      energy += added;
      if (step >= 2) {
        const Eigen::ArrayXd factor = ratio(added, before).array().min(kLargestRatio);
        const Eigen::ArrayXd to_come = added * factor / (1 - factor);  // by further steps, as a geometric series
        if (step == kMaxSteps || (added <= kLastStep * energy && to_come <= kToCome * energy).all()) {
          energy += to_come;
          break;
        }
      }
      before = added;
      r -= alpha.replicate(3, 1).asDiagonal() * q;
      z = space.block_jacobi(r);
      const VectorXd rz_next = dot(r, z);
      p = z + ratio(rz_next, rz).replicate(3, 1).asDiagonal() * p;
      rz = rz_next;
    }
    estimate(modes) = 0.5 * energy / value.array();
  }
  return estimate(of_mode);
}

}  // namespace klang::modal::detail
