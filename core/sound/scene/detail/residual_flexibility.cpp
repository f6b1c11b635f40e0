#include "core/sound/scene/detail/residual_flexibility.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/physics/fracture/quasistatic/place_compliance.hpp"

namespace klang::scene::detail {

using Eigen::Index;
using Eigen::MatrixXd;

ResidualFlexibility::ResidualFlexibility(const modal::ModalModel& model, const Eigen::VectorXd& lambda,
                                         const solid::Material& material)
    : mesh_(model.mesh), material_(material), all_shapes_(model.shapes.leftCols(lambda.size())), lambda_(lambda) {}

fracture::FreeBodySolver& ResidualFlexibility::solver() {
  if (solver_) return *solver_;
  solver_ = std::make_unique<fracture::FreeBodySolver>(mesh_, material_);
  if (!solver_->usable()) throw NumericalError("residual flexibility: " + solver_->message());
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh_);
  order_.assign(static_cast<std::size_t>(mesh_.n_nodes()), -1);
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (Index c = 0; c < surface.triangles.cols(); ++c) order_[static_cast<std::size_t>(surface.triangles(t, c))] = 0;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (order_[i] < 0) continue;
    order_[i] = static_cast<Index>(rows_.size() / 3);
    for (Index axis = 0; axis < 3; ++axis) rows_.push_back(3 * static_cast<Index>(i) + axis);
  }
  shapes_ = all_shapes_(rows_, Eigen::all);
  // As the mesh has them, whatever frequencies the body moves at.
  inverse_lambda_ = all_shapes_.cwiseProduct(solver_->stiffness_times(all_shapes_)).colwise().sum().cwiseInverse();
  return *solver_;
}

const MatrixXd& ResidualFlexibility::columns_of(int node) {
  MatrixXd& columns = columns_[node];
  if (columns.size() > 0) return columns;
  fracture::FreeBodySolver& solver = this->solver();
  MatrixXd loads = MatrixXd::Zero(3 * static_cast<Index>(order_.size()), 3);
  loads.middleRows<3>(3 * node).setIdentity();
  columns = solver.solve(loads).displacement_m(rows_, Eigen::all);
  if (const Index first = 3 * order_[static_cast<std::size_t>(node)]; shapes_.cols() > 0)
    columns -= shapes_ * (inverse_lambda_.asDiagonal() * shapes_.middleRows<3>(first).transpose());
  return columns;
}

Eigen::Matrix3d ResidualFlexibility::between(int a, int b) {
  solver();
  const int low = std::min(a, b), high = std::max(a, b);
  Eigen::Matrix3d block = columns_of(low).middleRows<3>(3 * order_[static_cast<std::size_t>(high)]);
  if (low == high) block = (0.5 * (block + block.transpose())).eval();
  return high == a ? block : Eigen::Matrix3d(block.transpose());
}

double ResidualFlexibility::beyond_dent_m_per_n(const Eigen::Vector3d& place_m, const Eigen::Vector3d& outward,
                                                const Eigen::VectorXd& along) {
  constexpr double kSamePlace = 0.25, kSameFace = 0.99;
  for (const Found& other : found_)
    if ((other.place_m - place_m).norm() <= kSamePlace * other.edge_m && other.outward.dot(outward) >= kSameFace)
      return other.soft_m_per_n;
  const fracture::PlaceCompliance all = fracture::place_compliance(solver(), material_, place_m, outward);
  const double kept = along.cwiseAbs2().dot(lambda_.cwiseInverse());
  found_.push_back({place_m, outward, all.edge_m, std::max(0.0, all.beyond_dent_m_per_n - kept)});
  return found_.back().soft_m_per_n;
}

}  // namespace klang::scene::detail
