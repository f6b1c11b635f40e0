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
void mirrored_normal_derivative(const SourceColumns& sources, const TargetPoint& target, int mode_class,
                                double wavenumber_per_m, double eta_per_m, double* re, double* im);

/// The same sources far away, without the factor e^{-ikr} / (4 pi r): sum_s sign(s) (d/dnu_y + i eta) e^{ik d.s y} for the direction d is
/// 8 i^(number of odd axes) (dipole + i eta monopole), both real; here their sums over the sources with densities q:
///   out = sum_j q_j (dipole_j + i eta monopole_j)
/// @param direction        of length 1, no component below 0
/// @param q_re, q_im       n_padded numbers each, 0 in the padding
/// @returns {re, im} of the sum; points in the first octant
std::array<double, 2> mirrored_far_field(const SourceColumns& sources, const std::array<double, 3>& direction,
                                         int mode_class, double wavenumber_per_m, double eta_per_m, const double* q_re,
                                         const double* q_im);

}  // namespace klang::soundbank::detail
