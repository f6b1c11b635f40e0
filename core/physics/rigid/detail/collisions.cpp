#include "core/physics/rigid/detail/collisions.hpp"

#include <LinearMath/btConvexHullComputer.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/rigid/detail/contact_patches.hpp"
#include "core/physics/rigid/detail/part_touches.hpp"

namespace klang::rigid::detail {

using Eigen::Vector3d;

namespace {

btVector3 bullet(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

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

/// By pairs, parts and places. Contacts are large: each is moved once.
void sort(std::vector<Contact>& contacts) {
  const auto before = [](const Contact& x, const Contact& y) {
    const auto key = [](const Contact& c) {
      return std::tie(c.a, c.b, c.parts[0], c.parts[1], c.place.x(), c.place.y(), c.place.z());
    };
    return key(x) < key(y);
  };
  if (std::is_sorted(contacts.begin(), contacts.end(), before)) return;
  static thread_local std::vector<const Contact*> order;
  static thread_local std::vector<Contact> sorted;
  order.clear();
  for (const Contact& c : contacts) order.push_back(&c);
  std::sort(order.begin(), order.end(), [&](const Contact* x, const Contact* y) { return before(*x, *y); });
  sorted.clear();
  for (const Contact* c : order) sorted.push_back(*c);
  contacts.swap(sorted);
}

}  // namespace

struct Collisions::State {
  std::map<int, std::vector<CollisionPart>> parts;
  std::vector<PlacedPart> placed;  // of the last search, body after body
  std::vector<PartBox> boxes;
  std::vector<PlacedBody> placed_bodies;  // by their numbers
  std::vector<PartBox> body_boxes;        // about all of their parts
  double slop = 0.0;
  BoxPairs body_pairs;
  std::vector<PartPair> pairs;                // parts whose boxes met in the last search, by bodies, then parts
  std::vector<KnownPair> known;               // of each
  std::vector<std::vector<Contact>> touches;  // of grains of pairs; their room is kept from step to step
  std::vector<Contact> all;

  KnownPair* of(const CollisionPart& a, const CollisionPart& b);
  std::size_t slot(int body) const;
  void place(const std::vector<BodyState>& bodies);
  void place_body(std::size_t slot, const BodyState& there);
  void add_pairs(std::size_t a, std::size_t b, std::vector<PartPair>& found) const;
  void meet_again();
};

/// Of a body that has parts, among the placed ones.
std::size_t Collisions::State::slot(int body) const {
  const auto found = std::lower_bound(placed_bodies.begin(), placed_bodies.end(), body,
                                      [](const PlacedBody& x, int number) { return x.body < number; });
  return static_cast<std::size_t>(found - placed_bodies.begin());
}

void Collisions::State::place_body(std::size_t slot, const BodyState& there) {
  const Eigen::Isometry3d place = place_of(there);
  const PlacedBody& body = placed_bodies[slot];
  for (std::size_t i = body.first; i < body.last; ++i) {
    placed[i].place = place;
    boxes[i] = box_of(*placed[i].part, placed[i], slop);
    if (i == body.first) body_boxes[slot] = boxes[i];
    body_boxes[slot].low = body_boxes[slot].low.cwiseMin(boxes[i].low);
    body_boxes[slot].high = body_boxes[slot].high.cwiseMax(boxes[i].high);
  }
}

void Collisions::State::place(const std::vector<BodyState>& bodies) {
  placed.clear();
  placed_bodies.clear();
  for (const auto& [number, its] : parts) {
    placed_bodies.push_back({number, placed.size(), placed.size() + its.size()});
    for (const CollisionPart& part : its) placed.push_back({&part, {}});
  }
  boxes.resize(placed.size());
  body_boxes.resize(placed_bodies.size());
  constexpr std::size_t kGrain = 128;
  parallel_for(placed_bodies.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) place_body(i, bodies[static_cast<std::size_t>(placed_bodies[i].body)]);
  });
}

/// Parts of two bodies whose boxes meet, the lower number's first.
void Collisions::State::add_pairs(std::size_t a, std::size_t b, std::vector<PartPair>& found) const {
  if (!meet(body_boxes[a], body_boxes[b])) return;
  std::vector<int> near_a;  // of b's parts
  for (std::size_t j = placed_bodies[b].first; j < placed_bodies[b].last; ++j)
    if (meet(body_boxes[a], boxes[j])) near_a.push_back(static_cast<int>(j));
  for (std::size_t i = placed_bodies[a].first; i < placed_bodies[a].last && !near_a.empty(); ++i) {
    if (!meet(boxes[i], body_boxes[b])) continue;
    for (const int j : near_a)
      if (meet(boxes[i], boxes[static_cast<std::size_t>(j)])) found.push_back({static_cast<int>(i), j});
  }
}

/// Pairs of parts whose boxes meet now, with what is known of those that met last time.
void Collisions::State::meet_again() {
  pairs.clear();
  for (const auto& [a, b] : body_pairs.find(body_boxes))
    add_pairs(static_cast<std::size_t>(a), static_cast<std::size_t>(b), pairs);
  std::vector<KnownPair> now;
  now.reserve(pairs.size());
  auto old = known.begin();
  for (const auto& [i, j] : pairs) {
    const CollisionPart &a = *placed[static_cast<std::size_t>(i)].part, &b = *placed[static_cast<std::size_t>(j)].part;
    KnownPair pair;
    pair.key = {a.body, b.body, a.number, b.number};
    while (old != known.end() && old->key < pair.key) ++old;
    if (old != known.end() && old->key == pair.key) pair = *old;
    now.push_back(pair);
  }
  known = std::move(now);
}

/// What is known of two parts; none: their boxes did not meet in the last search.
KnownPair* Collisions::State::of(const CollisionPart& a, const CollisionPart& b) {
  const std::array<int, 4> key{a.body, b.body, a.number, b.number};
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
  s.placed_bodies.clear();
}

std::vector<Contact> Collisions::find(const std::vector<BodyState>& bodies, double slop, bool with_floor) {
  State& s = *state_;
  s.slop = slop;
  s.place(bodies);
  std::vector<Contact>& contacts = s.all;
  contacts.clear();
  for (const PlacedPart& placed : s.placed) {
    const BodyState& body = bodies[static_cast<std::size_t>(placed.part->body)];
    if (with_floor && !body.fixed()) add_floor_contacts(*placed.part, body, slop, contacts);
  }
  s.meet_again();
  constexpr std::size_t kGrain = 256;
  const std::vector<PartPair>& pairs = s.pairs;
  std::vector<std::vector<Contact>>& found = s.touches;
  if (found.size() < (pairs.size() + kGrain - 1) / kGrain) found.resize((pairs.size() + kGrain - 1) / kGrain);
  for (std::vector<Contact>& its : found) its.clear();
  parallel_for(pairs.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const PlacedPart &a = s.placed[static_cast<std::size_t>(pairs[n][0])],
                       &b = s.placed[static_cast<std::size_t>(pairs[n][1])];
      add_touches(a, b, slop, &s.known[n], found[begin / kGrain]);
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
        if (meet(box, boxes_b[k])) add_touches(placed, parts_b[k], slop, state_->of(part, *parts_b[k].part), contacts);
    }
  }
  sort(contacts);
  return contacts;
}

void Collisions::move(int body, const BodyState& there) { state_->place_body(state_->slot(body), there); }

std::vector<Contact> Collisions::of_body(int body, const std::vector<int>& without,
                                         const std::vector<BodyState>& bodies, bool with_floor) const {
  State& s = *state_;
  std::vector<Contact> contacts;
  std::vector<PartPair> pairs;
  const std::size_t own = s.slot(body);
  for (std::size_t i = s.placed_bodies[own].first; i < s.placed_bodies[own].last && with_floor; ++i)
    add_floor_contacts(*s.placed[i].part, bodies[static_cast<std::size_t>(body)], s.slop, contacts);
  for (std::size_t k = 0; k < s.placed_bodies.size(); ++k) {
    if (k == own || !meet(s.body_boxes[own], s.body_boxes[k])) continue;
    if (std::find(without.begin(), without.end(), s.placed_bodies[k].body) == without.end())
      s.add_pairs(std::min(own, k), std::max(own, k), pairs);
  }
  for (const auto& [i, j] : pairs) {
    const PlacedPart &a = s.placed[static_cast<std::size_t>(i)], &b = s.placed[static_cast<std::size_t>(j)];
    if (a.part->moves || b.part->moves) add_touches(a, b, s.slop, s.of(*a.part, *b.part), contacts);
  }
  sort(contacts);
  return patch_corners(contacts, bodies, s.slop);
}

std::vector<int> Collisions::neighbours(int body) const {
  const State& s = *state_;
  const std::size_t own = s.slot(body);
  std::vector<int> near;
  std::vector<PartPair> pairs;
  for (std::size_t k = 0; k < s.placed_bodies.size(); ++k) {
    if (k == own || !(s.body_boxes[own].moves || s.body_boxes[k].moves)) continue;
    pairs.clear();
    s.add_pairs(std::min(own, k), std::max(own, k), pairs);
    if (!pairs.empty()) near.push_back(s.placed_bodies[k].body);
  }
  return near;
}

}  // namespace klang::rigid::detail
