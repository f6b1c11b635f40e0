#include "core/sound/bem/detail/static_integrals.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace klang::acoustics::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

FlatTriangle::FlatTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) : corners{a, b, c} {
  const Vector3d doubled = (b - a).cross(c - a);
  twice_area = doubled.norm();
  normal = doubled / twice_area;
  for (int i = 0; i < 3; ++i) {
    const Vector3d side = corners[(i + 1) % 3] - corners[i];
    edge[i] = side.normalized();
    outward[i] = edge[i].cross(normal);
    gradient[(i + 2) % 3] = -outward[i] * (side.norm() / twice_area);
  }
}

StaticIntegrals static_integrals(const FlatTriangle& triangle, const Vector3d& x, bool with_gradient) {
  const Vector3d& n = triangle.normal;
  const double height = n.dot(x - triangle.corners[0]);
  const Vector3d foot = x - height * n;
  double potential = 0.0;
  Vector3d first_moment = Vector3d::Zero(), edge_sum = Vector3d::Zero();
  std::array<double, 3> t, f, jump;
  std::array<Vector3d, 3> towards;
  std::array<double, 3> radius;
  for (int i = 0; i < 3; ++i) {
    towards[i] = triangle.corners[i] - x;
    radius[i] = towards[i].norm();
  }
  for (int i = 0; i < 3; ++i) {
    const Vector3d &from = towards[i], &to = towards[(i + 1) % 3];
    const double s0 = triangle.edge[i].dot(from), s1 = triangle.edge[i].dot(to);
    t[i] = triangle.outward[i].dot(from);
    const double r0 = radius[i], r1 = radius[(i + 1) % 3];
    const double line_sq = t[i] * t[i] + height * height;
    // ln((r1 + s1) / (r0 + s0)) without the cancellation of r + s at s < 0.
    if (s0 >= 0.0)
      f[i] = std::log((r1 + s1) / (r0 + s0));
    else if (s1 <= 0.0)
      f[i] = std::log((r0 - s0) / (r1 - s1));
    else
      f[i] = std::log((r1 + s1) * (r0 - s0) / line_sq);
    jump[i] = r1 - r0;
    potential += t[i] * f[i];
    first_moment += 0.5 * (line_sq * f[i] + s1 * r1 - s0 * r0) * triangle.outward[i];
    edge_sum += f[i] * triangle.outward[i];
  }
  // Solid angle, positive on the side of the normal (van Oosterom and Strackee 1983).
  double solid_angle = 0.0;
  if (height != 0.0) {
    const Vector3d &a = towards[0], &b = towards[1], &c = towards[2];
    const double la = radius[0], lb = radius[1], lc = radius[2];
    solid_angle =
        2.0 * std::atan2(height * triangle.twice_area, la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  potential -= height * solid_angle;

  StaticIntegrals result;
  Vector3d at_foot;
  for (int b = 0; b < 3; ++b) {
    const Vector3d& g = triangle.gradient[b];
    at_foot[b] = 1.0 + g.dot(foot - triangle.corners[b]);
    result.single[b] = at_foot[b] * potential + g.dot(first_moment);
    result.twice[b] = at_foot[b] * solid_angle - height * g.dot(edge_sum);
  }
  if (with_gradient) {
    // grad_x int phi / R = -n int phi h / R^3 + int phi (y - foot) / R^3, the tensor int (y - foot)(y - foot)^T / R^3
    // being the identity of the plane times the potential less edge terms.
    for (int b = 0; b < 3; ++b) {
      const Vector3d& g = triangle.gradient[b];
      Vector3d tangential = -at_foot[b] * edge_sum + potential * g;
      for (int i = 0; i < 3; ++i) {
        tangential -=
            (t[i] * f[i] * g.dot(triangle.outward[i]) + jump[i] * g.dot(triangle.edge[i])) * triangle.outward[i];
      }
      result.gradient.col(b) = tangential - result.twice[b] * n;
    }
  }
  return result;
}

}  // namespace klang::acoustics::detail
