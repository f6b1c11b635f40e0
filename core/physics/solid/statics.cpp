#include "core/physics/solid/statics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/la/sparse_cholesky.hpp"
#include "core/physics/solid/node_ends.hpp"
#include "core/physics/solid/rigid_modes.hpp"

namespace klang::solid {
namespace {

struct TrianglePoint {
  double l1, l2, weight;  // weights sum to the reference area 1/2
};

std::vector<TrianglePoint> triangle_rule() {
  // Seven points, degree 5 (Radon 1948).
  const double root = std::sqrt(15.0);
  std::vector<TrianglePoint> points = {{1. / 3, 1. / 3, 0.5 * 9 / 40}};
  for (const int sign : {-1, 1}) {
    const double a = (6 + sign * root) / 21, weight = 0.5 * (155 + sign * root) / 1200;
    points.push_back({a, a, weight});
    points.push_back({1 - 2 * a, a, weight});
    points.push_back({a, 1 - 2 * a, weight});
  }
  return points;
}

// Values and derivatives by (l1, l2) of the functions of a 3- or 6-node triangle; 6 nodes: corners, mid 01,
// 12, 20.
void triangle_functions(int n, double l1, double l2, Eigen::VectorXd& value, Eigen::MatrixX2d& derivative) {
  const double l0 = 1 - l1 - l2;
  value.resize(n);
  derivative.resize(n, 2);
  if (n == 3) {
    value << l0, l1, l2;
    derivative << -1, -1, 1, 0, 0, 1;
    return;
  }
  value << l0 * (2 * l0 - 1), l1 * (2 * l1 - 1), l2 * (2 * l2 - 1), 4 * l0 * l1, 4 * l1 * l2, 4 * l2 * l0;
  derivative << 1 - 4 * l0, 1 - 4 * l0, 4 * l1 - 1, 0, 0, 4 * l2 - 1, 4 * (l0 - l1), -4 * l1, 4 * l2, 4 * l1, -4 * l2,
      4 * (l0 - l2);
}

Eigen::MatrixXd times(const SparseMatrix& lower, const Eigen::MatrixXd& x) {
  return lower.selfadjointView<Eigen::Lower>() * x;
}

}  // namespace

Eigen::VectorXd traction_force_n(
    const mesh::TetMesh& mesh,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&, const Eigen::Vector3d&)>& traction_pa) {
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
  const auto rule = triangle_rule();
  const auto n = static_cast<int>(surface.triangles.cols());
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * mesh.n_nodes());
  Eigen::VectorXd value;
  Eigen::MatrixX2d derivative;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    Eigen::MatrixX3d nodes(n, 3);
    for (int k = 0; k < n; ++k) nodes.row(k) = surface.vertices_m.row(surface.triangles(t, k));
    for (const auto& point : rule) {
      triangle_functions(n, point.l1, point.l2, value, derivative);
      const Eigen::Matrix<double, 3, 2> tangents = nodes.transpose() * derivative;
      const Eigen::Vector3d cross = tangents.col(0).cross(tangents.col(1));
      const double jacobian = cross.norm();
      const Eigen::Vector3d traction = traction_pa(nodes.transpose() * value, cross / jacobian);
      for (int k = 0; k < n; ++k) {
        force.segment<3>(3 * surface.triangles(t, k)) += point.weight * jacobian * value[k] * traction;
      }
    }
  }
  return force;
}

StaticResult solve_statics(const mesh::TetMesh& mesh, const AssembledSolid& assembled, const Material& material,
                           const Eigen::MatrixXd& force_n) {
  validate(material);
  if (force_n.rows() != 3 * mesh.n_nodes()) {
    throw InputError("statics", "the force has the wrong number of rows", std::to_string(force_n.rows()),
                     std::to_string(3 * mesh.n_nodes()));
  }
  if (!force_n.allFinite()) throw InputError("statics", "the force is not finite");
  StaticResult result;
  Eigen::MatrixXd force(assembled.n_dofs(), force_n.cols());
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    force.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = force_n.middleRows<3>(3 * assembled.free_nodes[i]);
  }
  const SparseMatrix k = stiffness(assembled, material.lame_lambda_pa, material.lame_mu_pa);
  const Eigen::MatrixXd rigid = rigid_modes(mesh, assembled);
  result.n_rigid_modes = static_cast<int>(rigid.cols());
  const Eigen::MatrixXd mass_rigid = times(assembled.mass_unit_density, rigid);
  const Eigen::LDLT<Eigen::MatrixXd> inertia(rigid.transpose() * mass_rigid);

  SparseMatrix pinned = k;
  std::vector<Eigen::Index> pins;
  if (rigid.cols() > 0) {
    force -= mass_rigid * inertia.solve(rigid.transpose() * force);
    // As many displacements as there are rigid motions are set to zero, chosen by pivoted QR so that no rigid
    // motion survives. The load is self-equilibrated, so these pins carry no force.
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rigid.transpose());
    std::vector<char> is_pin(static_cast<std::size_t>(assembled.n_dofs()), 0);
    for (Eigen::Index p = 0; p < rigid.cols(); ++p) {
      pins.push_back(qr.colsPermutation().indices()[p]);
      is_pin[static_cast<std::size_t>(pins.back())] = 1;
    }
    for (Eigen::Index j = 0; j < pinned.cols(); ++j) {
      for (SparseMatrix::InnerIterator entry(pinned, j); entry; ++entry) {
        if (entry.row() != j &&
            (is_pin[static_cast<std::size_t>(entry.row())] || is_pin[static_cast<std::size_t>(j)])) {
          entry.valueRef() = 0;
        }
      }
    }
  }
  la::SparseCholesky factor;
  if (!factor.factor(pinned, la::block_ordering(pinned, node_ends(mesh, assembled)))) {
    result.status = StaticStatus::kFailed;
    result.message = factor.message();
    return result;
  }
  const auto solve = [&](Eigen::MatrixXd load) {
    for (const auto pin : pins) load.row(pin).setZero();
    return factor.solve(load);
  };
  Eigen::MatrixXd u = solve(force);
  u += solve(force - times(k, u));  // one step of refinement
  if (rigid.cols() > 0) u -= rigid * inertia.solve(mass_rigid.transpose() * u);

  const Eigen::MatrixXd elastic_force = times(k, u);
  result.energy_j = 0.5 * u.cwiseProduct(elastic_force).colwise().sum().transpose();
  result.relative_residual.resize(force.cols());
  for (Eigen::Index c = 0; c < force.cols(); ++c) {
    const double scale = force.col(c).norm();
    result.relative_residual[c] = scale > 0 ? (elastic_force.col(c) - force.col(c)).norm() / scale : 0.0;
  }
  result.displacement_m.setZero(3 * mesh.n_nodes(), force.cols());
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    result.displacement_m.middleRows<3>(3 * assembled.free_nodes[i]) =
        u.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  result.status = StaticStatus::kSolved;
  return result;
}

}  // namespace klang::solid
