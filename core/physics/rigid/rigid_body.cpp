#include "core/physics/rigid/rigid_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/physics/rigid/detail/convex_hull.hpp"

namespace klang::rigid {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Principal moments that a body can have: positive, none above the sum of the others.
bool possible(const Matrix3d& inertia) {
  const Vector3d m = Eigen::SelfAdjointEigenSolver<Matrix3d>(inertia).eigenvalues();
  return m[0] > 0 && m[2] <= (m[0] + m[1]) * (1 + 1e-9);
}

Matrix3d about(const Vector3d& offset) {
  return offset.squaredNorm() * Matrix3d::Identity() - offset * offset.transpose();
}

}  // namespace

double RigidBodySpec::smallest_half_width_m() const {
  double smallest = ball_radius_m > 0 ? ball_radius_m : HUGE_VAL;
  for (const ConvexPart& part : parts) {
    const Vector3d extent = part.corners_m.rowwise().maxCoeff() - part.corners_m.rowwise().minCoeff();
    for (int i = 0; i < 3; ++i) {
      if (extent[i] > 0) smallest = std::min(smallest, extent[i] / 2);
    }
  }
  return smallest;
}

double RigidBodySpec::touch_radius_m() const {
  constexpr double kRoundEdge = 0.1;
  return ball_radius_m > 0 ? ball_radius_m : kRoundEdge * smallest_half_width_m();
}

Matrix3d RigidBodySpec::curvature_at(const Vector3d& place_m, const Vector3d& outward) const {
  if (curvature && !(skin.radius_m > 0) && !(ball_radius_m > 0))
    if (const auto known = curvature(place_m, outward)) return *known;
  const double radius_m = skin.radius_m > 0 ? skin.radius_m : touch_radius_m();
  return (Matrix3d::Identity() - outward * outward.transpose()) / radius_m;
}

double RigidBodySpec::size_m() const {
  double farthest = ball_radius_m;
  for (const ConvexPart& part : parts) {
    farthest = std::max(farthest, (part.corners_m.colwise() - centre_m).colwise().norm().maxCoeff());
  }
  return 2 * farthest;
}

void RigidBodySpec::validate() const {
  const std::string place = "body " + name;
  checked_open(place, "mass_kg", mass_kg, 0, 1e12);
  if (!inertia_kg_m2.allFinite() || !(inertia_kg_m2 - inertia_kg_m2.transpose()).isZero(1e-9 * inertia_kg_m2.norm()) ||
      !possible(inertia_kg_m2)) {
    throw InputError(place, "no body has these moments of inertia", "",
                     "symmetric, positive, none above the sum of the two others");
  }
  checked(place, "ball_radius_m", ball_radius_m, 0, 1e6);
  if ((ball_radius_m > 0) == !parts.empty()) throw InputError(place, "needs convex parts, or the radius of a ball");
  for (const ConvexPart& part : parts) {
    if (part.corners_m.cols() < 2 || !part.corners_m.allFinite())
      throw InputError(place, "a convex part needs two corners or more, all finite");
  }
  checked(place, "restitution", skin.restitution, 0, 1);
  checked(place, "friction", skin.friction, 0, 100);
  checked_open(place, "youngs_modulus_pa", skin.youngs_modulus_pa, 0, 1e15);
  checked_open(place, "poissons_ratio", skin.poissons_ratio, -1, 0.5);
  checked(place, "radius_m", skin.radius_m, 0, 1e6);
  for (const Vector3d* v : {&position_m, &velocity_m_s, &angular_velocity_rad_s, &centre_m}) {
    for (int i = 0; i < 3; ++i) checked(place, "position or velocity", (*v)[i], -1e9, 1e9);
  }
  if (!(std::abs(orientation.norm() - 1) <= 1e-6)) throw InputError(place, "orientation is not a unit quaternion");
}

double pair_restitution(const Skin& a, const Skin& b) { return std::min(a.restitution, b.restitution); }
double pair_friction(const Skin& a, const Skin& b) { return std::min(a.friction, b.friction); }

void set_mass_from_parts(RigidBodySpec& body, double density_kg_m3) {
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  std::vector<mesh::MassProperties> all;
  for (const ConvexPart& part : body.parts) {
    all.push_back(mesh::mass_properties(detail::convex_hull(part.corners_m)));
    volume += all.back().volume_m3;
    first += all.back().volume_m3 * all.back().centre_m;
  }
  body.centre_m = first / volume;
  body.mass_kg = density_kg_m3 * volume;
  body.inertia_kg_m2.setZero();
  for (const mesh::MassProperties& m : all) {
    body.inertia_kg_m2 += density_kg_m3 * (m.inertia_m5 + m.volume_m3 * about(m.centre_m - body.centre_m));
  }
}

RigidBodySpec ball(std::string name, double radius_m, double mass_kg) {
  RigidBodySpec body;
  body.name = std::move(name);
  body.mass_kg = mass_kg;
  body.ball_radius_m = radius_m;
  body.inertia_kg_m2 = 0.4 * mass_kg * radius_m * radius_m * Matrix3d::Identity();
  return body;
}

RigidBodySpec cuboid(std::string name, const Vector3d& sides_m, double mass_kg) {
  RigidBodySpec body;
  body.name = std::move(name);
  body.mass_kg = mass_kg;
  ConvexPart part;
  part.corners_m.resize(3, 8);
  for (int i = 0; i < 8; ++i) {
    part.corners_m.col(i) = 0.5 * sides_m.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  }
  body.parts.push_back(std::move(part));
  const Vector3d sq = sides_m.cwiseAbs2();
  body.inertia_kg_m2 = Vector3d(sq.y() + sq.z(), sq.z() + sq.x(), sq.x() + sq.y()).asDiagonal();
  body.inertia_kg_m2 *= mass_kg / 12;
  return body;
}

}  // namespace klang::rigid
