#pragma once
// Exact fields on closed surfaces with an exact quadrature, for tests: no boundary elements involved.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

// Gauss-Legendre rule on [-1, 1] (Golub and Welsch 1969).
inline void gauss_legendre(int n, Eigen::VectorXd& x, Eigen::VectorXd& w) {
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  for (int i = 1; i < n; ++i) jacobi(i, i - 1) = jacobi(i - 1, i) = i / std::sqrt(4.0 * i * i - 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(jacobi);
  x = solver.eigenvalues();
  w = 2.0 * solver.eigenvectors().row(0).array().square().transpose();
}

// An ellipsoid with the given half axes and n x 2n points; spectrally exact for smooth fields.
inline SurfaceField ellipsoid_points(const Eigen::Vector3d& axes_m, int n,
                                     const Eigen::Vector3d& centre_m = Eigen::Vector3d::Zero()) {
  Eigen::VectorXd z, w;
  gauss_legendre(n, z, w);
  SurfaceField field;
  const Eigen::Index size = 2 * n * n;
  field.points_m.resize(3, size);
  field.normals.resize(3, size);
  field.weights_m2.resize(size);
  field.pressure_pa.resize(size);
  field.normal_velocity_m_s.resize(size);
  Eigen::Index i = 0;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < 2 * n; ++b, ++i) {
      const double phi = kPi * b / n, s = std::sqrt(1.0 - z[a] * z[a]);
      const Eigen::Vector3d unit(s * std::cos(phi), s * std::sin(phi), z[a]);
      field.points_m.col(i) = centre_m + axes_m.cwiseProduct(unit);
      const Eigen::Vector3d area = axes_m.prod() * unit.cwiseQuotient(axes_m);  // dS n / (d cos theta d phi)
      field.normals.col(i) = area.normalized();
      field.weights_m2[i] = w[a] * kPi / n * area.norm();
    }
  }
  return field;
}

// Fills pressure and normal velocity from a field with its gradient: v = (i / (omega rho)) grad p.
using ExactField = std::function<std::complex<double>(const Eigen::Vector3d& x, Eigen::Vector3cd& gradient)>;
inline void set_field(SurfaceField& field, const ExactField& exact, double k, const Medium& medium) {
  const std::complex<double> by_gradient(0.0, 1.0 / (k * medium.sound_speed_m_s * medium.density_kg_m3));
  for (Eigen::Index i = 0; i < field.points_m.cols(); ++i) {
    Eigen::Vector3cd gradient;
    field.pressure_pa[i] = exact(field.points_m.col(i), gradient);
    const Eigen::Vector3d normal = field.normals.col(i);
    field.normal_velocity_m_s[i] = by_gradient * (gradient.transpose() * normal.cast<std::complex<double>>())(0);
  }
}

// strength e^{-ikr} / r around a point.
inline ExactField monopole_field(const Eigen::Vector3d& at, double k, std::complex<double> strength = 1.0) {
  return [=](const Eigen::Vector3d& x, Eigen::Vector3cd& gradient) {
    const Eigen::Vector3d d = x - at;
    const double r = d.norm();
    const std::complex<double> p = strength * std::exp(std::complex<double>(0.0, -k * r)) / r;
    gradient = p * std::complex<double>(-1.0 / r, -k) * (d / r).cast<std::complex<double>>();
    return p;
  };
}

}  // namespace klang::acoustics
