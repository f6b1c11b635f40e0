#include "core/physics/liquid/liquid_setup.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector3d;

double box_distance(const Vector3d& x, const Vector3d& low, const Vector3d& high) {
  const Vector3d q = (x - 0.5 * (low + high)).cwiseAbs() - 0.5 * (high - low);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

double pool_phi(const Pool& pool, const Vector3d& size, const Vector3d& x) {
  Vector3d low = pool.low_m, high = pool.high_m;
  for (int axis = 0; axis < 3; ++axis) {  // walls are no surface
    if (low[axis] <= 1e-9 * size[axis]) low[axis] = -10.0 * size.maxCoeff();
    if (high[axis] >= (1.0 - 1e-9) * size[axis]) high[axis] = 10.0 * size.maxCoeff();
  }
  const bool level = low.maxCoeff() < 0.0 && high.x() > size.x() && high.y() > size.y();
  if (!level) return box_distance(x, low, high);
  if (!pool.wave) return x.z() - high.z();
  const double kx = pool.wave->half_waves_x * kPi / size.x(), ky = pool.wave->half_waves_y * kPi / size.y();
  const double a = pool.wave->amplitude_m;
  const double surface = high.z() + a * std::cos(kx * x.x()) * std::cos(ky * x.y());
  const double sx = a * kx * std::sin(kx * x.x()) * std::cos(ky * x.y()),
               sy = a * ky * std::cos(kx * x.x()) * std::sin(ky * x.y());
  return (x.z() - surface) / std::sqrt(1.0 + sx * sx + sy * sy);
}

}  // namespace

double Inlet::area_m2() const {
  if (radius_m) return kPi * *radius_m * *radius_m;
  double area = 1.0;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(direction[axis]) < 0.5) area *= size_m[axis];
  return area;
}

Solid Inlet::mouthpiece(double cell_m) const {
  Solid solid;
  const double length = 2.0 * cell_m;
  solid.position_m = position_m - 0.5 * length * direction;
  if (radius_m) {
    solid.shape = SolidShape::kCylinder;
    solid.radius_m = *radius_m;
    solid.normal = direction;
    solid.size_m = Vector3d(length, 0.0, 0.0);
  } else {
    solid.shape = SolidShape::kBox;
    solid.size_m = size_m + length * direction.cwiseAbs();
  }
  solid.streams = true;
  solid.name = "inlet";
  return solid;
}

double LiquidSetup::phi_m(const Vector3d& x) const {
  double phi = 10.0 * shape.size_m().maxCoeff();
  for (const Pool& pool : pools) phi = std::min(phi, pool_phi(pool, shape.size_m(), x));
  for (const Drop& drop : drops) phi = std::min(phi, (x - drop.position_m).norm() - drop.radius_m);
  return phi;
}

std::vector<Solid> LiquidSetup::all_solids() const {
  std::vector<Solid> all = solids;
  for (const Inlet& inlet : inlets) all.push_back(inlet.mouthpiece(shape.cell_m));
  return all;
}

double Outlet::distance_m(const Vector3d& x_m) const { return box_distance(x_m, low_m, high_m); }

}  // namespace klang::liquid
