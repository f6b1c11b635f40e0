#include "core/geometry/shapes/detail/pebble_shape.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/ball_shape.hpp"

namespace klang::mesh::detail {
namespace {

class PebbleShape : public BallShape {
 public:
  PebbleShape()
      : BallShape({"pebble", "ball by its diameter", "centred on the origin", {{"diameter_m", "diameter"}}}) {}

  Eigen::Vector3d semi_axes_m(const ShapeSpec& spec) const override {
    return Eigen::Vector3d::Constant(dimension(spec, "diameter_m") / 2);
  }
  double volume_m3(const ShapeSpec& spec) const override {
    return kPi / 6 * std::pow(dimension(spec, "diameter_m"), 3);
  }
  double area_m2(const ShapeSpec& spec) const override { return kPi * std::pow(dimension(spec, "diameter_m"), 2); }
  std::string axisymmetric_words() const override { return facts().name; }
};

}  // namespace

const ShapeKind& pebble_shape() {
  static const PebbleShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
