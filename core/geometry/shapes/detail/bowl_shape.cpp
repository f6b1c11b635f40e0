#include "core/geometry/shapes/detail/bowl_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/detail/convex_wedges.hpp"
#include "core/geometry/shapes/detail/disk_blocks.hpp"
#include "core/geometry/shapes/detail/section_patches.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Volume of a spherical cap of radius r and height h: pi h^2 (3 r - h) / 3.
double cap_volume_m3(double radius_m, double height_m) {
  return kPi * height_m * height_m * (3.0 * radius_m - height_m) / 3.0;
}

struct Bowl {
  double outer_m, wall_m, depth_m;
};

Bowl bowl_of(const ShapeSpec& spec) {
  return {dimension(spec, "outer_radius_m"), dimension(spec, "wall_m"), dimension(spec, "depth_m")};
}

/// Counts: along a quarter of the core (the rim has 8 times as many), across the ring, through the wall.
class BowlShape : public BlockShape {
 public:
  BowlShape()
      : BlockShape({"bowl",
                    "spherical cap of even wall",
                    "axis z, rim up, its lowest outer point at the origin",
                    {{"outer_radius_m", "outer radius of the sphere"},
                     {"wall_m", "thickness of the wall, below outer_radius_m and depth_m"},
                     {"depth_m", "outer height from pole to rim, below 2 outer_radius_m - wall_m"}},
                    false,
                    true}) {}

  void check_relations(const ShapeSpec& spec) const override {
    const auto [outer_m, wall_m, depth_m] = bowl_of(spec);
    check_below(spec, "wall_m", outer_m, "below outer_radius_m = " + to_text(outer_m));
    check_below(spec, "wall_m", depth_m, "below depth_m = " + to_text(depth_m));
    const double limit_m = 2.0 * outer_m - wall_m;
    check_below(spec, "depth_m", limit_m, "below 2 outer_radius_m - wall_m = " + to_text(limit_m));
  }

  double volume_m3(const ShapeSpec& spec) const override {
    const auto [outer_m, wall_m, depth_m] = bowl_of(spec);
    return cap_volume_m3(outer_m, depth_m) - cap_volume_m3(outer_m - wall_m, depth_m - wall_m);
  }

  /// Caps 2 pi r h, and the flat rim between the circles in its plane.
  double area_m2(const ShapeSpec& spec) const override {
    const auto [outer, wall, depth] = bowl_of(spec);
    return 2.0 * kPi * (outer * depth + (outer - wall) * (depth - wall)) + kPi * wall * (2.0 * outer - wall);
  }

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const override {
    const auto [outer_m, wall_m, depth_m] = bowl_of(spec);
    if (!(edge_m > 0.0)) return {12, 10, rounded(2.0 * wall_m / outer_m, 1, 2)};
    const double arc_m = outer_m * std::acos(1.0 - depth_m / outer_m);
    const double widest_m = depth_m >= outer_m ? outer_m : outer_m * std::sin(arc_m / outer_m);
    return {std::max(divided(0.25 * kPi * widest_m, edge_m), divided(0.5 * arc_m, edge_m)),
            divided(0.5 * arc_m, edge_m), divided(wall_m, edge_m)};
  }

  /// A disk bent over spheres of all radii through the wall: disk radius is polar angle over that of the flat rim.
  std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const override {
    std::vector<Block> blocks;
    for (const DiskPiece& piece : disk_pieces())
      blocks.push_back({{piece.ring ? n[1] : n[0], n[0], n[2]},
                        [bowl = bowl_of(spec), map = piece.map](double u, double v, double w) -> Vector3d {
                          const double radius_m = bowl.outer_m - (1.0 - w) * bowl.wall_m;
                          const double rim_angle = std::acos((bowl.outer_m - bowl.depth_m) / radius_m);
                          const Vector2d disk = map(u, v);
                          const double angle = rim_angle * disk.norm();
                          const double sine_ratio = angle > 0.0 ? rim_angle * std::sin(angle) / angle : rim_angle;
                          return {radius_m * sine_ratio * disk.x(), radius_m * sine_ratio * disk.y(),
                                  bowl.outer_m - radius_m * std::cos(angle)};
                        },
                        {"", piece.ring ? "z_max" : "", "", "", "inner", "outer"}});
    return blocks;
  }

  /// The sphere below and the rim; the inner circle of the rim lies within the outer one.
  std::vector<RoundSurface> round_surfaces(const ShapeSpec& spec) const override {
    const Bowl bowl = bowl_of(spec);
    RoundSurface sphere;
    sphere.centre_m.z() = bowl.outer_m;
    sphere.axes_m = bowl.outer_m * Eigen::Matrix3d::Identity();
    sphere.pole = -Vector3d::UnitZ();
    sphere.least_cosine = 1.0 - bowl.depth_m / bowl.outer_m;
    const double rim_m = std::sqrt(bowl.depth_m * (2.0 * bowl.outer_m - bowl.depth_m));
    return {sphere, ring(rim_m, bowl.depth_m)};
  }

  ShapeDivisions resonance_divisions(const ShapeSpec& spec, double, double) const override {
    ShapeDivisions divisions = refined(counts(spec, 0.0), 0);
    auto& n = divisions.counts;
    n = {std::max(n[0], 10), std::max(n[1], 10), n[2]};
    return divisions;
  }

  bool is_axisymmetric(const ShapeSpec&) const override { return true; }
  std::string axisymmetric_words() const override { return facts().name; }
  double section_thickness_m(const ShapeSpec& spec) const override { return dimension(spec, "wall_m"); }

  /// Along, through the wall, layers at the rim.
  std::array<int, 3> section_counts(const ShapeSpec& spec, double edge_m) const override {
    const auto [outer_m, wall_m, depth_m] = bowl_of(spec);
    const double arc_m = outer_m * std::acos(1.0 - depth_m / outer_m);
    return {section_divided(arc_m, edge_m, 4), section_divided(wall_m, edge_m), section_layers(wall_m, arc_m, edge_m)};
  }

  std::vector<SectionPatch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const override {
    const Bowl bowl = bowl_of(spec);
    const double arc_m = bowl.outer_m * std::acos(1.0 - bowl.depth_m / bowl.outer_m);
    const auto border = layered_borders(1.0, bowl.wall_m / arc_m, n[0], 0, n[2]);
    return {{n[0] + n[2], n[1], [=](double u, double v) -> Vector2d {
               const double radius_m = bowl.outer_m - v * bowl.wall_m;
               const double angle = along(border, u) * std::acos((bowl.outer_m - bowl.depth_m) / radius_m);
               return {radius_m * std::sin(angle), bowl.outer_m - radius_m * std::cos(angle)};
             }}};
  }
};

}  // namespace

const ShapeKind& bowl_shape() {
  static const BowlShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
