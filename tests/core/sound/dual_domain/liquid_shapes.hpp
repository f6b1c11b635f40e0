#pragma once
// Boundaries of liquids with known fields, and those fields. Nothing here uses the code under test.
#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

#include "core/sound/bem/radiating_surface.hpp"
#include "core/sound/dual_domain/boundary_patches.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::test {

using Complex = std::complex<double>;

/// Free ball, vertices on the sphere.
inline bubble::BoundaryMesh ball(double radius_m, int divisions,
                                 const Eigen::Vector3d& centre_m = Eigen::Vector3d::Zero()) {
  bubble::BoundaryMesh mesh;
  mesh.name = "ball";
  mesh.surface = acoustics::geodesic_sphere(radius_m, divisions);
  for (Eigen::Index i = 0; i < mesh.surface.vertices_m.rows(); ++i)
    mesh.surface.vertices_m.row(i) = centre_m.transpose() + radius_m * mesh.surface.vertices_m.row(i).normalized();
  mesh.region.assign(static_cast<std::size_t>(mesh.surface.triangles.rows()), 0);
  return mesh;
}

/// Box [0, size] in x and y, [-depth, 0] in z, faces cut into squares of about h: free top, the rest rigid.
inline bubble::BoundaryMesh tank(const Eigen::Vector3d& size_m, double h_m) {
  bubble::BoundaryPatches patches;
  patches.add_tank({0.0, 0.0, -size_m.z()}, size_m, h_m);
  return patches.mesh("tank");
}

/// dP/dz on the free top of a closed rigid tank with a unit source s = -e^{-ikR} / (4 pi R): the sum over images, below the first
/// vertical resonance (k < pi / (2 depth)), where all of the field decays sideways. Close images by the vertical ones, whose
/// slowly falling tail is cut smoothly; far ones by the vertical modes, sin((m + 1/2) pi z / depth) K_0.
class TankImages {
 public:
  TankImages(const Eigen::Vector3d& size_m, double wavenumber_per_m) : size_(size_m), k_(wavenumber_per_m) {}

  double top_slope(double x, double y, const Eigen::Vector3d& source_m) const {
    double sum = 0.0;
    for (int i = -4; i <= 4; ++i)
      for (int j = -4; j <= 4; ++j)
        for (const int p : {-1, 1})
          for (const int q : {-1, 1}) {
            const double rho =
                std::hypot(x - p * source_m.x() - 2.0 * size_.x() * i, y - q * source_m.y() - 2.0 * size_.y() * j);
            if (rho < 1.6) sum += layer(rho, -source_m.z());
          }
    return sum;
  }

  /// The same of one source in an endless layer, at depth d.
  double layer(double rho, double d) const { return rho > 0.3 * size_.z() ? by_modes(rho, d) : by_images(rho, d); }

  double by_modes(double rho, double d) const {
    double sum = 0.0;
    for (int m = 0; m < 80; ++m) {
      const double kz = (m + 0.5) * std::numbers::pi / size_.z(), kappa = std::sqrt(kz * kz - k_ * k_);
      if (kappa * rho > 40.0) break;
      sum += std::sin(kz * d) * kz * std::cyl_bessel_k(0.0, kappa * rho);
    }
    return sum / (std::numbers::pi * size_.z());
  }

  double by_images(double rho, double d) const {
    constexpr int kPeriods = 80;
    const double h = size_.z(), depths[] = {d, 2 * h - d, 2 * h + d, 4 * h - d}, signs[] = {1, 1, -1, -1};
    Complex sum = 0.0;
    for (int n = -kPeriods; n <= kPeriods; ++n) {
      const double t = std::abs(n) / (kPeriods + 1.0),
                   taper = t < 0.3 ? 1.0 : 0.5 * (1.0 + std::cos(std::numbers::pi * (t - 0.3) / 0.7));
      for (int q = 0; q < 4; ++q) {
        const double z = depths[q] + 4.0 * h * n, r = std::hypot(rho, z);
        sum +=
            taper * signs[q] * std::polar(1.0 / (4.0 * std::numbers::pi * r), -k_ * r) * Complex(1.0 / r, k_) * (z / r);
      }
    }
    return sum.real();
  }

 private:
  Eigen::Vector3d size_;
  double k_;
};

}  // namespace klang::test
