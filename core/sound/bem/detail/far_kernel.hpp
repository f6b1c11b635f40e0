#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "core/sound/waves/vector_math.hpp"

namespace klang::acoustics::detail {

/// Triangles as columns, padded to a multiple of kLanes with triangles of weight 0. Points are those of three_points().
struct TriangleColumns {
  std::size_t n_padded = 0;
  std::array<std::array<std::vector<double>, 3>, 3> points_m;  ///< [point][axis][triangle]
  std::array<std::vector<double>, 3> normals;                  ///< [axis][triangle]
  std::array<std::array<std::vector<double>, 3>, 3> curls;     ///< [corner][axis][triangle]: n x grad phi, 1/m
  std::vector<double> weights_m2;                              ///< area / 3
};

/// One test triangle.
struct TestTriangle {
  std::array<std::array<double, 3>, 3> points_m;  ///< [point][axis]
  std::array<double, 3> normal;
  std::array<std::array<double, 3>, 3> curls;  ///< [corner][axis]
  double weight_m2;                            ///< area / 3
};

/// What a block of kBlockTriangles columns gives: complex 3 x 3 matrices, each entry an array over the columns.
///   system[a][b]: -K + i eta N against the hat functions a (test) and b (column)
///   source[a][q]: -S + i eta K' against the hat function a, for the normal derivative at point q
inline constexpr std::size_t kBlockTriangles = 128;
struct FarBlock {
  alignas(64) double system[3][3][2][kBlockTriangles];
  alignas(64) double source[3][3][2][kBlockTriangles];
};

/// Three by three points, G = e^{-ikR} / (4 pi R). Columns with keep[j] = 0 (1 elsewhere) give zeros: their integrals
/// need better rules. first and count are multiples of kLanes, count <= kBlockTriangles.
/// Relative error of the kernel 1e-10 (own square root and sine, for vector units).
void far_block(const TriangleColumns& columns, const double* keep, std::size_t first, std::size_t count,
               const TestTriangle& test, double wavenumber_per_m, double eta_m, FarBlock& block);

/// Sums of a block's source[a][q] times values at the columns' points, over q and the columns.
/// @param values  [q][re, im]: from the block's first column on
/// @param sums    [a][re, im]
void far_sums(const FarBlock& block, std::size_t count, const double* const values[3][2], double sums[3][2]);

}  // namespace klang::acoustics::detail
