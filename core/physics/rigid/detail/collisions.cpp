#include "core/physics/rigid/detail/collisions.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <map>
#include <new>
#include <tuple>

#include "core/physics/rigid/detail/contact_patches.hpp"
#include "core/physics/rigid/detail/hull_touches.hpp"

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

btVector3 bullet(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d eigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// Parts of one body, and bodies that do not move, have nothing to say to each other.
struct OtherBodies : btOverlapFilterCallback {
  bool needBroadphaseCollision(btBroadphaseProxy* p0, btBroadphaseProxy* p1) const override {
    const auto* a = static_cast<const btCollisionObject*>(p0->m_clientObject);
    const auto* b = static_cast<const btCollisionObject*>(p1->m_clientObject);
    return a->getUserIndex() != b->getUserIndex() && !(a->isStaticObject() && b->isStaticObject());
  }
};

struct Part {
  int body = 0, number = 0;
  Eigen::Matrix3Xd corners;   // from the centre of mass, body axes; of a ball none
  Eigen::Matrix3Xd on_floor;  // corners that no earlier part of the body has
  double floor_radius = 0.0;  // of the farthest of these
  double radius = 0.0;
  std::unique_ptr<HullFeatures> features;
  std::unique_ptr<btConvexShape> shape;
  std::unique_ptr<btCollisionObject> object;
};

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

Eigen::Isometry3d isometry(const btTransform& from) {
  Eigen::Isometry3d to = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    to.translation()[i] = from.getOrigin()[i];
    for (int j = 0; j < 3; ++j) to.linear()(i, j) = from.getBasis()[i][j];
  }
  return to;
}

/// What pairs of hulls find in one search; Bullet's own store keeps four points of two parts, and not the same ones in each step.
struct HullContacts {
  double near = 0.0;  // largest gap of a point that counts
  std::vector<Contact> all;
};

/// Two hulls: the axis along which they overlap least, then where they touch along it. Most pairs whose boxes meet are parted by the
/// axis that parted them a step ago.
class HullPair : public btCollisionAlgorithm {
 public:
  HullPair(const btCollisionAlgorithmConstructionInfo& info, HullContacts* found)
      : btCollisionAlgorithm(info), found_(found) {}

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo&, btManifoldResult*) override {
    // The body with the lower number first, whatever pair the broad phase makes: the same points in the same order.
    const bool swapped = first->getCollisionObject()->getUserIndex() > second->getCollisionObject()->getUserIndex();
    const btCollisionObjectWrapper &on_a = swapped ? *second : *first, &on_b = swapped ? *first : *second;
    const HullFeatures &a = features(on_a), &b = features(on_b);
    const Eigen::Isometry3d place_a = isometry(on_a.getWorldTransform());
    const Eigen::Isometry3d b_to_a = place_a.inverse() * isometry(on_b.getWorldTransform());
    // Faces that lie on one another are apart by a last digit as often as not.
    if (gap_along(a, b, b_to_a, parted_) > found_->near) return;
    const HullAxis axis = hull_axis(a, b, b_to_a, found_->near);
    if (axis.gap > found_->near) {
      parted_ = axis.normal;
      return;
    }
    const Vector3d normal = place_a.linear() * axis.normal;
    for (const HullTouch& touch : hull_touches(a, b, b_to_a, axis, found_->near)) {
      if (!(touch.gap <= found_->near)) continue;
      Contact& c = found_->all.emplace_back();
      c.a = on_a.getCollisionObject()->getUserIndex();
      c.b = on_b.getCollisionObject()->getUserIndex();
      c.parts = {on_a.getCollisionObject()->getUserIndex2(), on_b.getCollisionObject()->getUserIndex2()};
      c.place = place_a * touch.on_b + 0.5 * touch.gap * normal;
      c.normal = normal;
      c.gap = touch.gap;
    }
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1.0;
  }
  void getAllContactManifolds(btManifoldArray&) override {}

 private:
  static const HullFeatures& features(const btCollisionObjectWrapper& of) {
    return *static_cast<const HullFeatures*>(of.getCollisionObject()->getUserPointer());
  }
  HullContacts* found_;
  Vector3d parted_ = Vector3d::UnitZ();  // in the frame of the body with the lower number
};

struct MakeHullPair : btCollisionAlgorithmCreateFunc {
  btCollisionAlgorithmCreateFunc* flat = nullptr;  // for hulls without volume
  HullContacts found;
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override {
    if (first->getCollisionObject()->getUserPointer() == nullptr ||
        second->getCollisionObject()->getUserPointer() == nullptr)
      return flat->CreateCollisionAlgorithm(info, first, second);
    return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullPair))) HullPair(info, &found);
  }
};

btDefaultCollisionConstructionInfo room_for_pairs() {
  btDefaultCollisionConstructionInfo info;
  info.m_customCollisionAlgorithmMaxElementSize = sizeof(HullPair);
  return info;
}

/// Parts that meet share corners, which touch the floor once.
Eigen::Matrix3Xd corners_of_its_own(const Eigen::Matrix3Xd& corners, const std::vector<Part>& earlier) {
  const double near = 1e-9 * corners.colwise().norm().maxCoeff();
  std::vector<Eigen::Index> own;
  for (Eigen::Index i = 0; i < corners.cols(); ++i) {
    const bool known = std::any_of(earlier.begin(), earlier.end(), [&](const Part& part) {
      return part.on_floor.cols() > 0 && (part.on_floor.colwise() - corners.col(i)).colwise().norm().minCoeff() <= near;
    });
    if (!known) own.push_back(i);
  }
  return corners(Eigen::all, own);
}

Contact contact_of(const btManifoldPoint& point, const btCollisionObject* first, const btCollisionObject* second) {
  Contact c;
  const bool swapped = first->getUserIndex() > second->getUserIndex();
  if (swapped) std::swap(first, second);
  c.a = first->getUserIndex();
  c.b = second->getUserIndex();
  c.parts = {first->getUserIndex2(), second->getUserIndex2()};
  c.place = 0.5 * (eigen(point.getPositionWorldOnA()) + eigen(point.getPositionWorldOnB()));
  c.normal = (swapped ? -1.0 : 1.0) * eigen(point.m_normalWorldOnB);
  c.gap = point.getDistance();
  return c;
}

void add_floor_contacts(const Part& part, const BodyState& body, double slop, std::vector<Contact>& contacts) {
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
  const double near = slop + 1e-9 * part.floor_radius;
  for (Eigen::Index i = 0; i < part.on_floor.cols(); ++i)
    if (body.centre.z() + r.row(2).dot(part.on_floor.col(i)) <= near) add(body.centre + r * part.on_floor.col(i));
}

}  // namespace

struct Collisions::Bullet {
  btDefaultCollisionConfiguration configuration{room_for_pairs()};
  MakeHullPair make_pair;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  OtherBodies filter;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};
  std::map<int, std::vector<Part>> parts;

  Bullet() {
    dispatcher.setDispatcherFlags(dispatcher.getDispatcherFlags() |
                                  btCollisionDispatcher::CD_USE_RELATIVE_CONTACT_BREAKING_THRESHOLD);
    // The special algorithm for two balls is silent until they overlap.
    dispatcher.registerCollisionCreateFunc(
        SPHERE_SHAPE_PROXYTYPE, SPHERE_SHAPE_PROXYTYPE,
        configuration.getCollisionAlgorithmCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE));
    make_pair.flat =
        configuration.getCollisionAlgorithmCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE);
    dispatcher.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE, &make_pair);
    broadphase.getOverlappingPairCache()->setOverlapFilterCallback(&filter);
  }
  ~Bullet() {
    for (auto& [body, its] : parts) {
      for (Part& part : its) world.removeCollisionObject(part.object.get());
    }
  }
};

Collisions::Collisions() : bullet_(std::make_unique<Bullet>()) {}
Collisions::~Collisions() = default;

void Collisions::add(int body, const RigidBodySpec& spec, double scale, bool moves) {
  std::vector<Part>& parts = bullet_->parts[body];
  const auto add_part = [&](Part part) {
    part.body = body;
    part.number = static_cast<int>(parts.size());
    part.object = std::make_unique<btCollisionObject>();
    part.object->setCollisionShape(part.shape.get());
    part.object->setUserPointer(part.features.get());
    part.object->setUserIndex(body);
    part.object->setUserIndex2(part.number);
    part.object->setCollisionFlags(moves ? 0 : btCollisionObject::CF_STATIC_OBJECT);  // static unless told
    bullet_->world.addCollisionObject(part.object.get());
    parts.push_back(std::move(part));
  };
  if (spec.ball_radius_m > 0) {
    Part part;
    part.radius = scale * spec.ball_radius_m;
    part.shape = std::make_unique<btSphereShape>(part.radius);
    add_part(std::move(part));
  }
  for (const ConvexPart& given : spec.parts) {
    Part part;
    part.corners = scale * (given.corners_m.colwise() - spec.centre_m);
    part.shape = hull_of(part.corners);
    part.features = features_of(part.corners);
    part.on_floor = corners_of_its_own(part.corners, parts);
    if (part.on_floor.cols() > 0) part.floor_radius = part.on_floor.colwise().norm().maxCoeff();
    add_part(std::move(part));
  }
}

void Collisions::remove(int body) {
  for (Part& part : bullet_->parts.at(body)) bullet_->world.removeCollisionObject(part.object.get());
  bullet_->parts.erase(body);
}

std::vector<Contact> Collisions::find(const std::vector<BodyState>& bodies, double slop, bool with_floor) {
  std::vector<Contact> contacts;
  for (auto& [number, parts] : bullet_->parts) {
    const BodyState& body = bodies[static_cast<std::size_t>(number)];
    const btTransform place({body.turn.x(), body.turn.y(), body.turn.z(), body.turn.w()}, bullet(body.centre));
    for (Part& part : parts) {
      part.object->setWorldTransform(place);
      if (with_floor && !body.fixed()) add_floor_contacts(part, body, slop, contacts);
    }
  }
  for (int i = 0; i < bullet_->dispatcher.getNumManifolds(); ++i) {
    bullet_->dispatcher.getManifoldByIndexInternal(i)->clearManifold();
  }
  bullet_->make_pair.found = {slop, {}};
  bullet_->world.performDiscreteCollisionDetection();
  for (int i = 0; i < bullet_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *bullet_->dispatcher.getManifoldByIndexInternal(i);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      if (point.getDistance() <= slop) contacts.push_back(contact_of(point, manifold.getBody0(), manifold.getBody1()));
    }
  }
  const std::vector<Contact>& of_hulls = bullet_->make_pair.found.all;
  contacts.insert(contacts.end(), of_hulls.begin(), of_hulls.end());
  const auto key = [](const Contact& c) {
    return std::tuple(c.a, c.b, c.parts[0], c.parts[1], c.place.x(), c.place.y(), c.place.z());
  };
  std::sort(contacts.begin(), contacts.end(), [&](const Contact& x, const Contact& y) { return key(x) < key(y); });
  return patch_corners(contacts, bodies, slop);
}

}  // namespace klang::rigid::detail
