#include "core/geometry/shapes/detail/undercut_bar_shape.hpp"

#include <cmath>

#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/detail/convex_wedges.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector3d;

struct Sides {
  double length = 0.0, width = 0.0, height = 0.0, cut_length = 0.0, cut_depth = 0.0;

  /// h(x) = height - depth (1 - (2 x / undercut_length)^2) within the undercut, else the height.
  double height_at(double x) const {
    const double s = 2.0 * x / cut_length;
    return std::abs(s) < 1.0 ? height - cut_depth * (1.0 - s * s) : height;
  }
  double thinnest() const { return height - cut_depth; }
};

Sides sides_of(const ShapeSpec& spec) {
  return {dimension(spec, "length_m"), dimension(spec, "width_m"), dimension(spec, "height_m"),
          dimension(spec, "undercut_length_m"), dimension(spec, "undercut_depth_m")};
}

/// Counts: x, y, z.
class UndercutBarShape : public BlockShape {
 public:
  UndercutBarShape()
      : BlockShape({"undercut_bar",
                    "bar with a parabolic undercut (marimba, xylophone)",
                    "centred on the origin, the undercut below",
                    {{"length_m", "side along x"},
                     {"width_m", "side along y"},
                     {"height_m", "side along z, at the ends"},
                     {"undercut_length_m", "of the parabola along x"},
                     {"undercut_depth_m", "of the parabola in the middle"}}}) {}

  void check_relations(const ShapeSpec& spec) const override {
    check_below(spec, "undercut_length_m", dimension(spec, "length_m"), "below length_m");
    check_below(spec, "undercut_depth_m", dimension(spec, "height_m"), "below height_m");
  }

  double volume_m3(const ShapeSpec& spec) const override {
    const Sides s = sides_of(spec);
    return s.width * side_area(s);
  }

  double area_m2(const ShapeSpec& spec) const override {
    const Sides s = sides_of(spec);
    const double half = 0.5 * s.cut_length, slope = 2.0 * s.cut_depth / half;  // at the parabola's end
    const double arc = half * std::sqrt(1.0 + slope * slope) + half * std::asinh(slope) / slope;
    return s.width * (2.0 * s.length - s.cut_length + arc) + 2.0 * side_area(s) + 2.0 * s.width * s.height;
  }

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const override {
    const Sides s = sides_of(spec);
    if (edge_m > 0.0) return {divided(s.length, edge_m), divided(s.width, edge_m), divided(s.height, edge_m)};
    const int along = 2 * rounded(25.0 * std::cbrt(s.length / (15.0 * s.thinnest())), 20, 60);
    return {along, s.width > 1.5 * s.height ? 10 : 6, 4};
  }

  /// Two layers of quadratic elements bend like a beam; along the bar even ones of the thin middle's size.
  ShapeDivisions resonance_divisions(const ShapeSpec& spec, double, double) const override {
    const Sides s = sides_of(spec);
    ShapeDivisions divisions = refined(counts(spec, 0.0), 0);
    divisions.counts = {2 * rounded(0.35 * s.length / s.thinnest(), 8, 16), 2 * rounded(0.5 * s.width / s.height, 2, 4),
                        2};
    return divisions;
  }

  std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const override {
    const Sides s = sides_of(spec);
    const double half = 0.5 * s.length, half_cut = 0.5 * s.cut_length;
    // Shares that no dimension changes: meshes of changed dimensions have the same cells.
    const int n_inner = 2 * rounded(0.3 * n[0], 2, 1000000), n_outer = rounded(0.2 * n[0], 1, 1000000);
    std::vector<Segment> along = mirrored_segments(n_inner, half_cut, "", "");
    along.push_back({n_outer, -half, -half_cut, "x_min", "", 0.0});
    along.push_back({n_outer, half_cut, half, "", "x_max", 0.0});
    std::vector<Block> blocks;
    for (const Segment& x : along)
      for (const Segment& y : mirrored_segments(n[1], 0.5 * s.width, "y_min", "y_max", 0.2))
        for (const Segment& z : mirrored_segments(n[2], 0.5, "z_min", "z_max"))
          blocks.push_back({{x.n, y.n, z.n},
                            [=](double u, double v, double w) -> Vector3d {
                              const double at = x.at(u);
                              return {at, y.at(v), 0.5 * s.height - s.height_at(at) * (0.5 - z.at(w))};
                            },
                            {x.from_face, x.to_face, y.from_face, y.to_face, z.from_face, z.to_face}});
    return blocks;
  }

  /// Slices: a chord of the parabola lies depth / n^2 below it.
  std::vector<Eigen::Matrix3Xd> convex_parts(const ShapeSpec& spec) const override {
    constexpr int kSlices = 8;
    const Sides s = sides_of(spec);
    const double top = 0.5 * s.height, y = 0.5 * s.width, half_cut = 0.5 * s.cut_length;
    std::vector<Eigen::Matrix3Xd> parts{cuboid_corners({-0.5 * s.length, -y, -top}, {-half_cut, y, top}),
                                        cuboid_corners({half_cut, -y, -top}, {0.5 * s.length, y, top})};
    for (int i = 0; i < kSlices; ++i) {
      const double x0 = -half_cut + s.cut_length * i / kSlices, x1 = -half_cut + s.cut_length * (i + 1) / kSlices;
      const double z0 = top - s.height_at(x0), z1 = top - s.height_at(x1);
      Eigen::Matrix3Xd& corners = parts.emplace_back(3, 8);
      corners << x0, x0, x0, x0, x1, x1, x1, x1, -y, y, -y, y, -y, y, -y, y, z0, z0, top, top, z1, z1, top, top;
    }
    return parts;
  }

  std::optional<LongAxis> long_axis(const ShapeSpec&) const override { return LongAxis{0, false}; }

 private:
  static double side_area(const Sides& s) { return s.length * s.height - 2.0 / 3.0 * s.cut_length * s.cut_depth; }
};

}  // namespace

const ShapeKind& undercut_bar_shape() {
  static const UndercutBarShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
