#include "core/geometry/shapes/detail/ball_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/disk_blocks.hpp"
#include "core/geometry/shapes/detail/section_patches.hpp"

namespace klang::mesh::detail {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::array<int, 3> BallShape::counts(const ShapeSpec& spec, double edge_m) const {
  const double largest_m = semi_axes_m(spec).maxCoeff();
  if (edge_m > 0.0) return {divided(0.25 * kPi * largest_m, edge_m), divided(0.5 * largest_m, edge_m), 1};
  return {4, 3, 1};
}

std::vector<Block> BallShape::blocks(const ShapeSpec& spec, std::array<int, 3> n) const {
  std::vector<Block> blocks;
  const Vector3d axes_m = semi_axes_m(spec);
  for (const BallPiece& piece : ball_pieces())
    blocks.push_back(
        {{piece.shell ? n[1] : n[0], n[0], n[0]},
         [=, map = piece.map](double u, double v, double w) -> Vector3d { return axes_m.cwiseProduct(map(u, v, w)); },
         {"", piece.shell ? "outer" : "", "", "", "", ""}});
  return blocks;
}

std::vector<Eigen::Matrix3Xd> BallShape::convex_parts(const ShapeSpec& spec) const {
  constexpr int kRings = 9, kAround = 16;  // chords leave out 1 % at most
  Eigen::Matrix3Xd corners(3, kRings * kAround + 2);
  corners.col(0) = -Vector3d::UnitZ();
  corners.col(1) = Vector3d::UnitZ();
  for (int i = 0; i < kRings * kAround; ++i) {
    const double polar = kPi * (i / kAround + 1) / (kRings + 1), angle = 2.0 * kPi * (i % kAround) / kAround;
    corners.col(2 + i) << std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar);
  }
  return {semi_axes_m(spec).asDiagonal() * corners};
}

std::vector<RoundSurface> BallShape::round_surfaces(const ShapeSpec& spec) const {
  RoundSurface whole;
  whole.axes_m = semi_axes_m(spec).asDiagonal();
  return {whole};
}

bool BallShape::is_axisymmetric(const ShapeSpec& spec) const {
  const Vector3d axes_m = semi_axes_m(spec);
  return axes_m.x() == axes_m.y();
}

double BallShape::section_thickness_m(const ShapeSpec& spec) const {
  const Vector3d axes_m = semi_axes_m(spec);
  return 2.0 * std::min(axes_m.x(), axes_m.z());
}

std::array<int, 3> BallShape::section_counts(const ShapeSpec& spec, double edge_m) const {
  const Vector3d axes_m = semi_axes_m(spec);
  return {section_divided(0.6 * std::max(axes_m.x(), axes_m.z()), edge_m, 2), 1, 0};
}

std::vector<SectionPatch> BallShape::section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const {
  const Vector3d axes_m = semi_axes_m(spec);
  const double a_m = axes_m.x(), c_m = axes_m.z();
  return half_disk(n[0], [=](const Vector2d& p) -> Vector2d { return {a_m * p.x(), c_m * p.y()}; });
}

}  // namespace klang::mesh::detail
