#pragma once
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid {

inline Skin skin(double restitution, double friction) {
  Skin s;
  s.restitution = restitution;
  s.friction = friction;
  return s;
}

/// A hull of 14 corners on a sphere, 2500 kg/m^3, which lands on a corner, an edge or a face by its turn.
inline RigidBodySpec stone(double radius_m) {
  RigidBodySpec body;
  body.name = "stone";
  ConvexPart part;
  part.corners_m.resize(3, 14);
  const double golden = kPi * (3 - std::sqrt(5.0));
  for (int i = 0; i < 14; ++i) {
    const double z = 1 - (2 * i + 1) / 14.0, r = std::sqrt(1 - z * z);
    part.corners_m.col(i) = radius_m * Eigen::Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  body.parts.push_back(part);
  set_mass_from_parts(body, 2500);
  return body;
}

/// A coin of brass, 24 mm across and 1.8 mm thick, as a prism of 32 sides.
inline RigidBodySpec coin() {
  constexpr double kRadius = 0.012, kHalfThick = 0.0009;
  RigidBodySpec body;
  body.name = "coin";
  ConvexPart part;
  part.corners_m.resize(3, 64);
  for (int i = 0; i < 32; ++i)
    for (int end = 0; end < 2; ++end)
      part.corners_m.col(2 * i + end) << kRadius * std::cos(kPi * i / 16), kRadius * std::sin(kPi * i / 16),
          end == 0 ? -kHalfThick : kHalfThick;
  body.parts.push_back(part);
  set_mass_from_parts(body, 8500);
  return body;
}

}  // namespace klang::rigid
