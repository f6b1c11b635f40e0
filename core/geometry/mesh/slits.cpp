#include "core/geometry/mesh/slits.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace klang::mesh {

ShutSlits shut_slits(const SurfaceMesh& surface) {
  ShutSlits result;
  std::map<std::array<double, 3>, int> first;
  std::vector<int> place(static_cast<std::size_t>(surface.vertices_m.rows()));
  for (Eigen::Index v = 0; v < surface.vertices_m.rows(); ++v) {
    const auto row = surface.vertices_m.row(v);
    place[static_cast<std::size_t>(v)] = first.try_emplace({row[0], row[1], row[2]}, static_cast<int>(v)).first->second;
  }
  // A turn of its corners that starts with the lowest names a triangle and the way it faces.
  std::map<std::array<int, 3>, std::vector<Eigen::Index>> facing;
  const auto name_of = [&](Eigen::Index t, bool from_behind) {
    std::array<int, 3> name;
    for (int c = 0; c < 3; ++c)
      name[static_cast<std::size_t>(from_behind ? 2 - c : c)] =
          place[static_cast<std::size_t>(surface.triangles(t, c))];
    std::rotate(name.begin(), std::min_element(name.begin(), name.end()), name.end());
    return name;
  };
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) facing[name_of(t, false)].push_back(t);
  std::vector<char> shut(static_cast<std::size_t>(surface.triangles.rows()), 0);
  for (const auto& [name, triangles] : facing) {
    const auto other = facing.find(name_of(triangles.front(), true));
    if (other == facing.end()) continue;
    for (std::size_t i = 0; i < std::min(triangles.size(), other->second.size()); ++i)
      shut[static_cast<std::size_t>(triangles[i])] = 1;
  }
  for (std::size_t t = 0; t < shut.size(); ++t)
    if (shut[t] == 0) result.kept.push_back(static_cast<Eigen::Index>(t));
  result.any = result.kept.size() < shut.size();
  if (!result.any) std::iota(place.begin(), place.end(), 0);
  result.vertex_of = std::move(place);
  return result;
}

}  // namespace klang::mesh
