#include "core/physics/rigid/detail/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/physics/rigid/detail/mixing.hpp"

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
constexpr int kMixEvery = 2, kUnmixed = 12;  // sweeps; most groups of a few points need no more than the latter

using Twist = Eigen::Matrix<double, 6, 1>;     // velocity, spin
using Wrenches = Eigen::Matrix<double, 6, 3>;  // a column per axis of a contact

double square(double x) { return x * x; }

/// A contact as the sweeps need it.
struct Row {
  Contact* contact = nullptr;
  Twist* body[2] = {nullptr, nullptr};  // null: does not move
  Wrenches sight[2], kick[2];           // u = sight . twist; twist += kick J
  Vector3d still = Vector3d::Zero();    // what bodies that do not move add to u
  Vector3d mobility = Vector3d::Zero();
  double normal_give = 0.0, across = 0.0, across_give = 0.0;  // impulse per speed; speed per impulse
  double target = 0.0, friction = 0.0;                        // the contact's
  bool tied = false;
  int island = -1;
  Vector3d* impulse = nullptr;

  double speed(int axis) const {
    double u = still[axis];
    for (int side = 0; side < 2; ++side)
      if (body[side] != nullptr) u += sight[side].col(axis).dot(*body[side]);
    return u;
  }
  void push(int axis, double by) {
    for (int side = 0; side < 2; ++side)
      if (body[side] != nullptr) *body[side] += by * kick[side].col(axis);
  }
  double sweep();
};

/// The largest change of a velocity, squared: roots wait for it.
double Row::sweep() {
  Vector3d& sum = *impulse;
  if (tied) {
    double change = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double by = speed(axis);
      push(axis, -by / mobility[axis]);
      sum[axis] -= by / mobility[axis];
      change = std::max(change, square(by));
    }
    return change;
  }
  const double normal = std::max(0.0, sum[0] - (speed(0) - target) * normal_give) - sum[0];
  if (normal != 0) push(0, normal);
  sum[0] += normal;
  const double limit = friction * sum[0];
  if (!(limit > 0) && sum[1] == 0 && sum[2] == 0) return square(normal * mobility[0]);
  Eigen::Vector2d next = sum.tail<2>() - across_give * Eigen::Vector2d(speed(1), speed(2));
  if (next.squaredNorm() > limit * limit) next *= limit / next.norm();
  const Eigen::Vector2d step = next - sum.tail<2>();
  push(1, step[0]);
  push(2, step[1]);
  sum.tail<2>() = next;
  return std::max(square(normal * mobility[0]), step.squaredNorm() * square(across));
}

/// @param twists  of a and b
Row row_of(Contact& c, Vector3d Contact::*impulse, const std::array<Twist*, 2>& twists, const Bodies& bodies) {
  Row row;
  row.contact = &c;
  row.impulse = &(c.*impulse);
  row.target = c.target;
  row.friction = c.friction;
  row.tied = c.tied;
  for (int side = 0; side < 2; ++side) {
    const int number = side == 0 ? c.a : c.b;
    if (number < 0) continue;
    const BodyState& body = bodies.all[static_cast<std::size_t>(number)];
    const Vector3d& place = side == 0 ? c.arm_a : c.arm_b;
    const double sign = side == 0 ? 1.0 : -1.0;
    if (body.fixed()) {
      row.still += sign * (c.axes.transpose() * (body.velocity + body.spin.cross(place)));
      continue;
    }
    row.body[side] = twists[static_cast<std::size_t>(side)];
    const Eigen::Matrix3d& inverse = bodies.inverse_inertia[static_cast<std::size_t>(number)];
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d direction = sign * c.axes.col(axis), turning = place.cross(direction), spin = inverse * turning;
      row.sight[side].col(axis) << direction, turning;
      row.kick[side].col(axis) << body.inverse_mass * direction, spin;
      row.mobility[axis] += body.inverse_mass + turning.dot(spin);
    }
  }
  row.across = std::max(row.mobility[1], row.mobility[2]);
  row.normal_give = 1 / row.mobility[0];
  row.across_give = 1 / row.across;
  return row;
}

/// Impulses of an island as one list of numbers.
class Impulses {
 public:
  explicit Impulses(std::span<Row* const> rows) : rows_(rows), start_(now()) {
    for (const Row* row : rows)
      for (Twist* body : row->body)
        if (body != nullptr && std::find(bodies_.begin(), bodies_.end(), body) == bodies_.end())
          bodies_.push_back(body);
    for (const Twist* body : bodies_) twists_.push_back(*body);
  }
  Eigen::VectorXd now() const {
    Eigen::VectorXd all(3 * static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i)
      all.segment<3>(3 * static_cast<Eigen::Index>(i)) = *rows_[i]->impulse;
    return all;
  }
  /// Speeds that impulses alone would give.
  Eigen::VectorXd weights() const {
    Eigen::VectorXd all(3 * static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = *rows_[i];
      all.segment<3>(3 * static_cast<Eigen::Index>(i)) << row.mobility[0], row.across, row.across;
    }
    return all;
  }
  /// The nearest to these that push, and rub within friction's cone; bodies' motions by all of them since the start, so that wide
  /// ways there and back leave no round-off.
  void become(const Eigen::VectorXd& wanted) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) *bodies_[i] = twists_[i];
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      Vector3d sum = wanted.segment<3>(3 * static_cast<Eigen::Index>(i));
      const Contact& c = *rows_[i]->contact;
      if (!c.tied) {
        sum[0] = std::max(0.0, sum[0]);
        const double limit = c.friction * sum[0];
        if (sum.tail<2>().squaredNorm() > limit * limit) sum.tail<2>() *= limit / sum.tail<2>().norm();
      }
      *rows_[i]->impulse = sum;
      sum -= start_.segment<3>(3 * static_cast<Eigen::Index>(i));
      for (int axis = 0; axis < 3; ++axis) rows_[i]->push(axis, sum[axis]);
    }
  }

 private:
  std::span<Row* const> rows_;
  std::vector<Twist*> bodies_;
  std::vector<Twist> twists_;  // at the start
  Eigen::VectorXd start_;
};

/// Sweeps over one island until it has settled. Where they are slow, as in a pile, what comes next is mixed from several outcomes, and
/// the best is kept of what does not settle.
void settle(std::span<Row* const> island, int sweeps, double tolerance) {
  std::optional<Impulses> impulses;
  std::optional<Mixing> mixing;
  Eigen::VectorXd from, best;
  double change = 0.0, before = HUGE_VAL, least = HUGE_VAL;
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    const bool mixes = sweep >= kUnmixed && sweep % kMixEvery == 0 && island.size() > 1;
    if (mixes && !impulses) {
      impulses.emplace(island);
      mixing.emplace(impulses->weights());
    }
    if (mixes) from = impulses->now();
    change = 0.0;
    for (Row* row : island) change = std::max(change, row->sweep());
    if (change <= square(tolerance)) return;
    if (sweep % kPatience == 0) {
      if (change > square(0.9) * before) break;
      before = change;
    }
    if (!mixes || sweep == sweeps) continue;
    const Eigen::VectorXd to = impulses->now();
    if (change < least) {
      least = change;
      best = to;
    }
    impulses->become(mixing->next(from, to));
  }
  if (least < change) impulses->become(best);
}

/// Numbers the groups of contacts that share no moving body.
void find_islands(std::vector<Row>& rows, const std::vector<Twist>& twists) {
  std::vector<int> parent(twists.size());
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = static_cast<int>(i);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  const auto number = [&](const Twist* body) { return static_cast<int>(body - twists.data()); };
  for (const Row& row : rows)
    if (row.body[0] != nullptr && row.body[1] != nullptr)
      parent[static_cast<std::size_t>(root(number(row.body[0])))] = root(number(row.body[1]));
  for (Row& row : rows) {
    const Twist* moving = row.body[0] != nullptr ? row.body[0] : row.body[1];
    row.island = moving == nullptr ? -1 : root(number(moving));
  }
}

}  // namespace

double solve_contacts(std::span<Contact* const> contacts, Vector3d Contact::*impulse, int sweeps, double tolerance,
                      Bodies& bodies) {
  std::vector<int> slot(bodies.all.size(), -1);
  std::vector<std::size_t> touching;
  for (const Contact* contact : contacts) {
    for (const int body : {contact->a, contact->b}) {
      if (body < 0 || slot[static_cast<std::size_t>(body)] >= 0) continue;
      slot[static_cast<std::size_t>(body)] = static_cast<int>(touching.size());
      touching.push_back(static_cast<std::size_t>(body));
    }
  }
  std::vector<Twist> twists(touching.size());
  for (std::size_t i = 0; i < twists.size(); ++i)
    twists[i] << bodies.all[touching[i]].velocity, bodies.all[touching[i]].spin;
  const auto twist_of = [&](int body) {
    return body < 0 ? nullptr : &twists[static_cast<std::size_t>(slot[static_cast<std::size_t>(body)])];
  };
  static thread_local std::vector<Row> rows;  // large: its room is kept from call to call
  rows.clear();
  rows.reserve(contacts.size());
  for (Contact* c : contacts) rows.push_back(row_of(*c, impulse, {twist_of(c->a), twist_of(c->b)}, bodies));
  find_islands(rows, twists);
  std::vector<Row*> order;
  for (Row& row : rows) order.push_back(&row);
  std::stable_sort(order.begin(), order.end(), [](const Row* x, const Row* y) { return x->island < y->island; });
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && order[last]->island == order[first]->island) ++last;
    if (order[first]->island >= 0)  // else nothing there moves
      settle(std::span<Row* const>(order.data() + first, last - first), sweeps, tolerance);
  }
  for (std::size_t i = 0; i < twists.size(); ++i) {
    BodyState& body = bodies.all[touching[i]];
    body.velocity = twists[i].head<3>();
    body.spin = twists[i].tail<3>();
  }
  double worst = 0.0;
  for (const Row& row : rows)
    if (row.island >= 0) worst = std::max(worst, violation(*row.contact, *row.impulse, row.mobility, bodies));
  return worst;
}

}  // namespace klang::rigid::detail
