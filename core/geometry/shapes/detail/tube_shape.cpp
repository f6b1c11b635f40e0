#include "core/geometry/shapes/detail/tube_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/detail/section_patches.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector3d;

/// Counts: axial, around (even, >= 6), through the wall.
class TubeShape : public BlockShape {
 public:
  TubeShape()
      : BlockShape({"tube",
                    "hollow cylinder, open at both ends",
                    "axis z, centred on the origin",
                    {{"length_m", "length along z"},
                     {"outer_radius_m", "outer radius"},
                     {"wall_m", "thickness of the wall, below outer_radius_m"}},
                    false,
                    true}) {}

  void check_relations(const ShapeSpec& spec) const override {
    const double outer_m = dimension(spec, "outer_radius_m");
    check_below(spec, "wall_m", outer_m, "below outer_radius_m = " + to_text(outer_m));
  }

  double volume_m3(const ShapeSpec& spec) const override {
    const double wall_m = dimension(spec, "wall_m");
    return kPi * wall_m * (2.0 * dimension(spec, "outer_radius_m") - wall_m) * dimension(spec, "length_m");
  }

  double area_m2(const ShapeSpec& spec) const override {
    const double sum_m = 2.0 * dimension(spec, "outer_radius_m") - dimension(spec, "wall_m");  // of both radii
    return 2.0 * kPi * sum_m * (dimension(spec, "length_m") + dimension(spec, "wall_m"));
  }

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const override {
    const double length_m = dimension(spec, "length_m"), outer_m = dimension(spec, "outer_radius_m");
    const double wall_m = dimension(spec, "wall_m"), middle_m = outer_m - 0.5 * wall_m;
    if (edge_m > 0.0)
      return {divided(length_m, edge_m), divided(2.0 * kPi * outer_m, edge_m, 12), divided(wall_m, edge_m)};
    return {2 * rounded(4.6 * std::sqrt(length_m / middle_m), 4, 60), 20, rounded(4.0 * wall_m / middle_m, 1, 4)};
  }

  std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const override {
    n[1] = std::max(6, n[1] + n[1] % 2);
    std::vector<Block> blocks;
    const double outer_m = dimension(spec, "outer_radius_m"), inner_m = outer_m - dimension(spec, "wall_m");
    for (const Segment& z : mirrored_segments(n[0], 0.5 * dimension(spec, "length_m"), "z_min", "z_max"))
      blocks.push_back({{n[2], n[1], z.n},
                        [=](double u, double v, double w) -> Vector3d {
                          const double radius_m = (1.0 - u) * inner_m + u * outer_m;
                          const double angle = 2.0 * kPi * v;
                          return {radius_m * std::cos(angle), radius_m * std::sin(angle), z.at(w)};
                        },
                        {"inner", "outer", "", "", z.from_face, z.to_face}});
    return blocks;
  }

  /// Ring modes (the section turns oval) need twice the elements around; below them bending rules.
  ShapeDivisions resonance_divisions(const ShapeSpec& spec, double bar_speed_m_s, double highest_hz) const override {
    ShapeDivisions divisions = refined(counts(spec, 0.0), 0);
    auto& n = divisions.counts;
    const double wall_m = dimension(spec, "wall_m"), radius_m = dimension(spec, "outer_radius_m") - 0.5 * wall_m;
    const double ring_hz = 2.683 / (2.0 * kPi) * wall_m / (std::sqrt(12.0) * radius_m * radius_m) * bar_speed_m_s;
    n[0] = std::min(n[0], 36);
    n[1] = std::max(n[1], highest_hz > ring_hz ? 40 : 24);
    return divisions;
  }

  std::optional<LongAxis> long_axis(const ShapeSpec&) const override { return LongAxis{2, true}; }

  bool is_axisymmetric(const ShapeSpec&) const override { return true; }
  std::string axisymmetric_words() const override { return facts().name; }
  double section_thickness_m(const ShapeSpec& spec) const override { return dimension(spec, "wall_m"); }

  /// Axial, radial, layers at an end.
  std::array<int, 3> section_counts(const ShapeSpec& spec, double edge_m) const override {
    const double length_m = dimension(spec, "length_m"), wall_m = dimension(spec, "wall_m");
    return {section_divided(length_m, edge_m, 4), section_divided(wall_m, edge_m),
            section_layers(wall_m, length_m, edge_m)};
  }

  std::vector<SectionPatch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const override {
    const double outer_m = dimension(spec, "outer_radius_m");
    return straight_section(dimension(spec, "length_m"), outer_m - dimension(spec, "wall_m"), outer_m, n);
  }
};

}  // namespace

const ShapeKind& tube_shape() {
  static const TubeShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
