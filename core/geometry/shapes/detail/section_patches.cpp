#include "core/geometry/shapes/detail/section_patches.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/detail/revolution.hpp"

namespace klang::mesh::detail {

using Eigen::Vector2d;

int section_divided(double length_m, double edge_m, int at_least) {
  const double count = std::ceil(length_m / edge_m - 1e-9);
  check_element_count(count * count);
  return std::max(at_least, static_cast<int>(count));
}

int section_layers(double thick_m, double length_m, double edge_m) {
  int n = 0;
  while (n < 20 && std::ldexp(thick_m, n) < edge_m && std::ldexp(thick_m, n + 1) < 0.25 * length_m) ++n;
  return n;
}

std::vector<double> layered_borders(double length_m, double thick_m, int n, int layers_low, int layers_high) {
  const auto total = [&](int layers) { return thick_m * (std::ldexp(1.0, layers) - 1.0); };
  // However the dimensions change, the layers leave half of the length to the even cells.
  const double scale = std::min(1.0, 0.5 * length_m / std::max(total(layers_low) + total(layers_high), 1e-300));
  std::vector<double> border = {0.0};
  for (int k = 0; k < layers_low; ++k) border.push_back(border.back() + scale * std::ldexp(thick_m, k));
  const double from = border.back(), to = length_m - scale * total(layers_high);
  for (int i = 1; i <= n; ++i) border.push_back(from + (to - from) * i / n);
  for (int k = layers_high - 1; k >= 0; --k) border.push_back(border.back() + scale * std::ldexp(thick_m, k));
  border.back() = length_m;
  return border;
}

double along(const std::vector<double>& border, double s) {
  const auto n = static_cast<double>(border.size() - 1);
  const double cell = std::clamp(std::floor(s * n + 1e-9), 0.0, n - 1.0), t = s * n - cell;
  const auto i = static_cast<std::size_t>(cell);
  return border[i] + t * (border[i + 1] - border[i]);
}

std::vector<SectionPatch> straight_section(double length_m, double inner_m, double outer_m,
                                           const std::array<int, 3>& n) {
  const auto border = layered_borders(length_m, outer_m - inner_m, n[0], n[2], n[2]);
  return {{n[1], n[0] + 2 * n[2], [=](double u, double v) -> Vector2d {
             return {inner_m + u * (outer_m - inner_m), along(border, v) - 0.5 * length_m};
           }}};
}

std::vector<SectionPatch> half_disk(int n, const std::function<Vector2d(const Vector2d&)>& place) {
  constexpr double h = 0.45;  // half the inner square's side
  std::vector<SectionPatch> patches;
  const auto inner = [=](double u, double v) { return place({h * u, h * (2.0 * v - 1.0)}); };
  patches.push_back({n, 2 * n, inner});
  // A straight line from the square's side to the circle, sides being split evenly in angle on the circle.
  const auto outer = [=](Vector2d a, Vector2d b, double angle_a, double angle_b) {
    return [=](double u, double v) {
      const double angle = angle_a + (angle_b - angle_a) * v;
      const Vector2d circle(std::cos(angle), std::sin(angle));
      return place((1.0 - u) * (a + v * (b - a)) + u * circle);
    };
  };
  patches.push_back({n, n, outer({0.0, -h}, {h, -h}, -0.5 * kPi, -0.25 * kPi)});
  patches.push_back({n, 2 * n, outer({h, -h}, {h, h}, -0.25 * kPi, 0.25 * kPi)});
  patches.push_back({n, n, outer({h, h}, {0.0, h}, 0.25 * kPi, 0.5 * kPi)});
  return patches;
}

std::vector<SectionPatch> profile_patches(const Profile& profile, double edge_m) {
  const FlatMesh flat = mesh_profile(profile, edge_m);
  std::vector<SectionPatch> patches;
  for (const auto& triangle : flat.triangles) {
    std::array<Vector2d, 3> p;
    for (int c = 0; c < 3; ++c) p[c] = flat.points_m[static_cast<std::size_t>(triangle[c])];
    const Vector2d middle = (p[0] + p[1] + p[2]) / 3.0;
    for (int c = 0; c < 3; ++c) {
      const Vector2d a = p[c], b = 0.5 * (p[c] + p[(c + 1) % 3]), d = 0.5 * (p[c] + p[(c + 2) % 3]);
      patches.push_back({1, 1, [=](double u, double v) -> Vector2d {
                           return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * middle + (1 - u) * v * d;
                         }});
    }
  }
  return patches;
}

}  // namespace klang::mesh::detail
