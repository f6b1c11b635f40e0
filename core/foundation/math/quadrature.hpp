#pragma once
#include <Eigen/Core>

namespace klang {

/// Points and weights on [-1, 1], ascending.
struct QuadratureRule {
  Eigen::VectorXd points, weights;
};

/// Gauss-Legendre, exact to degree 2 n - 1; n from 1 to 200.
QuadratureRule gauss_rule(int n);

/// Gauss-Lobatto, both ends included, exact to degree 2 n - 3; n from 2 to 200.
QuadratureRule lobatto_rule(int n);

/// Values (n_at x n_nodes) and slopes of the Lagrange polynomials on distinct nodes.
struct LagrangeTable {
  Eigen::MatrixXd value, slope;
};
LagrangeTable lagrange_table(const Eigen::VectorXd& nodes, const Eigen::VectorXd& at);

}  // namespace klang
