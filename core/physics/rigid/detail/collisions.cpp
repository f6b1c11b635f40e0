#include "core/physics/rigid/detail/collisions.hpp"

#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <map>
#include <tuple>

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
  Eigen::Matrix3Xd corners;  // from the centre of mass, body axes; of a ball none
  double radius = 0.0;
  std::unique_ptr<btConvexShape> shape;
  std::unique_ptr<btCollisionObject> object;
};

std::unique_ptr<btConvexShape> hull_of(const Eigen::Matrix3Xd& corners) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (Eigen::Index i = 0; i < corners.cols(); ++i) hull->addPoint(bullet(corners.col(i)), false);
  hull->recalcLocalAabb();
  hull->setMargin(0.0);  // a margin rounds the corners; in double precision distances need none
  Eigen::Matrix3Xd spread = corners.colwise() - corners.rowwise().mean();
  if (corners.cols() >= 4 && (spread * spread.transpose()).determinant() > 0) hull->initializePolyhedralFeatures();
  return hull;
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
  const Eigen::Matrix3d r = body.turn.toRotationMatrix();
  for (Eigen::Index i = 0; i < part.corners.cols(); ++i) add(body.centre + r * part.corners.col(i));
}

}  // namespace

struct Collisions::Bullet {
  btDefaultCollisionConfiguration configuration;
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
    world.getDispatchInfo().m_enableSatConvex = true;  // a face gives all its corners, not one point per step
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
  bullet_->world.performDiscreteCollisionDetection();
  for (int i = 0; i < bullet_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *bullet_->dispatcher.getManifoldByIndexInternal(i);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      if (point.getDistance() <= slop) contacts.push_back(contact_of(point, manifold.getBody0(), manifold.getBody1()));
    }
  }
  const auto key = [](const Contact& c) {
    return std::tuple(c.a, c.b, c.parts[0], c.parts[1], c.place.x(), c.place.y(), c.place.z());
  };
  std::sort(contacts.begin(), contacts.end(), [&](const Contact& x, const Contact& y) { return key(x) < key(y); });
  return contacts;
}

}  // namespace klang::rigid::detail
