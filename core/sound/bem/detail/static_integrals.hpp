#pragma once
#include <Eigen/Core>
#include <array>

namespace klang::acoustics::detail {

/// A flat triangle as the closed forms need it.
struct FlatTriangle {
  std::array<Eigen::Vector3d, 3> corners;
  double twice_area;
  Eigen::Vector3d normal;                        ///< unit, right-handed with the corners
  std::array<Eigen::Vector3d, 3> edge, outward;  ///< unit along corner c -> c + 1; in the plane, out of the triangle
  std::array<Eigen::Vector3d, 3> gradient;       ///< of the hat function of each corner [1/m]
  FlatTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
};

/// Integrals over the triangle with phi_b the hat function of corner b, R = |x - y|, by closed forms:
///   single[b] = int phi_b / R,  twice[b] = int phi_b n_y.(x - y) / R^3  (= d/dn_y of single),
///   gradient.col(b) = grad_x int phi_b / R.
/// Exact for x anywhere but on an edge's line segment; in the plane of the triangle twice is the principal value 0
/// and gradient has the tangential part only (the mean of both sides). No 1/(4 pi).
/// Source: Wilton et al. 1984 (IEEE TAP 32, 276-281) for the potentials; gradients by parts on the edges.
struct StaticIntegrals {
  Eigen::Vector3d single;
  Eigen::Vector3d twice;
  Eigen::Matrix3d gradient;
};
StaticIntegrals static_integrals(const FlatTriangle& triangle, const Eigen::Vector3d& x, bool with_gradient);

}  // namespace klang::acoustics::detail
