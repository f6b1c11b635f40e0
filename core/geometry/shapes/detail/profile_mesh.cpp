#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/detail/revolution.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;
using Edge = std::array<int, 2>;

double twice_area(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

Edge sorted_edge(int a, int b) { return a < b ? Edge{a, b} : Edge{b, a}; }

struct Sides {
  int first = -1, second = -1;  ///< triangles; second -1 on the boundary
};
using EdgeMap = std::map<Edge, Sides>;

EdgeMap edges_of(const FlatMesh& mesh) {
  EdgeMap edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      Sides& sides = edges[sorted_edge(mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3])];
      (sides.first < 0 ? sides.first : sides.second) = static_cast<int>(t);
    }
  return edges;
}

int opposite(const std::array<int, 3>& triangle, const Edge& edge) {
  for (const int corner : triangle)
    if (corner != edge[0] && corner != edge[1]) return corner;
  return -1;
}

double angle_at(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  return std::atan2(std::abs(twice_area(p, a, b)), (a - p).dot(b - p));
}

/// Cuts off the ear with the largest smallest angle until a triangle is left.
/// Whether a point lies inside a straight side.
bool is_within_a_side(const Profile& profile, std::size_t i) {
  const std::size_t n = profile.points_m.size();
  const Vector2d& before = profile.points_m[(i + n - 1) % n];
  const Vector2d& at = profile.points_m[i];
  const Vector2d& after = profile.points_m[(i + 1) % n];
  return !(std::abs(twice_area(before, at, after)) > 1e-7 * (at - before).norm() * (after - at).norm());
}

/// Points of a zone inside a straight side become nodes, since a wall that changes makes a kink there: each halves the triangle at its side.
void add_zone_points(const Profile& profile, FlatMesh& mesh) {
  const auto node_at = [&](const Vector2d& x) {
    return static_cast<int>(std::find(mesh.points_m.begin(), mesh.points_m.end(), x) - mesh.points_m.begin());
  };
  const std::size_t n = profile.points_m.size();
  const auto is_node = [&](std::size_t i) { return !is_within_a_side(profile, i) || profile.zones[i] != 0; };
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_within_a_side(profile, i) || profile.zones[i] == 0) continue;
    std::size_t before = (i + n - 1) % n, after = (i + 1) % n;  // points of the side before are nodes by now
    while (!is_node(before) || node_at(profile.points_m[before]) == static_cast<int>(mesh.points_m.size()))
      before = (before + n - 1) % n;
    while (is_within_a_side(profile, after)) after = (after + 1) % n;
    const int a = node_at(profile.points_m[before]), b = node_at(profile.points_m[after]);
    const int added = static_cast<int>(mesh.points_m.size());
    mesh.points_m.push_back(profile.points_m[i]);
    for (std::size_t t = 0, n_triangles = mesh.triangles.size(); t < n_triangles; ++t) {
      auto& corners = mesh.triangles[t];
      for (std::size_t k = 0; k < 3; ++k) {
        if (corners[k] != a || corners[(k + 1) % 3] != b) continue;
        const int opposite = corners[(k + 2) % 3];
        corners = {a, added, opposite};
        mesh.triangles.push_back({added, b, opposite});
        t = n_triangles;
        break;
      }
    }
  }
}

FlatMesh clip_ears(const Profile& profile, const std::string& name) {
  FlatMesh mesh;
  for (std::size_t i = 0; i < profile.points_m.size(); ++i)  // points inside a straight side would make flat ears
    if (!is_within_a_side(profile, i)) mesh.points_m.push_back(profile.points_m[i]);
  const std::vector<Vector2d>& p = mesh.points_m;
  std::vector<int> ring(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) ring[i] = static_cast<int>(i);

  const auto quality = [&](std::size_t at) {
    const int m = static_cast<int>(ring.size());
    const Vector2d& a = p[ring[(at + m - 1) % m]];
    const Vector2d& b = p[ring[at]];
    const Vector2d& c = p[ring[(at + 1) % m]];
    if (!(twice_area(a, b, c) > 0.0)) return -1.0;
    for (int k = 0; k < m; ++k) {
      const Vector2d& q = p[ring[k]];
      if (&q == &a || &q == &b || &q == &c) continue;
      if (twice_area(a, b, q) >= 0.0 && twice_area(b, c, q) >= 0.0 && twice_area(c, a, q) >= 0.0) return -1.0;
    }
    return std::min({angle_at(a, b, c), angle_at(b, a, c), angle_at(c, a, b)});
  };
  std::vector<double> qualities(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) qualities[i] = quality(i);
  while (ring.size() > 3) {
    const std::size_t m = ring.size();
    const std::size_t best = std::max_element(qualities.begin(), qualities.end()) - qualities.begin();
    if (!(qualities[best] > 0.0)) throw InputError(name, "profile cannot be triangulated", "", "a simple polygon");
    mesh.triangles.push_back({ring[(best + m - 1) % m], ring[best], ring[(best + 1) % m]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(best));
    qualities.erase(qualities.begin() + static_cast<std::ptrdiff_t>(best));
    // Only the two neighbours change, and ears that were blocked by the point that left.
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (i + 1 == best || i == best || qualities[i] < 0.0 || i == 0 || i + 1 == ring.size()) qualities[i] = quality(i);
  }
  mesh.triangles.push_back({ring[0], ring[1], ring[2]});
  return mesh;
}

/// Lawson flips: an inner edge whose two opposite angles sum to more than 180 degrees is turned.
void flip_to_delaunay(FlatMesh& mesh) {
  for (int pass = 0; pass < 200; ++pass) {
    bool flipped = false;
    std::vector<char> touched(mesh.triangles.size(), 0);
    for (const auto& [edge, sides] : edges_of(mesh)) {
      if (sides.second < 0 || touched[sides.first] || touched[sides.second]) continue;
      int a = edge[0], b = edge[1];
      int c = opposite(mesh.triangles[sides.first], edge);
      int d = opposite(mesh.triangles[sides.second], edge);
      const auto& p = mesh.points_m;
      if (!(angle_at(p[c], p[a], p[b]) + angle_at(p[d], p[a], p[b]) > kPi + 1e-9)) continue;
      if (twice_area(p[a], p[b], p[c]) < 0.0) std::swap(a, b);  // now a, d, b, c run counter-clockwise
      const double scale = 1e-9 * (p[a] - p[b]).squaredNorm();
      if (!(twice_area(p[a], p[d], p[c]) > scale && twice_area(p[d], p[b], p[c]) > scale)) continue;
      mesh.triangles[sides.first] = {a, d, c};
      mesh.triangles[sides.second] = {d, b, c};
      touched[sides.first] = touched[sides.second] = 1;
      flipped = true;
    }
    if (!flipped) return;
  }
}

/// Halves every edge longer than edge_m that has no neighbour halved in the same pass, longest first.
bool split_long_edges(FlatMesh& mesh, double edge_m) {
  const EdgeMap edges = edges_of(mesh);
  struct Long {
    double length_m;
    Edge edge;
    Sides sides;
  };
  std::vector<Long> candidates;
  for (const auto& [edge, sides] : edges) {
    const double length = (mesh.points_m[edge[0]] - mesh.points_m[edge[1]]).norm();
    if (length > (sides.second < 0 ? 1.0001 : 1.4) * edge_m) candidates.push_back({length, edge, sides});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Long& a, const Long& b) { return a.length_m > b.length_m; });
  std::vector<char> touched(mesh.triangles.size(), 0);
  for (const Long& item : candidates) {
    if (touched[item.sides.first] || (item.sides.second >= 0 && touched[item.sides.second])) continue;
    const int mid = static_cast<int>(mesh.points_m.size());
    mesh.points_m.push_back(0.5 * (mesh.points_m[item.edge[0]] + mesh.points_m[item.edge[1]]));
    for (const int t : {item.sides.first, item.sides.second}) {
      if (t < 0) continue;
      touched[t] = 1;
      const std::array<int, 3> old = mesh.triangles[t];
      std::array<int, 3> one = old, two = old;
      for (int c = 0; c < 3; ++c) {
        if (old[c] == item.edge[0]) one[c] = mid;
        if (old[c] == item.edge[1]) two[c] = mid;
      }
      mesh.triangles[t] = one;
      mesh.triangles.push_back(two);
    }
  }
  return !candidates.empty();
}

/// Moves inner points to the mean of their neighbours where no triangle turns over.
void smooth(FlatMesh& mesh) {
  std::vector<char> fixed(mesh.points_m.size(), 0);
  std::vector<Vector2d> sum(mesh.points_m.size(), Vector2d::Zero());
  std::vector<int> n_neighbours(mesh.points_m.size(), 0);
  for (const auto& [edge, sides] : edges_of(mesh)) {
    for (int i = 0; i < 2; ++i) {
      if (sides.second < 0) fixed[edge[i]] = 1;
      sum[edge[i]] += mesh.points_m[edge[1 - i]];
      ++n_neighbours[edge[i]];
    }
  }
  std::vector<std::vector<int>> around(mesh.points_m.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int corner : mesh.triangles[t]) around[corner].push_back(static_cast<int>(t));
  for (std::size_t i = 0; i < mesh.points_m.size(); ++i) {
    if (fixed[i]) continue;
    const Vector2d before = mesh.points_m[i];
    const auto smallest = [&] {
      double area = HUGE_VAL;
      for (const int t : around[i])
        area = std::min(area, twice_area(mesh.points_m[mesh.triangles[t][0]], mesh.points_m[mesh.triangles[t][1]],
                                         mesh.points_m[mesh.triangles[t][2]]));
      return area;
    };
    const double area_before = smallest();
    mesh.points_m[i] = sum[i] / n_neighbours[i];
    if (!(smallest() > 0.5 * area_before)) mesh.points_m[i] = before;
  }
}

}  // namespace

FlatMesh mesh_profile(const Profile& profile, double edge_m) {
  FlatMesh mesh = clip_ears(profile, profile.name);
  add_zone_points(profile, mesh);
  flip_to_delaunay(mesh);
  while (split_long_edges(mesh, edge_m)) {
    check_element_count(18.0 * static_cast<double>(mesh.triangles.size()));
    flip_to_delaunay(mesh);
  }
  for (int pass = 0; pass < 6; ++pass) {
    smooth(mesh);
    flip_to_delaunay(mesh);
  }
  return mesh;
}

FlatMesh refined(const FlatMesh& mesh) {
  FlatMesh fine;
  fine.points_m = mesh.points_m;
  std::map<Edge, int> mids;
  const auto mid = [&](int a, int b) {
    const auto [it, added] = mids.try_emplace(sorted_edge(a, b), static_cast<int>(fine.points_m.size()));
    if (added) fine.points_m.push_back(0.5 * (mesh.points_m[a] + mesh.points_m[b]));
    return it->second;
  };
  for (const auto& t : mesh.triangles) {
    const int ab = mid(t[0], t[1]), bc = mid(t[1], t[2]), ca = mid(t[2], t[0]);
    fine.triangles.insert(fine.triangles.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace klang::mesh::detail
