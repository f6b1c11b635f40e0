#include "core/physics/rigid/detail/contact_solver.hpp"

#include <algorithm>
#include <cmath>

namespace klang::rigid::detail {

using Eigen::Vector3d;

namespace {

Vector3d velocity_at(int body, const Vector3d& arm, const Bodies& bodies) {
  if (body < 0) return Vector3d::Zero();
  const BodyState& b = bodies.all[static_cast<std::size_t>(body)];
  return b.velocity + b.spin.cross(arm);
}

void push_body(int body, const Vector3d& arm, const Vector3d& impulse, Bodies& bodies) {
  if (body < 0) return;
  BodyState& b = bodies.all[static_cast<std::size_t>(body)];
  if (b.fixed()) return;
  b.velocity += b.inverse_mass * impulse;
  b.spin += bodies.inverse_inertia[static_cast<std::size_t>(body)] * arm.cross(impulse);
}

double body_mobility(int body, const Vector3d& arm, const Vector3d& axis, const Bodies& bodies) {
  if (body < 0) return 0.0;
  const Vector3d moment = arm.cross(axis);
  return bodies.all[static_cast<std::size_t>(body)].inverse_mass +
         moment.dot(bodies.inverse_inertia[static_cast<std::size_t>(body)] * moment);
}

/// How far a contact is from its conditions.
double violation(const Contact& c, const Vector3d& impulse, const Vector3d& mobility, const Bodies& bodies) {
  const Vector3d u = relative_velocity(c, bodies);
  const double normal = std::abs(std::min(u[0] - c.target, impulse[0] * mobility[0]));
  // Across: the fixed point of the projected step.
  const double across = std::max(mobility[1], mobility[2]);
  const double limit = c.friction * impulse[0];
  Eigen::Vector2d next = impulse.tail<2>() - u.tail<2>() / across;
  if (next.norm() > limit) next *= limit / next.norm();
  return std::max(normal, (next - impulse.tail<2>()).norm() * across);
}

}  // namespace

Vector3d relative_velocity(const Contact& c, const Bodies& bodies) {
  return c.axes.transpose() * (velocity_at(c.a, c.arm_a, bodies) - velocity_at(c.b, c.arm_b, bodies));
}

void push(const Contact& c, const Vector3d& impulse, Bodies& bodies) {
  const Vector3d world = c.axes * impulse;
  push_body(c.a, c.arm_a, world, bodies);
  push_body(c.b, c.arm_b, -world, bodies);
}

Vector3d mobility(const Contact& c, const Bodies& bodies) {
  Vector3d k;
  for (int i = 0; i < 3; ++i) {
    k[i] = body_mobility(c.a, c.arm_a, c.axes.col(i), bodies) + body_mobility(c.b, c.arm_b, c.axes.col(i), bodies);
  }
  return k;
}

double solve_contacts(std::span<Contact* const> contacts, Vector3d Contact::*impulse, int sweeps, double tolerance,
                      Bodies& bodies) {
  std::vector<Vector3d> mobilities(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) mobilities[i] = mobility(*contacts[i], bodies);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double change = 0.0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      Contact& c = *contacts[i];
      const Vector3d& k = mobilities[i];
      Vector3d& sum = c.*impulse;
      Vector3d u = relative_velocity(c, bodies);
      const double normal = std::max(0.0, sum[0] - (u[0] - c.target) / k[0]) - sum[0];
      push(c, {normal, 0.0, 0.0}, bodies);
      sum[0] += normal;
      u = relative_velocity(c, bodies);
      const double across = std::max(k[1], k[2]), limit = c.friction * sum[0];
      Eigen::Vector2d next = sum.tail<2>() - u.tail<2>() / across;
      if (next.norm() > limit) next *= limit / next.norm();
      const Eigen::Vector2d step = next - sum.tail<2>();
      push(c, {0.0, step[0], step[1]}, bodies);
      sum.tail<2>() = next;
      change = std::max({change, std::abs(normal) * k[0], step.norm() * across});
    }
    if (change <= tolerance) break;
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    worst = std::max(worst, violation(*contacts[i], contacts[i]->*impulse, mobilities[i], bodies));
  }
  return worst;
}

}  // namespace klang::rigid::detail
