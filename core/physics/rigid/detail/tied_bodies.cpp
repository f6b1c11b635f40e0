#include "core/physics/rigid/detail/tied_bodies.hpp"

namespace klang::rigid::detail {

int TiedBodies::number_of(int body) {
  if (body < 0) return kFloor;
  const auto [entry, is_new] = numbers_.try_emplace(body, static_cast<int>(bodies.size()));
  if (is_new) {
    const BodyState& b = all_.all[body_index(body)];
    bodies.push_back({b.inverse_mass, b.centre, all_.inverse_inertia[body_index(body)]});
    known.push_back(body);
  }
  return entry->second;
}

PairPush TiedBodies::push_of(const Contact& c) {
  PairPush push;
  push.a = number_of(c.a);
  push.b = number_of(c.b);
  push.at_a = all_.all[body_index(c.a)].centre + c.arm_a;
  if (c.b >= 0) push.at_b = all_.all[body_index(c.b)].centre + c.arm_b;
  push.along = c.normal;
  return push;
}

void TiedBodies::add_tie(const Contact& link) {
  PairPush push = push_of(link);
  push.only_pulls = !link.tied;
  for (int axis = 0; axis < (link.tied ? 3 : 1); ++axis) {
    push.along = link.axes.col(axis);
    ties.push_back(push);
  }
}

}  // namespace klang::rigid::detail
