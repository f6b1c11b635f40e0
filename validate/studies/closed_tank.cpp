#include "validate/studies/closed_tank.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/dual_domain/boundary_patches.hpp"

namespace klang::validate::detail {
namespace {
using Complex = std::complex<double>;
using Eigen::Vector3d;
}  // namespace

bubble::BoundaryMesh ClosedTank::mesh(double h_m) const {
  bubble::BoundaryPatches patches;
  patches.add_tank({0.0, 0.0, -size_m.z()}, size_m, h_m);
  return patches.mesh("closed tank");
}

Complex ClosedTank::top_slope(double x, double y, const Vector3d& source_m, Complex wavenumber_per_m) const {
  constexpr double kEnough = 33.0;  // e^-33 is round-off
  const double depth = -source_m.z(), height = size_m.z();
  Complex sum = 0.0;
  for (int m = 0; m * kPi / size_m.x() * depth < kEnough + 1.0; ++m) {
    const double kx = m * kPi / size_m.x();
    const double along = (m == 0 ? 1.0 : 2.0) * std::cos(kx * x) * std::cos(kx * source_m.x());
    for (int n = 0;; ++n) {
      const double ky = n * kPi / size_m.y();
      const Complex kappa = std::sqrt(kx * kx + ky * ky - wavenumber_per_m * wavenumber_per_m);
      if (kappa.real() * depth > kEnough) break;
      // cosh(kappa (H - d)) / cosh(kappa H) without overflow
      const Complex ratio = std::exp(-kappa * depth) * (1.0 + std::exp(-2.0 * kappa * (height - depth))) /
                            (1.0 + std::exp(-2.0 * kappa * height));
      sum += along * (n == 0 ? 1.0 : 2.0) * std::cos(ky * y) * std::cos(ky * source_m.y()) * ratio;
    }
  }
  return sum / (size_m.x() * size_m.y());
}

std::vector<Complex> forward_from_images(const ClosedTank& tank, double h_m, double frequency_hz,
                                         const Vector3d& source_m, const std::vector<Vector3d>& points_m,
                                         Monitor& monitor) {
  const bubble::LiquidBoundary boundary(tank.mesh(h_m));
  const acoustics::HelmholtzBem solver(acoustics::radiating_surface(boundary.surface()));
  const acoustics::RadiatingSurface& s = solver.surface();
  constexpr double kDensity = 1000.0, kSpeed = 1497.0;
  const double omega = 2.0 * kPi * frequency_hz;
  Eigen::MatrixXcd velocity = Eigen::MatrixXcd::Zero(3 * s.n_triangles(), 1);
  parallel_for(static_cast<std::size_t>(s.n_triangles()), 16, [&](std::size_t begin, std::size_t end) {
    for (auto t = static_cast<int>(begin); t < static_cast<int>(end); ++t) {
      if (!(s.centroids_m(2, t) > -1e-9 * tank.size_m.z())) continue;
      for (int c = 0; c < 3; ++c)  // dP/dn = -i omega rho v_n
        velocity(3 * t + c, 0) = tank.top_slope(s.corner(t, c).x(), s.corner(t, c).y(), source_m, omega / kSpeed) *
                                 Complex(0.0, 1.0 / (omega * kDensity));
    }
  });
  acoustics::BemOptions options;
  options.allow_coarse = true;
  options.n_blas_threads = 1;
  const acoustics::BemResult air = solver.solve(frequency_hz, velocity, options, monitor);
  if (!air.usable()) throw NumericalError("closed tank: " + air.message);
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(points_m.size()));
  for (std::size_t i = 0; i < points_m.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = points_m[i];
  const Eigen::VectorXcd pressure = solver.pressure_at(air, points);
  return {pressure.data(), pressure.data() + pressure.size()};
}

}  // namespace klang::validate::detail
