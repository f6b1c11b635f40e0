#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "core/physics/rigid/contact.hpp"
#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid::detail {

/// Which points of bodies touch or are about to: convex hulls (hull_axis.hpp, hull_touches.hpp); balls, hulls without volume and broad
/// phase by Bullet; the floor's contacts are the corners below it. The only place that knows Bullet. Contacts come in an order that depends on nothing but the
/// order of bodies and parts, and are found anew each time: cached points of a rolling body lie where it was.
class Collisions {
 public:
  Collisions();
  ~Collisions();
  /// @param body  its number, from 0 upward; lengths are multiplied by scale
  void add(int body, const RigidBodySpec& spec, double scale, bool moves);
  void remove(int body);

  /// Points with a gap of at most `slop` with bodies where they stand; gap, place, normal, a, b and parts are filled in.
  /// @param with_floor  the plane z = 0 touches
  std::vector<Contact> find(const std::vector<BodyState>& bodies, double slop, bool with_floor);

 private:
  struct Bullet;
  std::unique_ptr<Bullet> bullet_;
};

}  // namespace klang::rigid::detail
