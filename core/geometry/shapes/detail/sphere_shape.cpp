#include "core/geometry/shapes/detail/sphere_shape.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/ball_shape.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector3d;

class SphereShape : public BallShape {
 public:
  SphereShape() : BallShape({"sphere", "solid ball", "centred on the origin", {{"radius_m", "radius"}}}) {}

  Vector3d semi_axes_m(const ShapeSpec& spec) const override { return Vector3d::Constant(dimension(spec, "radius_m")); }
  double volume_m3(const ShapeSpec& spec) const override {
    return 4.0 / 3.0 * kPi * std::pow(dimension(spec, "radius_m"), 3);
  }
  double area_m2(const ShapeSpec& spec) const override {
    return 4.0 * kPi * dimension(spec, "radius_m") * dimension(spec, "radius_m");
  }
  std::string axisymmetric_words() const override { return facts().name; }
};

}  // namespace

const ShapeKind& sphere_shape() {
  static const SphereShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
