#pragma once
#include <array>
#include <span>
#include <vector>

namespace klang {

/// A quadrature point of a triangle: barycentric coordinates; weights add up to 1.
struct TrianglePoint {
  std::array<double, 3> at;
  double weight;
};

/// Exact to degree 2 (3 points) and degree 5 (7 points; Radon 1948), all inside.
std::span<const TrianglePoint> three_points();
std::span<const TrianglePoint> seven_points();

/// 90 points for an integrand with logarithms along the edges and at the corners: the triangle is cut at its centre into
/// three, each with the Gauss points of a square collapsed into the centre and squeezed towards the edge by 1 - u = s^2.
std::span<const TrianglePoint> boundary_points();

}  // namespace klang
