#include "core/geometry/shapes/detail/rod_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/detail/disk_blocks.hpp"
#include "core/geometry/shapes/detail/section_patches.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Counts: axial, along a quarter of the core (its circle has 8 times as many), across the ring.
class RodShape : public BlockShape {
 public:
  RodShape()
      : BlockShape({"rod",
                    "solid cylinder",
                    "axis z, centred on the origin",
                    {{"length_m", "length along z"}, {"radius_m", "radius"}},
                    false,
                    true}) {}

  double volume_m3(const ShapeSpec& spec) const override {
    const double radius_m = dimension(spec, "radius_m");
    return kPi * radius_m * radius_m * dimension(spec, "length_m");
  }

  double area_m2(const ShapeSpec& spec) const override {
    const double radius_m = dimension(spec, "radius_m");
    return 2.0 * kPi * radius_m * (radius_m + dimension(spec, "length_m"));
  }

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const override {
    const double length_m = dimension(spec, "length_m"), radius_m = dimension(spec, "radius_m");
    if (edge_m > 0.0)
      return {divided(length_m, edge_m), divided(0.25 * kPi * radius_m, edge_m), divided(0.5 * radius_m, edge_m)};
    return {2 * rounded(4.0 * std::sqrt(length_m / radius_m), 3, 60), 2, 2};
  }

  std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const override {
    std::vector<Block> blocks;
    const double radius_m = dimension(spec, "radius_m");
    for (const Segment& z : mirrored_segments(n[0], 0.5 * dimension(spec, "length_m"), "z_min", "z_max"))
      for (const DiskPiece& piece : disk_pieces())
        blocks.push_back({{piece.ring ? n[2] : n[1], n[1], z.n},
                          [=, map = piece.map](double u, double v, double w) -> Vector3d {
                            const Vector2d p = radius_m * map(u, v);
                            return {p.x(), p.y(), z.at(w)};
                          },
                          {"", piece.ring ? "outer" : "", "", "", z.from_face, z.to_face}});
    return blocks;
  }

  ShapeDivisions resonance_divisions(const ShapeSpec& spec, double, double) const override {
    return {{std::min(refined(counts(spec, 0.0), 0).counts[0], 30), 2, 2}};
  }

  std::optional<LongAxis> long_axis(const ShapeSpec&) const override { return LongAxis{2, true}; }

  bool is_axisymmetric(const ShapeSpec&) const override { return true; }
  std::string axisymmetric_words() const override { return facts().name; }
  double section_thickness_m(const ShapeSpec& spec) const override { return 2.0 * dimension(spec, "radius_m"); }

  /// Axial, radial, layers at an end.
  std::array<int, 3> section_counts(const ShapeSpec& spec, double edge_m) const override {
    const double length_m = dimension(spec, "length_m"), radius_m = dimension(spec, "radius_m");
    return {section_divided(length_m, edge_m, 4), section_divided(radius_m, edge_m, 2),
            section_layers(0.5 * radius_m, length_m, edge_m)};
  }

  std::vector<SectionPatch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const override {
    return straight_section(dimension(spec, "length_m"), 0.0, dimension(spec, "radius_m"), n);
  }
};

}  // namespace

const ShapeKind& rod_shape() {
  static const RodShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
