#include "core/geometry/shapes/detail/ellipsoid_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/ball_shape.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector3d;

/// Legendre's form, a >= b >= c: S = 2 pi c^2 + 2 pi a b (E sin^2 phi + F cos^2 phi) / sin phi, cos phi = c / a.
double ellipsoid_area_m2(double x, double y, double z) {
  std::array<double, 3> axes{x, y, z};
  std::sort(axes.begin(), axes.end());
  const double a = axes[2], b = axes[1], c = axes[0];
  const double sine_sq = (a - c) * (a + c) / (a * a);
  if (sine_sq < 1e-12) return 4.0 * kPi * a * b;  // a sphere to 1e-12
  const double modulus_sq = std::clamp((b - c) * (b + c) / (sine_sq * b * b), 0.0, 1.0);
  const double sine = std::sqrt(sine_sq), phi = std::asin(std::min(1.0, sine));
  const double first = std::ellint_1(std::sqrt(modulus_sq), phi), second = std::ellint_2(std::sqrt(modulus_sq), phi);
  return 2.0 * kPi * c * c + 2.0 * kPi * a * b * (second * sine_sq + first * (c / a) * (c / a)) / sine;
}

class EllipsoidShape : public BallShape {
 public:
  EllipsoidShape()
      : BallShape({"ellipsoid",
                   "solid ellipsoid",
                   "centred on the origin",
                   {{"a_m", "semi-axis along x"}, {"b_m", "semi-axis along y"}, {"c_m", "semi-axis along z"}}}) {}

  Vector3d semi_axes_m(const ShapeSpec& spec) const override {
    return {dimension(spec, "a_m"), dimension(spec, "b_m"), dimension(spec, "c_m")};
  }
  double volume_m3(const ShapeSpec& spec) const override {
    const Vector3d axes_m = semi_axes_m(spec);
    return 4.0 / 3.0 * kPi * axes_m.x() * axes_m.y() * axes_m.z();
  }
  double area_m2(const ShapeSpec& spec) const override {
    const Vector3d axes_m = semi_axes_m(spec);
    return ellipsoid_area_m2(axes_m.x(), axes_m.y(), axes_m.z());
  }
  std::string axisymmetric_words() const override { return facts().name + " with a_m = b_m"; }
};

}  // namespace

const ShapeKind& ellipsoid_shape() {
  static const EllipsoidShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
