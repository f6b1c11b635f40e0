#include "core/sound/scene/detail/residual_flexibility.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"

namespace klang::scene::detail {

using Eigen::Index;
using Eigen::MatrixXd;

ResidualFlexibility::ResidualFlexibility(const modal::ModalModel& model, Index n_modes, const solid::Material& material)
    : solver_(model.mesh, material) {
  if (!solver_.usable()) throw NumericalError("residual flexibility: " + solver_.message());
  const mesh::SurfaceMesh surface = mesh::boundary_surface(model.mesh);
  order_.assign(static_cast<std::size_t>(model.mesh.n_nodes()), -1);
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (Index c = 0; c < surface.triangles.cols(); ++c) order_[static_cast<std::size_t>(surface.triangles(t, c))] = 0;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (order_[i] < 0) continue;
    order_[i] = static_cast<Index>(rows_.size() / 3);
    for (Index axis = 0; axis < 3; ++axis) rows_.push_back(3 * static_cast<Index>(i) + axis);
  }
  shapes_ = model.shapes.leftCols(n_modes)(rows_, Eigen::all);
  inverse_lambda_ = model.angular_frequency_rad_s.head(n_modes).array().square().inverse();
}

const MatrixXd& ResidualFlexibility::columns_of(int node) {
  MatrixXd& columns = columns_[node];
  if (columns.size() > 0) return columns;
  MatrixXd loads = MatrixXd::Zero(3 * static_cast<Index>(order_.size()), 3);
  loads.middleRows<3>(3 * node).setIdentity();
  columns = solver_.solve(loads).displacement_m(rows_, Eigen::all);
  if (const Index first = 3 * order_[static_cast<std::size_t>(node)]; shapes_.cols() > 0)
    columns -= shapes_ * (inverse_lambda_.asDiagonal() * shapes_.middleRows<3>(first).transpose());
  return columns;
}

Eigen::Matrix3d ResidualFlexibility::between(int a, int b) {
  const int low = std::min(a, b), high = std::max(a, b);
  Eigen::Matrix3d block = columns_of(low).middleRows<3>(3 * order_[static_cast<std::size_t>(high)]);
  if (low == high) block = (0.5 * (block + block.transpose())).eval();
  return high == a ? block : Eigen::Matrix3d(block.transpose());
}

}  // namespace klang::scene::detail
