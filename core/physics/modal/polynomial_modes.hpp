#pragma once
#include <Eigen/Core>

#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::modal {

struct PolynomialModeOptions {
  int degree = 6;         ///< total, of the polynomials: 2 to 10. (degree + 1)(degree + 2)(degree + 3) / 2 unknowns
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"degree", "Total degree of the polynomials", between(2.0, 10.0)}, self.degree);
  }
};

/// The lowest elastic frequency of a free homogeneous body from its surface alone: no mesh. Rayleigh-Ritz with all polynomials up to a
/// degree as displacements. Their integrals over the body are integrals over its surface (f homogeneous of degree d:
/// int f dV = 1/(d+3) int f x.n dS), exact on flat triangles; then a few steps of Lanczos with (K + s M)^-1 M, the rigid motions taken out.
/// An upper bound. Measured at degree 6 on datasets::debris against finite elements: 0.05 to 0.94 % above, 2 to 4 ms. Bodies that are far from convex (hollow,
/// L-shaped) need degrees beyond the range: not for them.
/// Source: Visscher, Migliori, Bell and Reinert 1991, J. Acoust. Soc. Am. 90, 2154-2162.
/// @param surface  closed, straight triangles (mid-nodes are left out), normals outward
/// @return frequency [Hz]
/// @throws InputError for a surface whose volume is not positive; NumericalError where the iteration does not settle
double lowest_frequency_hz(const mesh::SurfaceMesh& surface, const solid::Material& material,
                           const PolynomialModeOptions& options = {});

}  // namespace klang::modal
