#include "core/geometry/mesh/hanging_nodes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector3d;
using Face = std::array<int, 3>;

constexpr double kSlack = 1e-7;     ///< of the longest edge: nearer is on it
constexpr double kInterior = 1e-6;  ///< barycentric: nearer to an end is at the end

std::vector<Face> surface_of(const TetMesh& mesh) {
  std::map<Face, std::pair<int, Face>> faces;
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (const auto& face : kTetFaces) {
      const Face nodes = {mesh.elements(e, face[0]), mesh.elements(e, face[1]), mesh.elements(e, face[2])};
      Face key = nodes;
      std::sort(key.begin(), key.end());
      auto& entry = faces[key];
      ++entry.first;
      entry.second = nodes;
    }
  std::vector<Face> surface;
  for (const auto& [key, entry] : faces) {
    if (entry.first > 2)
      throw InputError("mesh", "has a face that more than two elements share", std::to_string(key[0]));
    if (entry.first == 1) surface.push_back(entry.second);
  }
  return surface;
}

[[noreturn]] void refuse(int node, const std::string& where) {
  throw InputError("mesh", "has a hanging node", std::to_string(node), "a conforming mesh: it lies on " + where);
}

void look_at(const Face& face, const std::array<Vector3d, 3>& x, int node, const Vector3d& p) {
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d along = x[(k + 1) % 3] - x[k];
    const double length = along.norm(), s = (p - x[k]).dot(along) / (length * length);
    longest = std::max(longest, length);
    if (s > kInterior && s < 1.0 - kInterior && (x[k] + s * along - p).norm() <= kSlack * length)
      refuse(node, "the edge of nodes " + std::to_string(std::min(face[k], face[(k + 1) % 3])) + " and " +
                       std::to_string(std::max(face[k], face[(k + 1) % 3])));
  }
  const Vector3d across = (x[1] - x[0]).cross(x[2] - x[0]);
  const double twice = across.norm();
  if (!(twice > 0.0) || !(std::abs((p - x[0]).dot(across)) <= kSlack * longest * twice)) return;
  for (std::size_t k = 0; k < 3; ++k)
    if (!((x[(k + 1) % 3] - p).cross(x[(k + 2) % 3] - p).dot(across) > kInterior * twice * twice)) return;
  refuse(node, "the face of nodes " + std::to_string(face[0]) + ", " + std::to_string(face[1]) + " and " +
                   std::to_string(face[2]));
}

}  // namespace

void refuse_hanging_nodes(const TetMesh& mesh) {
  const std::vector<Face> surface = surface_of(mesh);
  const auto place = [&](int node) -> Vector3d { return mesh.nodes_m.row(node).transpose(); };
  std::vector<std::pair<double, int>> along;  // nodes of the surface by x
  for (const Face& face : surface)
    for (const int node : face) along.emplace_back(mesh.nodes_m(node, 0), node);
  std::sort(along.begin(), along.end());
  along.erase(std::unique(along.begin(), along.end()), along.end());
  for (const Face& face : surface) {
    const std::array<Vector3d, 3> x = {place(face[0]), place(face[1]), place(face[2])};
    const Vector3d low = x[0].cwiseMin(x[1]).cwiseMin(x[2]), high = x[0].cwiseMax(x[1]).cwiseMax(x[2]);
    const double slack = kSlack * (high - low).norm();
    auto next = std::lower_bound(along.begin(), along.end(), std::pair{low.x() - slack, -1});
    for (; next != along.end() && next->first <= high.x() + slack; ++next) {
      const int node = next->second;
      const Vector3d p = place(node);
      if (node == face[0] || node == face[1] || node == face[2]) continue;
      if (((p - low).array() < -slack).any() || ((p - high).array() > slack).any()) continue;
      look_at(face, x, node, p);
    }
  }
}

}  // namespace klang::mesh
