#include "core/geometry/shapes/detail/shell_box_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/detail/convex_wedges.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector3d;

/// Counts: along an edge of the hollow (made even), through the wall.
class ShellBoxShape : public BlockShape {
 public:
  ShellBoxShape()
      : BlockShape({"shell_box",
                    "hollow closed cube",
                    "centred on the origin",
                    {{"edge_m", "outer edge"}, {"wall_m", "thickness of the wall, below edge_m / 2"}}}) {}

  void check_relations(const ShapeSpec& spec) const override {
    const double half_m = 0.5 * dimension(spec, "edge_m");
    check_below(spec, "wall_m", half_m, "below edge_m / 2 = " + to_text(half_m));
  }

  double volume_m3(const ShapeSpec& spec) const override {
    return std::pow(dimension(spec, "edge_m"), 3) - std::pow(hollow_m(spec), 3);
  }

  double area_m2(const ShapeSpec& spec) const override {
    const double edge_m = dimension(spec, "edge_m"), inner_m = hollow_m(spec);
    return 6.0 * (edge_m * edge_m + inner_m * inner_m);
  }

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const override {
    const double wall_m = dimension(spec, "wall_m"), inner_m = hollow_m(spec);
    if (edge_m > 0.0) return {2 * divided(0.5 * inner_m, edge_m), divided(wall_m, edge_m), 1};
    return {12, rounded(4.0 * wall_m / inner_m, 1, 4), 1};
  }

  /// Six walls: two whole, two between them, two between all of these.
  std::vector<Eigen::Matrix3Xd> convex_parts(const ShapeSpec& spec) const override {
    const double outer_m = 0.5 * dimension(spec, "edge_m"), inner_m = 0.5 * hollow_m(spec);
    std::vector<Eigen::Matrix3Xd> walls;
    for (int across = 2; across >= 0; --across) {
      Vector3d half;
      for (int axis = 0; axis < 3; ++axis) half[axis] = axis > across ? inner_m : outer_m;
      for (const double side : {-1.0, 1.0}) {
        Vector3d low = -half, high = half;
        (side < 0 ? high : low)[across] = side * inner_m;
        walls.push_back(cuboid_corners(low, high));
      }
    }
    return walls;
  }

  /// Seven bricks per octant: each direction is beside the hollow or beyond its face.
  std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const override {
    const double edge_m = dimension(spec, "edge_m"), wall_m = dimension(spec, "wall_m");
    struct Part {
      Segment segment;
      bool beyond;
      std::string inner_face, outer_face;  // of the hollow and of the cube, where this part reaches them
    };
    const auto parts = [&](const std::string& axis) {
      std::vector<Part> result;
      const double inner = 0.5 * edge_m - wall_m;
      for (const double sign : {-1.0, 1.0}) {
        result.push_back({{std::max(1, (n[0] + 1) / 2), 0.0, sign * inner, "", ""}, false, "", ""});
        result.push_back(
            {{n[1], sign * inner, sign * 0.5 * edge_m, "", ""}, true, "inner", axis + (sign < 0.0 ? "_min" : "_max")});
      }
      return result;
    };
    std::vector<Block> blocks;
    for (const Part& x : parts("x"))
      for (const Part& y : parts("y"))
        for (const Part& z : parts("z")) {
          const int n_beyond = x.beyond + y.beyond + z.beyond;
          if (n_beyond == 0) continue;
          const auto inner = [&](const Part& part) { return n_beyond == 1 ? part.inner_face : std::string(); };
          blocks.push_back({{x.segment.n, y.segment.n, z.segment.n},
                            [xs = x.segment, ys = y.segment, zs = z.segment](double u, double v, double w) -> Vector3d {
                              return {xs.at(u), ys.at(v), zs.at(w)};
                            },
                            {inner(x), x.outer_face, inner(y), y.outer_face, inner(z), z.outer_face}});
        }
    return blocks;
  }

 private:
  static double hollow_m(const ShapeSpec& spec) { return dimension(spec, "edge_m") - 2.0 * dimension(spec, "wall_m"); }
};

}  // namespace

const ShapeKind& shell_box_shape() {
  static const ShellBoxShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
