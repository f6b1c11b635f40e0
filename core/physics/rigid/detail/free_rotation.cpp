#include <algorithm>
#include <cmath>

#include "core/physics/rigid/detail/body_state.hpp"

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

bool is_ball(const Eigen::Matrix3d& inertia) {
  return (inertia - inertia(0, 0) * Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= 1e-14 * inertia(0, 0);
}

/// One midpoint step: L1 - L0 = h (L0 + L1)/2 x w((L0 + L1)/2), by fixed-point iteration, which contracts by h |w|: what is left
/// after an iteration is below that times its change.
void midpoint_step(const BodyState& body, Vector3d& l, Eigen::Quaterniond& turn, double h) {
  Vector3d end = l;
  const double size_sq = l.squaredNorm();
  const double contraction_sq = 4.0 * h * h * (body.inverse_inertia * l).squaredNorm();
  for (int k = 0; k < 60; ++k) {
    const Vector3d mean = 0.5 * (l + end);
    const Vector3d next = l + h * mean.cross(body.inverse_inertia * mean);
    const double change_sq = (next - end).squaredNorm();
    end = next;
    if (std::min(contraction_sq, 1.0) * change_sq <= 1e-34 * size_sq) break;
  }
  const Vector3d half = 0.5 * h * (body.inverse_inertia * (0.5 * (l + end)));
  turn =
      (turn * Eigen::Quaterniond(1.0, half.x(), half.y(), half.z())).normalized();  // Cayley: tan(angle / 2) = |half|
  l = end;
}

}  // namespace

void rotate_freely(BodyState& body, double h) {
  if (body.spin.squaredNorm() == 0) return;
  if (is_ball(body.inertia)) {
    const double angle = body.spin.norm() * h;
    body.turn = (Eigen::Quaterniond(Eigen::AngleAxisd(angle, body.spin.normalized())) * body.turn).normalized();
    return;
  }
  const Vector3d world = body.angular_momentum();
  Vector3d l = body.turn.conjugate() * world;
  const double outer = 1 / (4 - std::cbrt(4.0)), inner = 1 - 4 * outer;
  constexpr double kSmallAngle = 4.64e-6;  // its cube is 1e-16
  if (h * body.spin.norm() < kSmallAngle) {
    midpoint_step(body, l, body.turn, h);  // its error, of third order in the angle, is round-off
  } else {
    for (const double share : {outer, outer, inner, outer, outer}) midpoint_step(body, l, body.turn, share * h);
  }
  // From the momentum of the world, so that its round-off does not add up over the steps.
  const Eigen::Matrix3d r = body.turn.toRotationMatrix();
  body.spin = r * (body.inverse_inertia * (r.transpose() * world));
}

void fly_to(BodyState& body, double time, const Vector3d& gravity) {
  const double h = time - body.clock;
  if (!body.there || body.fixed() || !(h > 0)) return;
  body.centre += h * (body.velocity + 0.5 * h * gravity);
  body.velocity += h * gravity;
  rotate_freely(body, h);
  body.clock = time;
}

}  // namespace klang::rigid::detail
