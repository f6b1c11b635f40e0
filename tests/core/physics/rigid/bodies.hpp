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

}  // namespace klang::rigid
