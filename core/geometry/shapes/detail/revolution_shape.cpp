#include "core/geometry/shapes/detail/revolution_shape.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/detail/profile.hpp"
#include "core/geometry/shapes/detail/profile_change.hpp"
#include "core/geometry/shapes/detail/revolution.hpp"
#include "core/geometry/shapes/detail/section_patches.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;

ProfileChange change_of(const ShapeSpec& spec) { return {read_profile(spec.profile_csv), spec.dims}; }

Profile profile_of(const ShapeSpec& spec) { return change_of(spec).changed(); }

/// The drawn body's nodes moved to where the changed one has them.
void move_nodes(const ProfileChange& change, TetMesh& mesh) {
  for (Eigen::Index node = 0; node < mesh.nodes_m.rows(); ++node) {
    const double r_m = std::hypot(mesh.nodes_m(node, 0), mesh.nodes_m(node, 1));
    const Vector2d moved = change({r_m, mesh.nodes_m(node, 2)});
    if (r_m > 0.0) mesh.nodes_m.row(node).head<2>() *= moved.x() / r_m;
    mesh.nodes_m(node, 2) = moved.y();
  }
}

/// Counts: around, divisions of the profile's extent, halvings of the flat triangles.
class RevolutionShape : public ShapeKind {
 public:
  RevolutionShape()
      : ShapeKind(
            {"revolution", "polygon turned about the z axis", "axis z, heights as in the profile", {}, true, true}) {}

  void check_relations(const ShapeSpec& spec) const override { change_of(spec); }

  double volume_m3(const ShapeSpec& spec) const override { return profile_volume_m3(profile_of(spec)); }
  double area_m2(const ShapeSpec& spec) const override { return profile_area_m2(profile_of(spec)); }

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const override {
    const Profile profile = profile_of(spec);
    double widest_m = 0.0;
    for (const Vector2d& point : profile.points_m) widest_m = std::max(widest_m, point.x());
    const double extent_m = profile_extent_m(profile);
    if (edge_m > 0.0) return {divided(2.0 * kPi * widest_m, edge_m, 12), divided(extent_m, edge_m), 0};
    return {24, rounded(std::max(8.0, 0.5 * extent_m / profile_thickness_m(profile)), 8, 60), 0};
  }

  ShapeDivisions refined(const std::array<int, 3>& counts, int level) const override {
    const ShapeDivisions divisions{{counts[0] << level, counts[1], level}};
    check_element_count(static_cast<double>(divisions.counts[0]) * divisions.counts[1]);
    return divisions;
  }

  TetMesh mesh(const ShapeSpec& spec, const ShapeDivisions& divisions, int order) const override {
    TetMesh mesh = mesh_revolution(read_profile(spec.profile_csv), divisions.counts, order);
    if (!spec.dims.empty()) move_nodes(change_of(spec), mesh);
    return mesh;
  }

  ShapeDivisions resonance_divisions(const ShapeSpec& spec, double, double) const override {
    ShapeDivisions divisions = refined(counts(spec, 0.0), 0);
    divisions.counts[0] = std::max(divisions.counts[0], 36);
    return divisions;
  }

  ShapeDivisions reference_divisions(const ShapeSpec& spec) const override { return refined(counts(spec, 0.0), 1); }

  bool is_axisymmetric(const ShapeSpec&) const override { return true; }
  std::string axisymmetric_words() const override { return facts().name; }
  double section_thickness_m(const ShapeSpec& spec) const override { return profile_thickness_m(profile_of(spec)); }

  /// The profile's extent over the edge. Thin walls get triangles about as long as the wall is thick, which three
  /// quadrilaterals each divide further.
  std::array<int, 3> section_counts(const ShapeSpec& spec, double edge_m) const override {
    const Profile profile = profile_of(spec);
    const double wanted_m = std::min(edge_m, 4.0 * profile_thickness_m(profile));
    return {std::clamp(static_cast<int>(std::ceil(profile_extent_m(profile) / wanted_m)), 4, 4000), 1, 0};
  }

  std::vector<SectionPatch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const override {
    const Profile drawn = read_profile(spec.profile_csv);
    std::vector<SectionPatch> patches = profile_patches(drawn, profile_extent_m(drawn) / n[0]);
    if (spec.dims.empty()) return patches;
    const auto change = std::make_shared<ProfileChange>(drawn, spec.dims);
    for (SectionPatch& patch : patches)
      patch.map = [change, drawn_map = patch.map](double u, double v) { return (*change)(drawn_map(u, v)); };
    return patches;
  }
};

}  // namespace

const ShapeKind& revolution_shape() {
  static const RevolutionShape shape;
  return shape;
}

}  // namespace klang::mesh::detail
