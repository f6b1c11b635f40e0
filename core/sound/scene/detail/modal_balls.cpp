#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/rigid/impact_pulse.hpp"
#include "core/sound/scene/detail/modal_contacts.hpp"

namespace klang::scene::detail {

using Eigen::Vector3d;

double ModalContacts::ball_springs_j() const {
  double sum = 0.0;
  for (const auto& [key, ball] : balls_) sum += ball.spring_j;
  return sum;
}

void ModalContacts::press_balls(std::vector<PressedBody>& others, double dt_s, bool at_end) {
  for (PressedBody& other : others) {
    if (!(other.ball_radius_m() > 0.0)) continue;
    for (std::size_t a = 0; a < bodies_.size(); ++a) {
      Ball& state = balls_[{a, other.body()}];
      press_ball(a, other, state, dt_s);
      if (!at_end) continue;
      state.book(bodies_[a]);
      if (state.impulse_n_s.squaredNorm() > 0.0) {
        bodies_[a].note(state.place, other.body(), state.is_new, state.impulse_n_s, bodies_[a].last_step());
        note_rigid(bodies_[a], other, bodies_[a].centre_m + bodies_[a].arm(state.place), -state.impulse_n_s,
                   state.is_new, bodies_[a].last_step());
        state.is_new = false;
      }
      if (!state.touches) state.is_new = true;
      time_touch(a, state, 2.0 * dt_s);
      state.impulse_n_s.setZero();
    }
  }
}

void ModalContacts::time_touch(std::size_t a, Ball& state, double dt_s) {
  if (state.touches) state.touched_s += dt_s;
  if (state.touches || !(state.touched_s > 0.0)) return;
  const modal::ModalState& modes = bodies_[a].modes;
  if (modes.z.size() > 0)
    if (const double periods = state.touched_s * std::sqrt(modes.lambda().maxCoeff()) / (2.0 * kPi);
        periods < shortest_periods_) {
      shortest_periods_ = periods;
      shortest_body_ = static_cast<int>(a);
    }
  state.touched_s = 0.0;
}

void ModalContacts::Ball::book(ModalBody& body) {
  // gained: of the modal body and of the ball; what both and the spring do not have is what the step's size costs
  body.ledger.friction_j += slid_j;
  body.ledger.contact_j += gained_ball_j;
  body.ledger.correction_j -= gained_j + gained_ball_j + slid_j + spring_j - spring_before_j;
  spring_before_j = spring_j;
  gained_j = gained_ball_j = slid_j = 0.0;
}

void ModalContacts::press_ball(std::size_t a, PressedBody& ball, Ball& state, double dt_s) {
  ModalBody& body = bodies_[a];
  const double radius = ball.ball_radius_m();
  state.spring_j = 0.0;
  state.touches = false;
  if (!body.is_near(ball.centre_m(), 1.1 * radius)) return;
  const Vector3d own = body.turn.conjugate() * (ball.centre_m() - body.centre_m);
  const double margin = 0.25 * radius;
  if (!((own - state.looked_from_m).norm() <= margin)) {
    state.looked_from_m = own;
    state.near = triangles_near(body.surface, body.surface_groups, own, radius + body.swell_m + 2.0 * margin);
  }
  if (state.near.triangles.rows() == 0) return;
  Vector3d normal;
  ModalPlace place = body.nearest(own, state.near, normal);
  const Vector3d apart = own - place.rest_m - place.shape * body.modes.z;
  const bool outside = apart.dot(normal) > 0.0;
  const double far = outside ? apart.norm() : apart.dot(normal);
  const double depth = radius - far;
  if (!(depth > 0.0)) return;
  const Vector3d out = body.turn * (outside ? Vector3d(apart / far) : normal);
  const double round = body.ball_radius_m > 0.0 ? 1.0 / (1.0 / radius + 1.0 / body.ball_radius_m) : radius;
  const double stiff = 4.0 / 3.0 * rigid::contact_modulus_pa(body.skin, ball.skin()) * std::sqrt(round);
  const double soft = body.under_balls->beyond_dent_m_per_n(place.rest_m + body.rest_centre_m, normal,
                                                            place.shape.transpose() * normal);
  double dent = depth;  // dent + soft F = depth, F = stiff dent^1.5
  for (int k = 0; soft > 0.0 && k < 50; ++k) {
    const double root = std::sqrt(dent), off = dent + soft * stiff * dent * root - depth;
    dent -= off / (1.0 + 1.5 * soft * stiff * root);
    if (std::abs(off) <= 1e-15 * depth) break;
  }
  const double force = stiff * dent * std::sqrt(dent);
  state.touches = true;
  state.spring_j = 0.4 * force * dent + 0.5 * soft * force * force;
  const Vector3d x = body.centre_m + body.arm(place);
  Vector3d impulse = dt_s * force * out;  // on the ball
  const Vector3d slip = ball.velocity_at(x) - body.velocity_at(place), along = slip - slip.dot(out) * out;
  const double friction = rigid::pair_friction(body.skin, ball.skin());
  Vector3d rub = Vector3d::Zero();
  if (friction > 0.0 && along.norm() > 0.0) {
    const Vector3d way = along.normalized(), arm_a = body.arm(place).cross(way),
                   arm_b = (x - ball.centre_m()).cross(way);
    const double light = 1.0 / body.mass_kg + arm_a.dot(body.inverse_inertia() * arm_a) +
                         (place.shape.transpose() * (body.turn.conjugate() * way)).squaredNorm() +
                         ball.inverse_mass_per_kg() + arm_b.dot(ball.inverse_inertia() * arm_b);
    rub = -std::min(friction * force * dt_s, along.norm() / light) * way;
    state.slid_j -= rub.dot(along) + 0.5 * light * rub.squaredNorm();
  }
  impulse += rub;
  const double before_j = body.moving_j(), ball_before_j = ball.moving_j();
  body.push(place, -impulse);
  ball.push(x, impulse);
  state.gained_j += body.moving_j() - before_j;
  state.gained_ball_j += ball.moving_j() - ball_before_j;
  state.impulse_n_s -= impulse;
  state.place = std::move(place);
}

mesh::SurfaceMesh triangles_near(const mesh::SurfaceMesh& surface, const SurfaceGroups& groups, const Vector3d& x,
                                 double distance_m) {
  std::vector<Eigen::Index> kept;
  for (const Eigen::Index t : groups.near(x, distance_m)) {
    const auto corner = [&](int c) -> Vector3d { return surface.vertices_m.row(surface.triangles(t, c)).transpose(); };
    const Vector3d centre = (corner(0) + corner(1) + corner(2)) / 3.0;
    double reach = 0.0;
    for (int c = 0; c < 3; ++c) reach = std::max(reach, (corner(c) - centre).norm());
    if ((centre - x).norm() <= distance_m + reach) kept.push_back(t);
  }
  return {surface.vertices_m, surface.triangles(kept, Eigen::all)};
}

}  // namespace klang::scene::detail
