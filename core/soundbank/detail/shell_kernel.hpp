#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace klang::soundbank::detail {

/// Source points with their normals, padded to a multiple of 8 (the padding repeats the last point).
struct SourceColumns {
  std::size_t n_padded = 0;
  std::array<std::vector<double>, 3> points_m, normals;
};

/// A point on the surface with its normal.
struct TargetPoint {
  std::array<double, 3> point_m, normal;
};

/// Normal derivative at the target of combined sources (d/dnu_y + i eta) G(x, y), G = e^{-ikR} / (4 pi R), summed over the eight
/// mirror images of each source with a sign for each reflection in which the field is odd:
///   re + i im [j] = sum_s sign(s) n.grad_x (d/dnu_y + i eta) G(x, s y_j)
/// @param mode_class  bit d: odd in axis d
/// @param re, im      n_padded numbers each, written
void mirrored_normal_derivative(const SourceColumns& sources, const TargetPoint& target, int mode_class, double wavenumber_per_m,
                                double eta_per_m, double* re, double* im);

}  // namespace klang::soundbank::detail
