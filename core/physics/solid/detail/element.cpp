#include "core/physics/solid/detail/element.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/foundation/base/vector_clones.hpp"
#include "core/foundation/math/tet_rule.hpp"

namespace klang::solid::detail {
namespace {

constexpr int kPoints = TetRule::kPoints;

struct QuadraticRule {
  std::array<double, kPoints> weight;  // sums to the reference volume 1/6
  std::array<std::array<double, 10>, kPoints> value;
  std::array<Eigen::Matrix<double, 10, 3>, kPoints> derivative;  // by reference coordinates (l1, l2, l3)
};

QuadraticRule make_rule() {
  QuadraticRule rule;
  const TetRule points = make_tet_rule();
  const auto& point = points.point;
  rule.weight = points.weight;
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (int q = 0; q < kPoints; ++q) {
    const auto& l = point[q];
    // Gradient of barycentric coordinate i by (l1, l2, l3), with l0 = 1 - l1 - l2 - l3.
    const auto dl = [](int i) {
      return i == 0 ? Eigen::RowVector3d(-1, -1, -1) : Eigen::RowVector3d(Eigen::RowVector3d::Unit(i - 1));
    };
    for (int i = 0; i < 4; ++i) {
      rule.value[q][i] = l[i] * (2 * l[i] - 1);
      rule.derivative[q].row(i) = (4 * l[i] - 1) * dl(i);
    }
    for (int k = 0; k < 6; ++k) {
      const auto [i, j] = edges[k];
      rule.value[q][4 + k] = 4 * l[i] * l[j];
      rule.derivative[q].row(4 + k) = 4 * (l[i] * dl(j) + l[j] * dl(i));
    }
  }
  return rule;
}

KLANG_CLONES void sum_outer_products(const double* gradients, double* products) {
  for (int i = 0; i < kStride; ++i) {
    double row[kStride] = {};
    for (int q = 0; q < kPoints; ++q) {
      const double* g = gradients + q * kStride;
      const double factor = g[i];
      for (int j = 0; j < kStride; ++j) row[j] += factor * g[j];
    }
    for (int j = 0; j < kStride; ++j) products[i * kStride + j] = row[j];
  }
}

bool integrate_quadratic(const mesh::TetMesh& mesh, int e, ElementIntegrals& out) {
  static const QuadraticRule rule = make_rule();
  Eigen::Matrix<double, 10, 3> nodes;
  for (int i = 0; i < 10; ++i) nodes.row(i) = mesh.nodes_m.row(mesh.elements(e, i));
  alignas(64) double gradients[kPoints * kStride];
  double volume = 0;
  std::array<double, kPoints> weight;
  for (int q = 0; q < kPoints; ++q) {
    const Eigen::Matrix3d jacobian = nodes.transpose() * rule.derivative[q];  // dx_a / dl_b
    const double det = jacobian.determinant();
    if (!(det > 0)) return false;
    const Eigen::Matrix<double, 10, 3> gradient = rule.derivative[q] * jacobian.inverse();
    weight[q] = rule.weight[q] * det;
    volume += weight[q];
    const double root = std::sqrt(weight[q]);
    double* row = gradients + q * kStride;
    for (int i = 0; i < 10; ++i) {
      for (int a = 0; a < 3; ++a) row[3 * i + a] = root * gradient(i, a);
    }
    row[30] = row[31] = 0;
  }
  sum_outer_products(gradients, out.gradient_products[0].data());
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = 0;
      for (int q = 0; q < kPoints; ++q) sum += weight[q] * rule.value[q][i] * rule.value[q][j];
      out.mass[i][j] = out.mass[j][i] = sum;
    }
  }
  out.volume_m3 = volume;
  return std::isfinite(volume);
}

bool integrate_linear(const mesh::TetMesh& mesh, int e, ElementIntegrals& out) {
  Eigen::Matrix<double, 4, 3> nodes;
  for (int i = 0; i < 4; ++i) nodes.row(i) = mesh.nodes_m.row(mesh.elements(e, i));
  Eigen::Matrix3d jacobian;
  for (int b = 0; b < 3; ++b) jacobian.col(b) = (nodes.row(b + 1) - nodes.row(0)).transpose();
  const double volume = jacobian.determinant() / 6;
  if (!(volume > 0) || !std::isfinite(volume)) return false;
  Eigen::Matrix<double, 4, 3> gradient;
  gradient.bottomRows<3>() = jacobian.inverse();
  gradient.row(0) = -gradient.bottomRows<3>().colwise().sum();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          out.gradient_products[3 * i + a][3 * j + b] = volume * (gradient(i, a) * gradient(j, b));
        }
      }
      out.mass[i][j] = volume / (i == j ? 10 : 20);
    }
  }
  out.volume_m3 = volume;
  return true;
}

}  // namespace

bool integrate_element(const mesh::TetMesh& mesh, int e, ElementIntegrals& out) {
  return mesh.elements.cols() == 10 ? integrate_quadratic(mesh, e, out) : integrate_linear(mesh, e, out);
}

}  // namespace klang::solid::detail
