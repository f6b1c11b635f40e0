#include "core/physics/modal/detail/cluster_orientation.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace klang::modal::detail {

void orient_clusters(const mesh::TetMesh& mesh, const Eigen::VectorXd& omega_sq, Eigen::MatrixXd& shapes) {
  constexpr double kSame = 1e-8;
  const Eigen::RowVector3d centre = mesh.nodes_m.colwise().mean();
  // Directions without a rational relation to the axes, so that no node of a regular mesh lies on a face of the wedge.
  const Eigen::Vector3d one(0.53719, 0.81127, 0.23071), two(0.86413, -0.31957, 0.38891);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(shapes.rows());
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const Eigen::RowVector3d at = mesh.nodes_m.row(node) - centre;
    if (at.dot(one) > 0.0 && at.dot(two) > 0.0) weight.segment<3>(3 * node) << 1.0, 0.83, 0.61;
  }
  for (Eigen::Index first = 0; first < omega_sq.size();) {
    Eigen::Index end = first + 1;
    while (end < omega_sq.size() && omega_sq[end] - omega_sq[end - 1] <= kSame * omega_sq[end]) ++end;
    if (end - first > 1) {
      auto cluster = shapes.middleCols(first, end - first);
      const Eigen::MatrixXd in_wedge = cluster.transpose() * weight.asDiagonal() * cluster;
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> turned(in_wedge);
      cluster = (cluster * turned.eigenvectors().rowwise().reverse()).eval();
    }
    first = end;
  }
}

bool turns_over(const Eigen::Ref<const Eigen::VectorXd>& vector) {
  if (vector.size() == 0) return false;
  const double largest = (1.0 - 1e-6) * vector.cwiseAbs().maxCoeff();
  for (const double value : vector)
    if (std::abs(value) >= largest) return value < 0.0;
  return false;
}

}  // namespace klang::modal::detail
