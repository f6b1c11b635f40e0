#include "core/physics/solid/axisymmetric.hpp"

#include <Eigen/Dense>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/quadrature.hpp"

namespace klang::solid {
namespace {

using Slots = std::vector<std::array<HarmonicSystem::Slot, 3>>;

/// Numbers what is free: on the axis the field must have a value that does not depend on the angle.
Slots number(const mesh::Section& section, int harmonic, bool torsion, int& n_dofs) {
  Slots slots(static_cast<std::size_t>(section.n_nodes()));
  n_dofs = 0;
  for (int i = 0; i < section.n_nodes(); ++i) {
    auto& slot = slots[static_cast<std::size_t>(i)];
    const bool on_axis = section.nodes_m(i, 0) == 0.0;
    if (torsion) {
      if (!on_axis) slot[1].dof = n_dofs++;
    } else if (harmonic == 0) {
      if (!on_axis) slot[0].dof = n_dofs++;
      slot[2].dof = n_dofs++;
    } else if (!on_axis) {
      for (auto& component : slot) component.dof = n_dofs++;
    } else if (harmonic == 1) {
      slot[0].dof = slot[1].dof = n_dofs++;
      slot[1].sign = -1.0;
    }
  }
  return slots;
}

/// Values and derivatives of an element's shape functions at one Gauss point.
struct PointOnSection {
  Eigen::VectorXd value, by_r, by_z;
  double r_m = 0.0, weight_m2 = 0.0;  // weight: dr dz
};

class ElementPoints {
 public:
  explicit ElementPoints(int degree)
      : row_(degree + 1),
        rule_(gauss_rule(degree + 2)),
        table_(lagrange_table(lobatto_rule(degree + 1).points, rule_.points)) {}

  template <class Visitor>
  void each(const mesh::Section& section, int element, Visitor&& visit) const {
    const int n = row_ * row_;
    Eigen::MatrixX2d nodes(n, 2);
    for (int k = 0; k < n; ++k) nodes.row(k) = section.nodes_m.row(section.elements(element, k));
    Eigen::VectorXd by_x(n), by_y(n);
    PointOnSection at;
    at.value.resize(n);
    for (Eigen::Index qy = 0; qy < rule_.points.size(); ++qy) {
      for (Eigen::Index qx = 0; qx < rule_.points.size(); ++qx) {
        for (int b = 0; b < row_; ++b) {
          for (int a = 0; a < row_; ++a) {
            at.value[b * row_ + a] = table_.value(qx, a) * table_.value(qy, b);
            by_x[b * row_ + a] = table_.slope(qx, a) * table_.value(qy, b);
            by_y[b * row_ + a] = table_.value(qx, a) * table_.slope(qy, b);
          }
        }
        const Eigen::RowVector2d d_x = by_x.transpose() * nodes, d_y = by_y.transpose() * nodes;
        const double det = d_x[0] * d_y[1] - d_x[1] * d_y[0];
        if (!(det > 0.0)) throw InputError("section", "element turned inside out", std::to_string(element));
        at.by_r = (d_y[1] * by_x - d_x[1] * by_y) / det;
        at.by_z = (d_x[0] * by_y - d_y[0] * by_x) / det;
        at.r_m = at.value.dot(nodes.col(0));
        at.weight_m2 = rule_.weights[qx] * rule_.weights[qy] * det;
        visit(at);
      }
    }
  }

 private:
  int row_;
  QuadratureRule rule_;
  LagrangeTable table_;
};

}  // namespace

Eigen::Matrix<double, Eigen::Dynamic, 3> HarmonicSystem::components(const Eigen::VectorXd& dofs) const {
  Eigen::Matrix<double, Eigen::Dynamic, 3> result =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(static_cast<Eigen::Index>(slots.size()), 3);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const Slot& slot = slots[i][static_cast<std::size_t>(c)];
      if (slot.dof >= 0) result(static_cast<Eigen::Index>(i), c) = slot.sign * dofs[slot.dof];
    }
  }
  return result;
}

HarmonicSystem assemble_harmonic(const mesh::Section& section, int harmonic, bool torsion) {
  KLANG_CHECK(harmonic >= 0 && (!torsion || harmonic == 0), "assemble_harmonic: torsion belongs to harmonic 0");
  HarmonicSystem system;
  system.harmonic = harmonic;
  system.torsion = torsion;
  system.multiplicity = harmonic == 0 ? 1 : 2;
  int n_dofs = 0;
  system.slots = number(section, harmonic, torsion, n_dofs);
  const double m = harmonic, turn = harmonic == 0 ? 2.0 * kPi : kPi;
  const auto n = static_cast<Eigen::Index>(section.elements.cols());
  const ElementPoints points(section.degree);

  std::vector<Eigen::Triplet<double>> lambda, mu, mass;
  const auto reserve =
      static_cast<std::size_t>(section.n_elements()) * static_cast<std::size_t>(3 * n * (3 * n + 1) / 2);
  lambda.reserve(reserve);
  mu.reserve(reserve);
  mass.reserve(reserve / 3);
  // Rows of strain by (U, V, W) of all nodes; shear strains carry 1/sqrt(2), so that mu's energy is mu times the square.
  Eigen::MatrixXd strain(6, 3 * n), k_lambda(3 * n, 3 * n), k_mu(3 * n, 3 * n), gram(n, n);
  Eigen::RowVectorXd divergence(3 * n);
  for (int e = 0; e < section.n_elements(); ++e) {
    k_lambda.setZero();
    k_mu.setZero();
    gram.setZero();
    points.each(section, e, [&](const PointOnSection& at) {
      const double inverse_r = 1.0 / at.r_m, weight = turn * at.r_m * at.weight_m2, half = std::sqrt(0.5);
      const auto value = at.value.transpose(), by_r = at.by_r.transpose(), by_z = at.by_z.transpose();
      strain.setZero();
      strain.row(0).segment(0, n) = by_r;
      strain.row(1).segment(0, n) = inverse_r * value;
      strain.row(1).segment(n, n) = m * inverse_r * value;
      strain.row(2).segment(2 * n, n) = by_z;
      strain.row(3).segment(0, n) = half * by_z;
      strain.row(3).segment(2 * n, n) = half * by_r;
      strain.row(4).segment(0, n) = -half * m * inverse_r * value;
      strain.row(4).segment(n, n) = half * (by_r - inverse_r * value);
      strain.row(5).segment(n, n) = half * by_z;
      strain.row(5).segment(2 * n, n) = -half * m * inverse_r * value;
      divergence = strain.row(0) + strain.row(1) + strain.row(2);
      k_lambda.selfadjointView<Eigen::Lower>().rankUpdate(divergence.transpose(), weight);
      k_mu.selfadjointView<Eigen::Lower>().rankUpdate(strain.transpose(), 2.0 * weight);
      gram.selfadjointView<Eigen::Lower>().rankUpdate(at.value, weight);
    });
    k_lambda = k_lambda.selfadjointView<Eigen::Lower>();
    k_mu = k_mu.selfadjointView<Eigen::Lower>();
    gram = gram.selfadjointView<Eigen::Lower>();
    const auto slot = [&](Eigen::Index column, int component) -> const HarmonicSystem::Slot& {
      return system.slots[static_cast<std::size_t>(section.elements(e, column))][static_cast<std::size_t>(component)];
    };
    for (int c = 0; c < 3; ++c) {
      for (Eigen::Index i = 0; i < n; ++i) {
        const auto& row = slot(i, c);
        if (row.dof < 0) continue;
        for (int d = 0; d < 3; ++d) {
          for (Eigen::Index j = 0; j < n; ++j) {
            const auto& column = slot(j, d);
            if (column.dof < 0 || column.dof > row.dof) continue;
            const double sign = row.sign * column.sign;
            lambda.emplace_back(row.dof, column.dof, sign * k_lambda(c * n + i, d * n + j));
            mu.emplace_back(row.dof, column.dof, sign * k_mu(c * n + i, d * n + j));
            if (c == d) mass.emplace_back(row.dof, column.dof, sign * gram(i, j));
          }
        }
      }
    }
  }
  const auto assembled = [&](std::vector<Eigen::Triplet<double>>& entries) {
    SparseMatrix matrix(n_dofs, n_dofs);
    matrix.setFromTriplets(entries.begin(), entries.end());
    entries.clear();
    entries.shrink_to_fit();
    return matrix;
  };
  system.stiffness_lambda = assembled(lambda);
  system.stiffness_mu = assembled(mu);
  system.mass_unit_density = assembled(mass);

  // Along and about the axis at m = 0, across it and tilting at m = 1.
  const int n_rigid = torsion || harmonic == 0 ? 1 : harmonic == 1 ? 2 : 0;
  system.rigid.setZero(n_dofs, n_rigid);
  for (int i = 0; i < section.n_nodes() && n_rigid > 0; ++i) {
    const double r = section.nodes_m(i, 0), z = section.nodes_m(i, 1);
    const auto put = [&](int mode, int component, double value) {
      const auto& slot = system.slots[static_cast<std::size_t>(i)][static_cast<std::size_t>(component)];
      if (slot.dof >= 0) system.rigid(slot.dof, mode) = slot.sign * value;
    };
    if (torsion) {
      put(0, 1, r);
    } else if (harmonic == 0) {
      put(0, 2, 1.0);
    } else {
      put(0, 0, 1.0), put(0, 1, -1.0);
      put(1, 0, z), put(1, 1, -z), put(1, 2, -r);
    }
  }
  return system;
}

double section_volume_m3(const mesh::Section& section) {
  double volume_m3 = 0.0;
  const ElementPoints points(section.degree);
  for (int e = 0; e < section.n_elements(); ++e)
    points.each(section, e, [&](const PointOnSection& at) { volume_m3 += 2.0 * kPi * at.r_m * at.weight_m2; });
  return volume_m3;
}

}  // namespace klang::solid
