#include "core/physics/rigid/convex_parts.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <queue>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/physics/rigid/detail/convex_hull.hpp"

namespace klang::rigid {
namespace {

struct Region {
  std::set<int> corners, neighbours;
  double volume_m3 = 0.0;
  int version = 0;
  bool is_there = true;
};

struct Join {
  double bulge;
  int a, b, version_a, version_b;
  bool operator<(const Join& other) const {  // the queue gives the largest first
    return std::tie(other.bulge, other.a, other.b) < std::tie(bulge, a, b);
  }
};

Eigen::Matrix3Xd places(const mesh::TetMesh& mesh, const std::set<int>& corners) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(corners.size()));
  Eigen::Index i = 0;
  for (const int corner : corners) columns.col(i++) = mesh.nodes_m.row(corner).transpose();
  return columns;
}

double hull_volume_m3(const Eigen::Matrix3Xd& corners_m) {
  return mesh::mass_properties(detail::convex_hull(corners_m)).volume_m3;
}

/// The corners that the hull needs.
ConvexPart part_of(const Eigen::Matrix3Xd& corners_m) {
  return {detail::convex_hull(corners_m).vertices_m.transpose()};
}

std::vector<Region> tetrahedra(const mesh::TetMesh& mesh) {
  std::vector<Region> regions(static_cast<std::size_t>(mesh.n_elements()));
  std::map<std::array<int, 3>, int> faces;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    Region& region = regions[static_cast<std::size_t>(e)];
    for (int c = 0; c < 4; ++c) region.corners.insert(mesh.elements(e, c));
    const auto corner = [&](int c) -> Eigen::Vector3d { return mesh.nodes_m.row(mesh.elements(e, c)).transpose(); };
    const Eigen::Vector3d origin = corner(0);
    region.volume_m3 = (corner(1) - origin).cross(corner(2) - origin).dot(corner(3) - origin) / 6.0;
    for (const auto& face : mesh::kTetFaces) {
      std::array<int, 3> key{mesh.elements(e, face[0]), mesh.elements(e, face[1]), mesh.elements(e, face[2])};
      std::sort(key.begin(), key.end());
      const auto [other, is_first] = faces.try_emplace(key, e);
      if (is_first) continue;
      region.neighbours.insert(other->second);
      regions[static_cast<std::size_t>(other->second)].neighbours.insert(e);
    }
  }
  return regions;
}

class Joiner {
 public:
  Joiner(const mesh::TetMesh& mesh, double bulge) : mesh_(mesh), bulge_(bulge), regions_(tetrahedra(mesh)) {
    for (int a = 0; a < static_cast<int>(regions_.size()); ++a)
      for (const int b : region(a).neighbours)
        if (a < b) offer(a, b);
  }

  std::vector<Region> joined() {
    while (!queue_.empty()) {
      const Join best = queue_.top();
      queue_.pop();
      if (!region(best.a).is_there || !region(best.b).is_there || region(best.a).version != best.version_a ||
          region(best.b).version != best.version_b)
        continue;
      join(best.a, best.b);
    }
    std::erase_if(regions_, [](const Region& region) { return !region.is_there; });
    return std::move(regions_);
  }

 private:
  Region& region(int i) { return regions_[static_cast<std::size_t>(i)]; }

  void offer(int a, int b) {
    std::set<int> corners = region(a).corners;
    corners.insert(region(b).corners.begin(), region(b).corners.end());
    const double filled = region(a).volume_m3 + region(b).volume_m3;
    const double bulge = hull_volume_m3(places(mesh_, corners)) / filled - 1.0;
    if (bulge <= bulge_) queue_.push({bulge, a, b, region(a).version, region(b).version});
  }

  void join(int a, int b) {
    Region& kept = region(a);
    Region& gone = region(b);
    kept.corners.insert(gone.corners.begin(), gone.corners.end());
    kept.volume_m3 += gone.volume_m3;
    ++kept.version;
    gone.is_there = false;
    for (const int other : gone.neighbours) {
      region(other).neighbours.erase(b);
      if (other == a) continue;
      region(other).neighbours.insert(a);
      kept.neighbours.insert(other);
    }
    kept.neighbours.erase(b);
    const std::set<int> neighbours = kept.neighbours;
    for (const int other : neighbours) offer(std::min(a, other), std::max(a, other));
  }

  const mesh::TetMesh& mesh_;
  double bulge_;
  std::vector<Region> regions_;
  std::priority_queue<Join> queue_;
};

}  // namespace

std::vector<ConvexPart> convex_parts_of(const mesh::TetMesh& mesh, const std::string& name,
                                        const ConvexPartsOptions& options) {
  std::set<int> all;
  double volume_m3 = 0.0;
  for (const Region& tetrahedron : tetrahedra(mesh)) {
    all.insert(tetrahedron.corners.begin(), tetrahedron.corners.end());
    volume_m3 += tetrahedron.volume_m3;
  }
  const Eigen::Matrix3Xd corners_m = places(mesh, all);
  if (hull_volume_m3(corners_m) <= (1.0 + options.bulge) * volume_m3) return {part_of(corners_m)};
  std::vector<ConvexPart> parts;
  for (const Region& region : Joiner(mesh, options.bulge).joined())
    parts.push_back(part_of(places(mesh, region.corners)));
  if (static_cast<int>(parts.size()) > options.most_parts)
    throw InputError(name, "falls into too many convex parts", std::to_string(parts.size()),
                     std::to_string(options.most_parts) + "; a coarser surface has fewer");
  return parts;
}

mesh::SurfaceMesh hull_of(const ConvexPart& part) { return detail::convex_hull(part.corners_m); }

}  // namespace klang::rigid
