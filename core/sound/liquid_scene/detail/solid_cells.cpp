#include "core/sound/liquid_scene/detail/solid_cells.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace klang::liquid_scene::detail {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Lines along z beside the centres, by parts of a cell: the surface's corners lie on those between centres.
constexpr double kAside_x = 0.0137, kAside_y = 0.0071;

double across(const Vector3d& a, const Vector3d& b, double x, double y) {
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

}  // namespace

std::vector<std::uint8_t> solid_cells(const liquid::LiquidSurface& surface, const Vector3d& low_m, double cell_m,
                                      const std::array<int, 3>& n) {
  const auto nx = static_cast<std::size_t>(n[0]), ny = static_cast<std::size_t>(n[1]),
             nz = static_cast<std::size_t>(n[2]);
  // Heights at which a line along z goes through the surface of the liquid, and of the liquid with its solids.
  std::array<std::vector<std::vector<float>>, 2> crossed;
  crossed.fill(std::vector<std::vector<float>>(nx * ny));
  for (Index t = 0; t < surface.surface.triangles.rows(); ++t) {
    const int region = surface.region[static_cast<std::size_t>(t)];
    std::array<Vector3d, 3> p;
    for (int c = 0; c < 3; ++c) {
      const Vector3d x = surface.surface.vertices_m.row(surface.surface.triangles(t, c)).transpose();
      p[static_cast<std::size_t>(c)] = (x - low_m) / cell_m - Vector3d(0.5 + kAside_x, 0.5 + kAside_y, 0.5);
    }
    const double all = across(p[0], p[1], p[2].x(), p[2].y());
    if (all == 0.0) continue;
    std::array<int, 2> low{}, high{};
    for (Index a = 0; a < 2; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      low[axis] = std::max(0, static_cast<int>(std::ceil(std::min({p[0][a], p[1][a], p[2][a]}))));
      high[axis] = std::min(n[axis] - 1, static_cast<int>(std::floor(std::max({p[0][a], p[1][a], p[2][a]}))));
    }
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i) {
        const double u = across(p[1], p[2], i, j) / all, v = across(p[2], p[0], i, j) / all, w = 1.0 - u - v;
        if (!(u >= 0.0 && v >= 0.0 && w >= 0.0)) continue;
        const std::size_t line = static_cast<std::size_t>(i) + nx * static_cast<std::size_t>(j);
        const auto z = static_cast<float>(u * p[0].z() + v * p[1].z() + w * p[2].z());
        if (region != 3) crossed[0][line].push_back(z);
        if (region != 2) crossed[1][line].push_back(z);
      }
  }
  std::vector<std::uint8_t> solid(nx * ny * nz, 0);
  for (std::size_t line = 0; line < nx * ny; ++line) {
    std::array<std::size_t, 2> below{};
    for (auto& heights : crossed) std::sort(heights[line].begin(), heights[line].end());
    for (std::size_t k = 0; k < nz; ++k) {
      for (std::size_t which = 0; which < 2; ++which)
        while (below[which] < crossed[which][line].size() && crossed[which][line][below[which]] < static_cast<float>(k))
          ++below[which];
      if (below[0] % 2 == 0 && below[1] % 2 == 1) solid[line + nx * ny * k] = 1;
    }
  }
  return solid;
}

}  // namespace klang::liquid_scene::detail
