#include "core/physics/rigid/detail/part_touches.hpp"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <cmath>

#include "core/physics/rigid/contact.hpp"
#include "core/physics/rigid/detail/ball_touches.hpp"
#include "core/physics/rigid/detail/hull_touches.hpp"

namespace klang::rigid::detail {

using Eigen::Vector3d;

namespace {

btVector3 bullet_vector(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d eigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Whether a point lies in a hull.
bool holds(const HullFeatures& hull, const Vector3d& point) {
  constexpr double kOnIt = 1e-13;  // of the size
  return ((hull.normals.transpose() * point) - hull.offsets).maxCoeff() <= kOnIt * hull.size;
}

class Touches {
 public:
  Touches(const PlacedPart& a, const PlacedPart& b, double near, std::vector<Contact>& found)
      : a_(a), b_(b), near_(near), found_(found) {}

  /// @param known  what was found last, or none; becomes what is found now
  void find(KnownPair* known) {
    const CollisionPart &a = *a_.part, &b = *b_.part;
    if (a.radius > 0 && b.radius > 0) return balls();
    if (a.radius > 0 && b.features) return ball_on_hull(a_, b_, 1.0);
    if (b.radius > 0 && a.features) return ball_on_hull(b_, a_, -1.0);
    if (a.features && b.features) return hulls(known);
    flat();
  }

 private:
  void add(const Vector3d& place, const Vector3d& normal, double gap) {
    if (!(gap <= near_)) return;
    Contact& c = found_.emplace_back();
    c.a = a_.part->body;
    c.b = b_.part->body;
    c.parts = {a_.part->number, b_.part->number};
    c.place = place;
    c.normal = normal;
    c.gap = gap;
  }

  void balls() {
    const Vector3d apart = a_.place.translation() - b_.place.translation();
    const double distance = apart.norm(), radius_a = a_.part->radius, radius_b = b_.part->radius;
    const Vector3d normal = distance > 0 ? Vector3d(apart / distance) : Vector3d(Vector3d::UnitZ());
    const double gap = distance - radius_a - radius_b;
    add(b_.place.translation() + (radius_b + 0.5 * gap) * normal, normal, gap);
  }

  /// @param sign  1 where the ball is a
  void ball_on_hull(const PlacedPart& ball, const PlacedPart& hull, double sign) {
    const Vector3d centre = ball.place.translation();
    const Vector3d own = hull.place.linear().transpose() * (centre - hull.place.translation());
    const NearestPlace nearest = nearest_place(*hull.part->features, own);
    const double gap = nearest.distance - ball.part->radius;
    if (!(gap <= near_)) return;
    const Vector3d outward = hull.place.linear() * nearest.outward;
    add(hull.place * nearest.place + 0.5 * gap * outward, sign * outward, gap);
  }

  /// The axis along which they overlap least, then where they touch along it. Most pairs whose boxes meet are parted by the axis that
  /// parted them a step ago.
  void hulls(KnownPair* known) {
    const HullFeatures &a = *a_.part->features, &b = *b_.part->features;
    const Eigen::Isometry3d b_to_a = a_.place.inverse() * b_.place;
    HullHint hint;
    if (known != nullptr) {
      hint = {known->on_a, known->on_b, gap_along(a, b, b_to_a, known->axis)};
      // Faces that lie on one another are apart by a last digit as often as not.
      if (hint.gap > near_) {
        known->touched = false;
        return;
      }
    }
    const HullAxis axis = hull_axis(a, b, b_to_a, near_, known != nullptr && known->touched ? &hint : nullptr);
    if (known != nullptr) {
      known->axis = axis.normal;
      known->touched = axis.gap <= near_;
    }
    if (axis.gap > near_) return;
    const Vector3d normal = a_.place.linear() * axis.normal;
    double deepest = HUGE_VAL;
    for (const HullTouch& touch : hull_touches(a, b, b_to_a, axis, near_)) {
      add(a_.place * touch.on_b + 0.5 * touch.gap * normal, normal, touch.gap);
      if (known == nullptr || !(touch.gap < deepest)) continue;
      deepest = touch.gap;
      known->on_a = touch.on_b + touch.gap * axis.normal;
      known->on_b = b_to_a.inverse() * touch.on_b;
    }
    if (known != nullptr)
      known->touched = known->touched && deepest < HUGE_VAL && holds(a, known->on_a) && holds(b, known->on_b);
  }

  void flat() {
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
    btGjkPairDetector detector(a_.part->shape.get(), b_.part->shape.get(), &simplex, &depth);
    btGjkPairDetector::ClosestPointInput input;
    const auto place = [](const PlacedPart& of) {
      const Eigen::Quaterniond turn(of.place.linear());
      return btTransform({turn.x(), turn.y(), turn.z(), turn.w()}, bullet_vector(of.place.translation()));
    };
    input.m_transformA = place(a_);
    input.m_transformB = place(b_);
    btPointCollector nearest;
    detector.getClosestPoints(input, nearest, nullptr);
    if (!nearest.m_hasResult) return;
    const Vector3d normal = eigen(nearest.m_normalOnBInWorld);
    add(eigen(nearest.m_pointInWorld) + 0.5 * nearest.m_distance * normal, normal, nearest.m_distance);
  }

  const PlacedPart &a_, &b_;
  double near_;
  std::vector<Contact>& found_;
};

/// Where a plane across that direction touches: the farthest place, or eight of a disc that lies flat on it.
std::vector<Vector3d> lowest_of(const mesh::RoundSurface& surface, const Vector3d& down) {
  constexpr double kFlat = 1e-5;  // inner length, between the two ends of a disc
  constexpr int kPlaces = 8;
  if (down.dot(surface.pole) < surface.least_cosine) return {};
  if (!surface.is_disc() || 2 * surface.half_width_m(down) > kFlat) return {surface.farthest_m(down)};
  std::vector<Vector3d> places;
  for (int i = 0; i < kPlaces; ++i) {
    const double angle = 2 * M_PI * i / kPlaces;
    places.push_back(surface.centre_m + std::cos(angle) * surface.axes_m.col(0) +
                     std::sin(angle) * surface.axes_m.col(1));
  }
  return places;
}

}  // namespace

void add_touches(const PlacedPart& a, const PlacedPart& b, double near, KnownPair* known, std::vector<Contact>& found) {
  Touches(a, b, near, found).find(known);
}

/// As tight as can be: of a stone's box turned with it half the volume is empty, and pairs are many.
PartBox box_of(const CollisionPart& part, const PlacedPart& placed, double slop) {
  const Vector3d& centre = placed.place.translation();
  if (part.radius > 0) {
    const Vector3d half = Vector3d::Constant(part.radius + slop);
    return {centre - half, centre + half, part.body, part.moves};
  }
  PartBox box{centre, centre, part.body, part.moves};
  for (int i = 0; i < 3; ++i) {
    const auto row = placed.place.linear().row(i);
    const auto heights = row[0] * part.by_axis.col(0) + row[1] * part.by_axis.col(1) + row[2] * part.by_axis.col(2);
    box.low[i] += heights.minCoeff() - slop;
    box.high[i] += heights.maxCoeff() + slop;
  }
  return box;
}

void add_floor_contacts(const CollisionPart& part, const BodyState& body, double slop, std::vector<Contact>& contacts) {
  const auto add = [&](const Vector3d& lowest) {
    if (!(lowest.z() <= slop)) return;
    Contact c;
    c.a = part.body;
    c.b = kFloor;
    c.parts = {part.number, 0};
    c.place = lowest;
    c.normal = Vector3d::UnitZ();
    c.gap = lowest.z();
    contacts.push_back(c);
  };
  if (part.radius > 0) return add(body.centre - part.radius * Vector3d::UnitZ());
  if (body.centre.z() - part.floor_radius > slop) return;
  const Eigen::Matrix3d r = body.turn.toRotationMatrix();
  const Vector3d down = -r.row(2).transpose();
  for (const mesh::RoundSurface& surface : part.round)
    for (const Vector3d& lowest : lowest_of(surface, down)) add(body.centre + r * lowest);
  const double near = slop + 1e-9 * part.floor_radius;
  for (Eigen::Index i = 0; i < part.on_floor.cols(); ++i)
    if (body.centre.z() + r.row(2).dot(part.on_floor.col(i)) <= near) add(body.centre + r * part.on_floor.col(i));
}

}  // namespace klang::rigid::detail
