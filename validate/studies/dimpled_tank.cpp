#include "validate/studies/dimpled_tank.hpp"

#include <cmath>

#include "core/sound/dual_domain/boundary_patches.hpp"

namespace klang::validate::detail {

double DimpledTank::height_m(double x, double y) const {
  const double t = (x * x + y * y) / (width_m * width_m);
  return -dimple_m * (1.0 - t) * std::exp(-t);
}

bool DimpledTank::inside(const Eigen::Vector3d& x_m) const {
  return std::abs(x_m.x()) < 0.5 * side_m && std::abs(x_m.y()) < 0.5 * side_m && x_m.z() > -depth_m &&
         x_m.z() < height_m(x_m.x(), x_m.y());
}

bubble::BoundaryMesh DimpledTank::mesh(double h_m) const {
  bubble::BoundaryPatches patches;
  // The height of the top is put on vertices at z = 0, those of the walls' upper edges too.
  patches.add_tank({-0.5 * side_m, -0.5 * side_m, -depth_m}, {side_m, side_m, depth_m}, h_m,
                   [&](const Eigen::Vector3d& x) {
                     return Eigen::Vector3d(x.x(), x.y(), std::abs(x.z()) < 1e-12 ? height_m(x.x(), x.y()) : x.z());
                   });
  return patches.mesh("dimpled tank");
}

}  // namespace klang::validate::detail
