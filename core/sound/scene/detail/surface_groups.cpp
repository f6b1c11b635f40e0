#include "core/sound/scene/detail/surface_groups.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/errors.hpp"

namespace klang::scene::detail {
namespace {

constexpr std::size_t kMostTriangles = 32;
constexpr double kRoundOff = 1e-12;  ///< of what is compared

}  // namespace

SurfaceGroups::SurfaceGroups(const mesh::SurfaceMesh& surface) {
  const auto corner = [&](Eigen::Index t, int c) -> Eigen::Vector3d {
    return surface.vertices_m.row(surface.triangles(t, c)).transpose();
  };
  std::vector<Eigen::Vector3d> middle;
  std::vector<std::vector<Eigen::Index>> open(1);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    middle.emplace_back((corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0);
    open[0].push_back(t);
  }
  while (!open.empty()) {
    std::vector<Eigen::Index> triangles = std::move(open.back());
    open.pop_back();
    Eigen::AlignedBox3d box;
    for (const Eigen::Index t : triangles) box.extend(middle[static_cast<std::size_t>(t)]);
    if (triangles.size() > kMostTriangles) {
      Eigen::Index axis = 0;
      box.sizes().maxCoeff(&axis);
      const auto half = triangles.begin() + static_cast<std::ptrdiff_t>(triangles.size() / 2);
      std::nth_element(triangles.begin(), half, triangles.end(), [&](Eigen::Index i, Eigen::Index j) {
        const double x = middle[static_cast<std::size_t>(i)][axis], y = middle[static_cast<std::size_t>(j)][axis];
        return x < y || (x == y && i < j);
      });
      open.emplace_back(triangles.begin(), half);
      open.emplace_back(half, triangles.end());
      continue;
    }
    if (triangles.empty()) continue;
    std::sort(triangles.begin(), triangles.end());
    Group group;
    std::map<int, int> number;
    group.part.triangles = surface.triangles(triangles, Eigen::all);
    for (auto& vertex : group.part.triangles.reshaped()) {
      const auto found = number.try_emplace(vertex, static_cast<int>(group.vertices.size()));
      if (found.second) group.vertices.push_back(vertex);
      vertex = found.first->second;
    }
    group.part.vertices_m = surface.vertices_m(group.vertices, Eigen::all);
    group.centre_m = box.center();
    for (const Eigen::Index t : triangles)
      for (int c = 0; c < 3; ++c) group.reach_m = std::max(group.reach_m, (corner(t, c) - group.centre_m).norm());
    group.triangles = std::move(triangles);
    groups_.push_back(std::move(group));
  }
  std::sort(groups_.begin(), groups_.end(),
            [](const Group& a, const Group& b) { return a.triangles.front() < b.triangles.front(); });
}

mesh::SurfacePoint SurfaceGroups::nearest(const Eigen::Vector3d& point_m) const {
  if (groups_.empty()) throw InputError("surface point", "the surface has no triangles");
  // The group whose far side is nearest has a point at most there.
  double most_m = HUGE_VAL;
  for (const Group& group : groups_) most_m = std::min(most_m, (group.centre_m - point_m).norm() + group.reach_m);
  mesh::SurfacePoint found;
  found.distance_m = HUGE_VAL;
  const Group* of = nullptr;
  for (const Group& group : groups_) {
    const double least_m = (group.centre_m - point_m).norm() - group.reach_m;
    if (!(least_m <= std::min(most_m, found.distance_m) + kRoundOff * group.reach_m)) continue;
    mesh::SurfacePoint here = mesh::nearest_surface_point(group.part, point_m);
    if (!(here.distance_m < found.distance_m)) continue;
    found = std::move(here);
    of = &group;
  }
  if (of == nullptr) throw InputError("surface point", "is not finite");
  for (int& node : found.nodes) node = of->vertices[static_cast<std::size_t>(node)];
  return found;
}

std::vector<Eigen::Index> SurfaceGroups::near(const Eigen::Vector3d& point_m, double distance_m) const {
  std::vector<Eigen::Index> found;
  for (const Group& group : groups_)
    if ((group.centre_m - point_m).norm() <= distance_m + group.reach_m)
      found.insert(found.end(), group.triangles.begin(), group.triangles.end());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace klang::scene::detail
