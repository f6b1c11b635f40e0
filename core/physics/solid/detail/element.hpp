#pragma once
#include <array>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::solid::detail {

inline constexpr int kMaxNodes = 10;
inline constexpr int kStride = 32;  ///< 30 gradient components, padded so that rows vectorise

/// What one element adds, before any material constant:
///   gradient_products[3 i + a][3 j + b] = int dN_i/dx_a dN_j/dx_b,  mass[i][j] = int N_i N_j.
/// K_lambda and K_mu are sums of these: K_lambda_(ia)(jb) = H_(ia)(jb),
/// K_mu_(ia)(jb) = H_(ib)(ja) + delta_ab sum_c H_(ic)(jc).
struct ElementIntegrals {
  alignas(64) std::array<std::array<double, kStride>, kStride> gradient_products;
  std::array<std::array<double, kMaxNodes>, kMaxNodes> mass;
  double volume_m3 = 0;
};

/// Integrals over element `e`; false when the Jacobian determinant is not positive at every integration
/// point. Straight elements: exact. Curved quadratic elements: 14 points, degree 5, all weights positive
/// (Walkington 2000). Volume and the linear patch test stay exact there (det J has degree 3, grad N_i det J
/// too); the rest has the element's own order of error, since order 2k - 1 = 3 suffices for eigenvalues of
/// order 2k = 4.
bool integrate_element(const mesh::TetMesh& mesh, int e, ElementIntegrals& out);

}  // namespace klang::solid::detail
