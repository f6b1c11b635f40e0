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
  if (c.tied) return u.norm();
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

namespace {

constexpr int kPatience =
    50;  // sweeps after which a tenth must be gained: where they go in circles more of them give nothing

double square(double x) { return x * x; }

/// One axis of a contact: what a unit impulse along it does to a body, and how the body's motion shows along it.
struct Arm {
  Vector3d direction, turning;      // u = direction . v + turning . w
  Vector3d kick, spin_per_impulse;  // v += kick J, w += spin_per_impulse J
};

/// A contact as the sweeps need it.
struct Row {
  Contact* contact = nullptr;
  BodyState* body[2] = {nullptr, nullptr};  // null: does not move
  Arm arm[2][3];
  Vector3d still = Vector3d::Zero();  // what bodies that do not move add to u
  Vector3d mobility = Vector3d::Zero();
  Vector3d* impulse = nullptr;
  int island = 0;

  double speed(int axis) const {
    double u = still[axis];
    for (int side = 0; side < 2; ++side)
      if (body[side] != nullptr)
        u += arm[side][axis].direction.dot(body[side]->velocity) + arm[side][axis].turning.dot(body[side]->spin);
    return u;
  }
  void push(int axis, double by) {
    for (int side = 0; side < 2; ++side) {
      if (body[side] == nullptr) continue;
      body[side]->velocity += by * arm[side][axis].kick;
      body[side]->spin += by * arm[side][axis].spin_per_impulse;
    }
  }
  double sweep();
};

/// The largest change of a velocity, squared: roots wait for it.
double Row::sweep() {
  Vector3d& sum = *impulse;
  if (contact->tied) {
    double change = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double by = speed(axis);
      push(axis, -by / mobility[axis]);
      sum[axis] -= by / mobility[axis];
      change = std::max(change, square(by));
    }
    return change;
  }
  const double normal = std::max(0.0, sum[0] - (speed(0) - contact->target) / mobility[0]) - sum[0];
  if (normal != 0) push(0, normal);
  sum[0] += normal;
  const double across = std::max(mobility[1], mobility[2]), limit = contact->friction * sum[0];
  if (!(limit > 0) && sum[1] == 0 && sum[2] == 0) return square(normal * mobility[0]);
  Eigen::Vector2d next = sum.tail<2>() - Eigen::Vector2d(speed(1), speed(2)) / across;
  if (next.squaredNorm() > limit * limit) next *= limit / next.norm();
  const Eigen::Vector2d step = next - sum.tail<2>();
  push(1, step[0]);
  push(2, step[1]);
  sum.tail<2>() = next;
  return std::max(square(normal * mobility[0]), step.squaredNorm() * square(across));
}

Row row_of(Contact& c, Vector3d Contact::*impulse, Bodies& bodies) {
  Row row;
  row.contact = &c;
  row.impulse = &(c.*impulse);
  for (int side = 0; side < 2; ++side) {
    const int number = side == 0 ? c.a : c.b;
    if (number < 0) continue;
    BodyState& body = bodies.all[static_cast<std::size_t>(number)];
    const Vector3d& place = side == 0 ? c.arm_a : c.arm_b;
    const double sign = side == 0 ? 1.0 : -1.0;
    if (body.fixed()) {
      row.still += sign * (c.axes.transpose() * (body.velocity + body.spin.cross(place)));
      continue;
    }
    row.body[side] = &body;
    const Eigen::Matrix3d& inverse = bodies.inverse_inertia[static_cast<std::size_t>(number)];
    for (int axis = 0; axis < 3; ++axis) {
      Arm& arm = row.arm[side][axis];
      arm.direction = sign * c.axes.col(axis);
      arm.turning = place.cross(arm.direction);
      arm.kick = body.inverse_mass * arm.direction;
      arm.spin_per_impulse = inverse * arm.turning;
      row.mobility[axis] += body.inverse_mass + arm.turning.dot(arm.spin_per_impulse);
    }
  }
  return row;
}

/// Numbers the groups of contacts that share no moving body.
void find_islands(std::vector<Row>& rows, std::size_t n_bodies, const BodyState* first) {
  std::vector<int> parent(n_bodies);
  for (std::size_t i = 0; i < n_bodies; ++i) parent[i] = static_cast<int>(i);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  const auto number = [&](const BodyState* body) { return static_cast<int>(body - first); };
  for (const Row& row : rows)
    if (row.body[0] != nullptr && row.body[1] != nullptr)
      parent[static_cast<std::size_t>(root(number(row.body[0])))] = root(number(row.body[1]));
  for (Row& row : rows) {
    const BodyState* moving = row.body[0] != nullptr ? row.body[0] : row.body[1];
    row.island = moving == nullptr ? -1 : root(number(moving));
  }
}

}  // namespace

double solve_contacts(std::span<Contact* const> contacts, Vector3d Contact::*impulse, int sweeps, double tolerance,
                      Bodies& bodies) {
  std::vector<Row> rows;
  rows.reserve(contacts.size());
  for (Contact* contact : contacts) rows.push_back(row_of(*contact, impulse, bodies));
  find_islands(rows, bodies.all.size(), bodies.all.data());
  std::vector<Row*> order;
  for (Row& row : rows) order.push_back(&row);
  std::stable_sort(order.begin(), order.end(), [](const Row* x, const Row* y) { return x->island < y->island; });
  double worst = 0.0;
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && order[last]->island == order[first]->island) ++last;
    if (order[first]->island < 0) continue;  // nothing there moves
    const std::span<Row* const> island(order.data() + first, last - first);
    double change = 0.0, before = HUGE_VAL;
    for (int sweep = 1; sweep <= sweeps; ++sweep) {
      change = 0.0;
      for (Row* row : island) change = std::max(change, row->sweep());
      if (change <= square(tolerance)) break;
      if (sweep % kPatience != 0) continue;
      if (change > square(0.9) * before) break;
      before = change;
    }
    for (const Row* row : island)
      worst = std::max(worst, violation(*row->contact, *row->impulse, row->mobility, bodies));
  }
  return worst;
}

}  // namespace klang::rigid::detail
