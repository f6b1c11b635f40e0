#pragma once
#include "core/geometry/shapes/detail/block_shape.hpp"

namespace klang::mesh::detail {

/// What the sphere and the ellipsoid share: the unit ball stretched along the axes. Counts: along an octant of the core
/// (a great circle has 8 times as many), across the shell. Section counts: around.
class BallShape : public BlockShape {
 public:
  using BlockShape::BlockShape;
  virtual Eigen::Vector3d semi_axes_m(const ShapeSpec& spec) const = 0;

  std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const final;
  std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const final;
  std::vector<Eigen::Matrix3Xd> convex_parts(const ShapeSpec& spec) const final;
  std::vector<RoundSurface> round_surfaces(const ShapeSpec& spec) const final;
  bool is_axisymmetric(const ShapeSpec& spec) const final;
  double section_thickness_m(const ShapeSpec& spec) const final;
  std::array<int, 3> section_counts(const ShapeSpec& spec, double edge_m) const final;
  std::vector<SectionPatch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const final;
};

}  // namespace klang::mesh::detail
