#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/sound/bem/radiating_surface.hpp"

namespace klang::acoustics::detail {

/// Static double integrals of a pair (test triangle, other triangle) against hat functions a of the test triangle
/// and b of the other: int int phi_a phi_b k(x, y), without 1/(4 pi).
struct NearPair {
  int other;
  Eigen::Matrix3d single;   ///< k = 1/R
  Eigen::Matrix3d twice;    ///< k = d/dn_y 1/R
  Eigen::Matrix3d adjoint;  ///< k = d/dn_x 1/R
};

/// Pairs closer than two of their sizes, by test triangle. The inner integral is a closed form, the outer one a sum
/// over points: 7 for pairs apart, more for pairs that share an edge or a corner.
struct NearField {
  std::vector<std::vector<NearPair>> pairs;  ///< by test triangle, in order of the other triangle
  std::size_t n_pairs() const;
};
/// @param tested  by triangle: whether its pairs are wanted
NearField near_field(const RadiatingSurface& surface, const std::vector<char>& tested);

/// What a frequency adds to the static integrals of a pair: the same integrals of (e^{-ikR} - 1) / R and its normal
/// derivatives, which stay bounded at R = 0; 7 x 7 points for pairs that touch, else 3 x 3. Without 1/(4 pi).
struct SmoothPart {
  Eigen::Matrix3cd single, twice, adjoint;
};
SmoothPart smooth_part(const RadiatingSurface& surface, int test, int other, double wavenumber_per_m);

/// (e^{-iz} - 1) and ((1 + iz) e^{-iz} - 1) without cancellation at small z.
std::complex<double> wave_less_one(double z);
std::complex<double> slope_less_one(double z);

}  // namespace klang::acoustics::detail
