#include "core/geometry/mesh/detail/narrow_facets.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace klang::mesh::detail {
namespace {

constexpr double kBend_rad = 2e-3;  // TetGen joins faces that bend by less than about a tenth of a degree

std::uint64_t edge_key(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  return static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high);
}

}  // namespace

double elements_along_narrow_facets(const SurfaceMesh& surface) {
  const Eigen::Index n = surface.triangles.rows();
  const auto corner = [&](Eigen::Index t, int c) {
    return Eigen::Vector3d(surface.vertices_m.row(surface.triangles(t, c)).transpose());
  };
  std::unordered_map<std::uint64_t, std::pair<Eigen::Index, bool>> edges;  // first triangle; whether the surface bends
  std::vector<Eigen::Vector3d> normals(static_cast<std::size_t>(n));
  for (Eigen::Index t = 0; t < n; ++t) {
    Eigen::Vector3d& normal = normals[static_cast<std::size_t>(t)];
    normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
    for (int c = 0; c < 3; ++c) {
      const auto [edge, is_new] =
          edges.try_emplace(edge_key(surface.triangles(t, c), surface.triangles(t, (c + 1) % 3)), t, false);
      if (!is_new)
        edge->second.second = !((normal - normals[static_cast<std::size_t>(edge->second.first)]).norm() <= kBend_rad);
    }
  }
  double n_elements = 0.0;
  for (Eigen::Index t = 0; t < n; ++t) {
    int longest = 0;
    double length = 0.0;
    for (int c = 0; c < 3; ++c)
      if (const double l = (corner(t, (c + 1) % 3) - corner(t, c)).norm(); l > length) longest = c, length = l;
    // In a strip cut along its diagonals the side beside it bends, not the diagonal.
    bool bends = false;
    for (int c = 0; c < 3; ++c)
      bends = bends || ((corner(t, (c + 1) % 3) - corner(t, c)).norm() > 0.5 * length &&
                        edges.at(edge_key(surface.triangles(t, c), surface.triangles(t, (c + 1) % 3))).second);
    const double height = (corner(t, (longest + 1) % 3) - corner(t, longest))
                              .cross(corner(t, (longest + 2) % 3) - corner(t, longest))
                              .norm() /
                          length;
    if (bends && height > 0.0) n_elements += length / height;
  }
  return n_elements;
}

}  // namespace klang::mesh::detail
