#include "core/geometry/shapes/shape_kind.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/detail/convex_wedges.hpp"

namespace klang::mesh {

ShapeKind::ShapeKind(ShapeFacts facts) : facts_(std::move(facts)) {
  for (const ShapeDimension& dimension : facts_.dimensions) dimension_names_.push_back(dimension.name);
}

void ShapeKind::check_relations(const ShapeSpec&) const {}

ShapeDivisions ShapeKind::refined(const std::array<int, 3>& counts, int level) const {
  ShapeDivisions divisions{counts};
  double n_cells = 1.0;
  for (int& count : divisions.counts) {
    n_cells *= std::ldexp(count, level);
    detail::check_element_count(n_cells);
    count <<= level;
  }
  return divisions;
}

std::vector<Eigen::Matrix3Xd> ShapeKind::convex_parts(const ShapeSpec& spec) const {
  return detail::convex_wedges(section_patches(spec, {1, 1, 0}));
}

std::vector<RoundSurface> ShapeKind::round_surfaces(const ShapeSpec& spec) const {
  return is_axisymmetric(spec) ? detail::outline_rings(section_patches(spec, {1, 1, 0})) : std::vector<RoundSurface>();
}

ShapeDivisions ShapeKind::resonance_divisions(const ShapeSpec& spec, double, double) const {
  return refined(counts(spec, 0.0), 0);
}

ShapeDivisions ShapeKind::reference_divisions(const ShapeSpec& spec) const {
  ShapeDivisions divisions = refined(counts(spec, 0.0), 0);
  for (int& count : divisions.counts) count += (count / 2 + 1) / 2 * 2;
  return divisions;
}

std::optional<LongAxis> ShapeKind::long_axis(const ShapeSpec&) const { return {}; }

bool ShapeKind::is_axisymmetric(const ShapeSpec&) const { return false; }

std::string ShapeKind::axisymmetric_words() const { return ""; }

double ShapeKind::section_thickness_m(const ShapeSpec&) const {
  KLANG_CHECK(false, "a kind without a section");
  return 0.0;
}

std::array<int, 3> ShapeKind::section_counts(const ShapeSpec&, double) const {
  KLANG_CHECK(false, "a kind without a section");
  return {};
}

std::vector<SectionPatch> ShapeKind::section_patches(const ShapeSpec&, const std::array<int, 3>&) const {
  KLANG_CHECK(false, "a kind without a section");
  return {};
}

}  // namespace klang::mesh
