#include "core/physics/rigid/detail/collisions.hpp"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/rigid/detail/ball_touches.hpp"
#include "core/physics/rigid/detail/box_pairs.hpp"
#include "core/physics/rigid/detail/contact_patches.hpp"
#include "core/physics/rigid/detail/hull_touches.hpp"

namespace klang::rigid::detail {
using Eigen::Vector3d;

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

/// Two parts whose boxes meet, and the axis along which they overlapped least, or which parted them, last.
struct KnownPair {
  std::array<int, 4> key{};                                   // bodies, parts
  Vector3d axis = Vector3d::UnitZ();                          // in the first one's frame
  bool touched = false;                                       // else the axis parted them
  Vector3d on_a = Vector3d::Zero(), on_b = Vector3d::Zero();  // where, each in its own frame
};

namespace {

btVector3 bullet(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d eigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

std::unique_ptr<btConvexShape> hull_of(const Eigen::Matrix3Xd& corners) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (Eigen::Index i = 0; i < corners.cols(); ++i) hull->addPoint(bullet(corners.col(i)), false);
  hull->recalcLocalAabb();
  hull->setMargin(0.0);  // a margin rounds the corners; in double precision distances need none
  return hull;
}

/// Nothing for a hull without volume.
std::unique_ptr<HullFeatures> features_of(const Eigen::Matrix3Xd& corners) {
  const Eigen::Matrix3Xd spread = corners.colwise() - corners.rowwise().mean();
  if (corners.cols() < 4 || !((spread * spread.transpose()).determinant() > 0)) return nullptr;
  btConvexHullComputer hull;
  hull.compute(corners.data(), static_cast<int>(3 * sizeof(double)), static_cast<int>(corners.cols()), 0.0, 0.0);
  std::vector<std::vector<int>> faces;
  for (int f = 0; f < hull.faces.size(); ++f) {
    std::vector<int> face;
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[f]];
    const btConvexHullComputer::Edge* edge = first;
    do {
      face.push_back(hull.original_vertex_index[edge->getSourceVertex()]);
      edge = edge->getNextEdgeOfFace();
    } while (edge != first);
    faces.push_back(std::move(face));
  }
  auto features = std::make_unique<HullFeatures>(corners, faces);
  return features->normals.cols() >= 4 ? std::move(features) : nullptr;
}

/// Parts that meet share corners, which touch the floor once.
Eigen::Matrix3Xd corners_of_its_own(const Eigen::Matrix3Xd& corners, const std::vector<CollisionPart>& earlier) {
  const double near = 1e-9 * corners.colwise().norm().maxCoeff();
  std::vector<Eigen::Index> own;
  for (Eigen::Index i = 0; i < corners.cols(); ++i) {
    const bool known = std::any_of(earlier.begin(), earlier.end(), [&](const CollisionPart& part) {
      return part.on_floor.cols() > 0 && (part.on_floor.colwise() - corners.col(i)).colwise().norm().minCoeff() <= near;
    });
    if (!known) own.push_back(i);
  }
  return corners(Eigen::all, own);
}

/// A body's place; its part's frame is the body's axes about the centre of mass.
Eigen::Isometry3d place_of(const BodyState& body) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.linear() = body.turn.toRotationMatrix();
  place.translation() = body.centre;
  return place;
}

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
      return btTransform({turn.x(), turn.y(), turn.z(), turn.w()}, bullet(of.place.translation()));
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

void sort(std::vector<Contact>& contacts) {
  const auto key = [](const Contact& c) {
    return std::tuple(c.a, c.b, c.parts[0], c.parts[1], c.place.x(), c.place.y(), c.place.z());
  };
  std::sort(contacts.begin(), contacts.end(), [&](const Contact& x, const Contact& y) { return key(x) < key(y); });
}

}  // namespace

struct Collisions::State {
  std::map<int, std::vector<CollisionPart>> parts;
  std::vector<PlacedPart> placed;  // of the last search, body after body
  std::vector<PartBox> boxes;
  std::map<int, std::size_t> first;  // of a body's parts among these
  double slop = 0.0;
  BoxPairs box_pairs;
  std::vector<KnownPair> known;  // sorted

  KnownPair* of(const CollisionPart& a, const CollisionPart& b);
  void place(const std::vector<BodyState>& bodies);
  std::vector<KnownPair> meeting();
};

void Collisions::State::place(const std::vector<BodyState>& bodies) {
  placed.clear();
  boxes.clear();
  for (const auto& [number, its] : parts) {
    first[number] = placed.size();
    const Eigen::Isometry3d place = place_of(bodies[static_cast<std::size_t>(number)]);
    for (const CollisionPart& part : its) {
      placed.push_back({&part, place});
      boxes.push_back(box_of(part, placed.back(), slop));
    }
  }
}

/// With the axes of those that met last time.
std::vector<KnownPair> Collisions::State::meeting() {
  std::vector<KnownPair> now;
  auto old = known.begin();
  for (const auto& [i, j] : box_pairs.find(boxes)) {
    const CollisionPart &a = *placed[static_cast<std::size_t>(i)].part, &b = *placed[static_cast<std::size_t>(j)].part;
    KnownPair pair;
    pair.key = {a.body, a.number, b.body, b.number};
    while (old != known.end() && old->key < pair.key) ++old;
    if (old != known.end() && old->key == pair.key) pair = *old;
    now.push_back(pair);
  }
  return now;
}

/// What is known of two parts; none: their boxes did not meet in the last search.
KnownPair* Collisions::State::of(const CollisionPart& a, const CollisionPart& b) {
  const std::array<int, 4> key{a.body, a.number, b.body, b.number};
  const auto found =
      std::lower_bound(known.begin(), known.end(), key, [](const KnownPair& x, const auto& k) { return x.key < k; });
  return found != known.end() && found->key == key ? &*found : nullptr;
}

Collisions::Collisions() : state_(std::make_unique<State>()) {}
Collisions::~Collisions() = default;

void Collisions::add(int body, const RigidBodySpec& spec, double scale, bool moves) {
  std::vector<CollisionPart>& parts = state_->parts[body];
  const auto add_part = [&](CollisionPart part) {
    part.body = body;
    part.number = static_cast<int>(parts.size());
    part.moves = moves;
    parts.push_back(std::move(part));
  };
  if (spec.ball_radius_m > 0) {
    CollisionPart part;
    part.radius = scale * spec.ball_radius_m;
    part.shape = std::make_unique<btSphereShape>(part.radius);
    add_part(std::move(part));
  }
  for (const ConvexPart& given : spec.parts) {
    CollisionPart part;
    part.corners = scale * (given.corners_m.colwise() - spec.centre_m);
    part.by_axis = part.corners.transpose();
    part.features = features_of(part.corners);
    if (!part.features) part.shape = hull_of(part.corners);
    if (spec.round.empty()) part.on_floor = corners_of_its_own(part.corners, parts);
    if (part.on_floor.cols() > 0) part.floor_radius = part.on_floor.colwise().norm().maxCoeff();
    if (parts.empty()) {
      for (mesh::RoundSurface surface : spec.round) {
        surface.centre_m = scale * (surface.centre_m - spec.centre_m);
        surface.axes_m *= scale;
        part.floor_radius = std::max(part.floor_radius, surface.centre_m.norm() + surface.axes_m.norm());
        part.round.push_back(surface);
      }
    }
    add_part(std::move(part));
  }
}

void Collisions::remove(int body) {
  State& s = *state_;
  s.parts.erase(body);
  s.placed.clear();
  s.boxes.clear();
}

std::vector<Contact> Collisions::find(const std::vector<BodyState>& bodies, double slop, bool with_floor) {
  State& s = *state_;
  s.slop = slop;
  s.place(bodies);
  std::vector<Contact> contacts;
  for (const PlacedPart& placed : s.placed) {
    const BodyState& body = bodies[static_cast<std::size_t>(placed.part->body)];
    if (with_floor && !body.fixed()) add_floor_contacts(*placed.part, body, slop, contacts);
  }
  s.known = s.meeting();
  constexpr std::size_t kGrain = 256;
  const std::vector<std::array<int, 2>>& pairs = s.box_pairs.last();
  std::vector<std::vector<Contact>> found((pairs.size() + kGrain - 1) / kGrain);
  parallel_for(pairs.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const PlacedPart &a = s.placed[static_cast<std::size_t>(pairs[n][0])],
                       &b = s.placed[static_cast<std::size_t>(pairs[n][1])];
      Touches(a, b, slop, found[begin / kGrain]).find(&s.known[n]);
    }
  });
  for (const std::vector<Contact>& its : found) contacts.insert(contacts.end(), its.begin(), its.end());
  sort(contacts);
  return patch_corners(contacts, bodies, slop);
}

std::vector<Contact> Collisions::find_pair(int a, int b, const BodyState& at_a, const BodyState& at_b,
                                           double slop) const {
  std::vector<Contact> contacts;
  const std::vector<CollisionPart>& of_a = state_->parts.at(a);
  if (b == kFloor) {
    for (const CollisionPart& part : of_a) add_floor_contacts(part, at_a, slop, contacts);
  } else {
    const Eigen::Isometry3d place_b = place_of(at_b);
    std::vector<PlacedPart> parts_b;
    std::vector<PartBox> boxes_b;
    for (const CollisionPart& part : state_->parts.at(b)) {
      parts_b.push_back({&part, place_b});
      boxes_b.push_back(box_of(part, parts_b.back(), slop));
    }
    const Eigen::Isometry3d place_a = place_of(at_a);
    for (const CollisionPart& part : of_a) {
      const PlacedPart placed{&part, place_a};
      const PartBox box = box_of(part, placed, slop);
      for (std::size_t k = 0; k < parts_b.size(); ++k)
        if (meet(box, boxes_b[k])) Touches(placed, parts_b[k], slop, contacts).find(state_->of(part, *parts_b[k].part));
    }
  }
  sort(contacts);
  return contacts;
}

void Collisions::move(int body, const BodyState& there) {
  State& s = *state_;
  const std::size_t first = s.first.at(body);
  const Eigen::Isometry3d place = place_of(there);
  for (std::size_t i = first; i < s.placed.size() && s.placed[i].part->body == body; ++i) {
    s.placed[i].place = place;
    s.boxes[i] = box_of(*s.placed[i].part, s.placed[i], s.slop);
  }
}

std::vector<Contact> Collisions::of_body(int body, const std::vector<int>& without,
                                         const std::vector<BodyState>& bodies, bool with_floor) const {
  State& s = *state_;
  std::vector<Contact> contacts;
  const std::size_t first = s.first.at(body);
  for (std::size_t i = first; i < s.placed.size() && s.placed[i].part->body == body; ++i) {
    if (with_floor) add_floor_contacts(*s.placed[i].part, bodies[static_cast<std::size_t>(body)], s.slop, contacts);
    for (std::size_t k = 0; k < s.placed.size(); ++k) {
      const PartBox& other = s.boxes[k];
      if (!meet(s.boxes[i], other) || other.body == body || !(s.boxes[i].moves || other.moves)) continue;
      if (std::find(without.begin(), without.end(), other.body) != without.end()) continue;
      const PlacedPart &a = s.placed[std::min(i, k)], &b = s.placed[std::max(i, k)];
      Touches(a, b, s.slop, contacts).find(s.of(*a.part, *b.part));
    }
  }
  sort(contacts);
  return patch_corners(contacts, bodies, s.slop);
}

std::vector<int> Collisions::neighbours(int body) const {
  const State& s = *state_;
  const std::size_t first = s.first.at(body);
  std::vector<int> near;
  for (std::size_t k = 0; k < s.boxes.size(); ++k) {
    const PartBox& other = s.boxes[k];
    if (other.body == body || (!near.empty() && near.back() == other.body)) continue;
    for (std::size_t i = first; i < s.boxes.size() && s.boxes[i].body == body; ++i) {
      if (!(s.boxes[i].moves || other.moves) || !meet(s.boxes[i], other)) continue;
      near.push_back(other.body);
      break;
    }
  }
  return near;
}

}  // namespace klang::rigid::detail
