#include "core/sound/scene/detail/rigid_push.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/physics/rigid/convex_parts.hpp"

namespace klang::scene::detail {

using Eigen::Vector3d;

PressedBody::PressedBody(const rigid::RigidWorld& world, int body, Way way) : body_(body), way_(way) {
  const rigid::RigidBodySpec& spec = world.spec(body);
  fixed_ = spec.fixed;
  mass_kg_ = spec.mass_kg;
  ball_radius_m_ = spec.ball_radius_m;
  reach_m_ = 0.5 * spec.size_m();
  skin_ = spec.skin;
  inertia_ = spec.inertia_kg_m2;
  body_centre_m_ = spec.centre_m;
  for (const rigid::ConvexPart& part : spec.parts) {
    const mesh::SurfaceMesh hull = rigid::hull_of(part);
    for (Eigen::Index i = 0; i < hull.vertices_m.rows(); ++i)
      own_corners_.push_back(hull.vertices_m.row(i).transpose());
    std::vector<Plane> planes;
    for (Eigen::Index t = 0; t < hull.triangles.rows(); ++t) {
      const auto corner = [&](int c) -> Vector3d { return hull.vertices_m.row(hull.triangles(t, c)).transpose(); };
      const Vector3d across = (corner(1) - corner(0)).cross(corner(2) - corner(0));
      if (!(across.norm() > 0.0)) continue;
      const Vector3d normal = across.normalized();
      planes.push_back({normal, normal.dot(corner(0))});
    }
    parts_.push_back(std::move(planes));
  }
}

void PressedBody::begin(const rigid::RigidWorld& world, double dt_s, const Vector3d& gravity_m_s2) {
  turn_ = world.pose(body_).orientation().toRotationMatrix();
  gravity_ = fixed_ ? Vector3d::Zero() : gravity_m_s2;
  gained_ = gained_spin_ = shift_ = Vector3d::Zero();
  left_s_ = dt_s;
  rubbed_j_ = 0.0;
  inverse_inertia_ = fixed_ ? Eigen::Matrix3d::Zero() : Eigen::Matrix3d(turn_ * inertia_.inverse() * turn_.transpose());
  if (way_ == Way::kStruck) {
    velocity_ = world.velocity_m_s(body_) - dt_s * gravity_;
    spin_ = world.angular_velocity_rad_s(body_);
    centre_ = world.centre_m(body_) - dt_s * velocity_ - 0.5 * dt_s * dt_s * gravity_;
    return;
  }
  velocity_ = world.velocity_m_s(body_) - lead_ - dt_s * gravity_;
  spin_ = world.angular_velocity_rad_s(body_) - lead_spin_;
  centre_ = end_centre_.value_or(world.centre_m(body_) - dt_s * velocity_);
  end_centre_ = world.centre_m(body_);
  begin_centre_ = centre_;
  begin_velocity_ = velocity_;
}

void PressedBody::rewind() {
  centre_ = begin_centre_;
  velocity_ = begin_velocity_ + gained_;
}

void PressedBody::advance(double dt_s) {
  velocity_ += 0.5 * dt_s * gravity_;
  centre_ += dt_s * velocity_;
  velocity_ += 0.5 * dt_s * gravity_;
  left_s_ -= dt_s;
}

double PressedBody::moving_j() const {
  if (fixed_) return 0.0;
  return 0.5 * mass_kg_ * velocity_.squaredNorm() + 0.5 * spin_.dot(turn_ * (inertia_ * (turn_.transpose() * spin_)));
}

std::vector<Vector3d> PressedBody::corners_m() const {
  std::vector<Vector3d> corners;
  for (const Vector3d& own : own_corners_) corners.push_back(centre_ + turn_ * (own - body_centre_m_));
  return corners;
}

bool PressedBody::is_near(const Vector3d& low, const Vector3d& high) const {
  return (centre_.array() + reach_m_ >= low.array()).all() && (centre_.array() - reach_m_ <= high.array()).all();
}

bool PressedBody::may_hold(const Vector3d& centre, double radius_m) const {
  const Vector3d arm = centre - centre_;
  if (!(arm.norm() <= reach_m_ + radius_m)) return false;
  if (ball_radius_m_ > 0.0) return arm.norm() <= ball_radius_m_ + radius_m;
  const Vector3d own = turn_.transpose() * arm + body_centre_m_;
  return std::any_of(parts_.begin(), parts_.end(), [&](const std::vector<Plane>& planes) {
    return std::all_of(planes.begin(), planes.end(),
                       [&](const Plane& plane) { return plane.normal.dot(own) - plane.offset_m <= radius_m; });
  });
}

std::optional<Depth> PressedBody::depth_of(const Vector3d& x) const {
  const Vector3d arm = x - centre_;
  const double far = arm.norm();
  if (!(far < reach_m_)) return {};
  if (ball_radius_m_ > 0.0) return Depth{ball_radius_m_ - far, far > 0.0 ? Vector3d(arm / far) : Vector3d::UnitZ()};
  const Vector3d own = turn_.transpose() * arm + body_centre_m_;
  for (const std::vector<Plane>& planes : parts_) {
    Depth nearest{HUGE_VAL, Vector3d::Zero()};
    for (const Plane& plane : planes) {
      const double depth = plane.offset_m - plane.normal.dot(own);
      if (depth < nearest.depth_m) nearest = {depth, plane.normal};
      if (depth <= 0.0) break;
    }
    if (nearest.depth_m > 0.0 && std::isfinite(nearest.depth_m)) return Depth{nearest.depth_m, turn_ * nearest.out};
  }
  return {};
}

void PressedBody::push(const Vector3d& x, const Vector3d& impulse_n_s) {
  if (fixed_) return;
  const Vector3d along = impulse_n_s / mass_kg_, turning = inverse_inertia_ * (x - centre_).cross(impulse_n_s);
  velocity_ += along;
  shift_ += left_s_ * along;
  gained_ += along;
  spin_ += turning;
  gained_spin_ += turning;
}

void PressedBody::rub(const Vector3d& x, const Vector3d& impulse_n_s) {
  if (fixed_) return;
  const Vector3d before = velocity_at(x);
  push(x, impulse_n_s);
  rubbed_j_ += 0.5 * impulse_n_s.dot(before + velocity_at(x));
}

double PressedBody::end(rigid::RigidWorld& world) {
  if (gained_.isZero(0.0) && gained_spin_.isZero(0.0) && lead_.isZero(0.0) && lead_spin_.isZero(0.0)) return 0.0;
  const double before_j = world.ledger().work_j;
  if (way_ == Way::kStruck) {
    world.set_velocity(body_, world.velocity_m_s(body_) + gained_, world.angular_velocity_rad_s(body_) + gained_spin_);
    world.shift(body_, shift_);
    return world.ledger().work_j - before_j;
  }
  lead_ = 0.5 * gained_;
  lead_spin_ = 0.5 * gained_spin_;
  world.set_velocity(body_, velocity_ + lead_, spin_ + lead_spin_);
  return world.ledger().work_j - before_j;
}

}  // namespace klang::scene::detail
