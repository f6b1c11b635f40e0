#pragma once
#include <memory>
#include <vector>

#include "core/physics/rigid/contact.hpp"
#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid::detail {

/// Which points of bodies touch or are about to: pairs of boxes about their parts (box_pairs.hpp), then hulls against hulls
/// (hull_axis.hpp, hull_touches.hpp), balls against hulls (ball_touches.hpp) and balls, hulls without volume by Bullet; the floor's
/// contacts are the corners below it. The only place beside convex_hull.hpp that knows Bullet. Contacts come in an order that depends on
/// nothing but the order of bodies and parts, and are found anew each time: cached points of a rolling body lie where it was.
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

  /// All such points of one pair, more than its patches' corners. @param b  above a, or kFloor, which stands nowhere
  std::vector<Contact> find_pair(int a, int b, const BodyState& at_a, const BodyState& at_b, double slop) const;
  /// From the last find() on that body stands there, for of_body().
  void move(int body, const BodyState& there);
  /// All contacts of a body with the others where they stood in the last find() or were moved to since, by pairs.
  /// @param without  leaves out those with these bodies  @param bodies  as they stand
  std::vector<Contact> of_body(int body, const std::vector<int>& without, const std::vector<BodyState>& bodies,
                               bool with_floor) const;
  /// Bodies whose parts' boxes meet those of that one.
  std::vector<int> neighbours(int body) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace klang::rigid::detail
