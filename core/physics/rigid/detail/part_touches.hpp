#pragma once
#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <vector>

#include "core/geometry/mesh/round_surface.hpp"
#include "core/physics/rigid/detail/box_pairs.hpp"
#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/detail/hull_axis.hpp"

namespace klang::rigid::detail {

/// A convex part as it collides.
struct CollisionPart {
  int body = 0, number = 0;
  Eigen::Matrix3Xd corners;               // from the centre of mass, body axes; of a ball none
  Eigen::Matrix3Xd on_floor;              // corners that no earlier part of the body has
  std::vector<mesh::RoundSurface> round;  // in place of these, of the whole body, with its first part
  double floor_radius = 0.0;              // of the farthest of these
  double radius = 0.0;                    // of a ball
  Eigen::MatrixX3d by_axis;               // the corners, one per row
  bool moves = true;
  std::unique_ptr<HullFeatures> features;
  std::unique_ptr<btConvexShape> shape;  // of a ball, and of a hull without volume
};

/// A part where its body stands.
struct PlacedPart {
  const CollisionPart* part = nullptr;
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
};

/// Where a body's parts are among all.
struct PlacedBody {
  int body = 0;
  std::size_t first = 0, last = 0;
};

using PartPair = std::array<int, 2>;

/// Two parts whose boxes meet, and the axis along which they overlapped least, or which parted them, last.
struct KnownPair {
  std::array<int, 4> key{};                                                        // bodies, parts
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();                                 // in the first one's frame
  bool touched = false;                                                            // else the axis parted them
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero(), on_b = Eigen::Vector3d::Zero();  // where, each in its own frame
};

PartBox box_of(const CollisionPart& part, const PlacedPart& placed, double slop);

/// Points of two parts with a gap of at most near.
/// @param known  what was found last, or none; becomes what is found now
void add_touches(const PlacedPart& a, const PlacedPart& b, double near, KnownPair* known, std::vector<Contact>& found);

/// Points of a part with the plane z = 0.
void add_floor_contacts(const CollisionPart& part, const BodyState& body, double slop, std::vector<Contact>& contacts);

}  // namespace klang::rigid::detail
