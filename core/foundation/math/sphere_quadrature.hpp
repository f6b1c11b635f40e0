#pragma once
#include <Eigen/Core>

namespace klang {

/// Directions and weights that integrate over the unit sphere every spherical harmonic to the given degree exactly:
/// Gauss-Legendre in cos(theta), equal steps in phi; (degree / 2 + 1)(degree + 1) points.
struct SphereQuadrature {
  Eigen::Matrix3Xd directions;
  Eigen::VectorXd weights;  ///< sum = 4 pi
};
SphereQuadrature sphere_quadrature(int degree);

/// Abscissae in (-1, 1), rising, and weights of the n-point Gauss-Legendre rule (Newton on P_n from the asymptotic roots).
void gauss_legendre(int n, Eigen::VectorXd& abscissae, Eigen::VectorXd& weights);

}  // namespace klang
