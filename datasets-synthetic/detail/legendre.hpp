#pragma once
#include <Eigen/Core>

namespace klang::datasets::detail {

/// Legendre polynomials on [-length/2, length/2], orthonormal: int p_i p_k dx = delta_ik, i = 0 ... order.
/// Their 1D integrals, exact: every one of them is an integer but for the normalisation.
struct LegendreIntegrals {
  LegendreIntegrals(int order, double length_m);
  Eigen::MatrixXd value_slope;  ///< int p_i p_k' dx [1/m]
  Eigen::MatrixXd slope_slope;  ///< int p_i' p_k' dx [1/m^2]
};

/// p_0 ... p_order at x in [-length/2, length/2].
Eigen::VectorXd legendre_values(int order, double length_m, double x_m);
/// Their derivatives by x.
Eigen::VectorXd legendre_slopes(int order, double length_m, double x_m);

/// Gauss-Legendre rule of n points on [low, high], exact to degree 2 n - 1.
struct GaussRule {
  GaussRule(int n, double low, double high);
  Eigen::VectorXd points, weights;
};

/// The lowest count eigenpairs of a symmetric matrix (lower triangle used), by LAPACK dsyevr on one thread:
/// the result does not depend on the number of threads.
struct EigenPairs {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< n x count, orthonormal; the largest component of each is positive
};
EigenPairs lowest_eigenpairs(Eigen::MatrixXd matrix, int count);

}  // namespace klang::datasets::detail
