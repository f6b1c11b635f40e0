#include "core/geometry/mesh/surface_repair.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/detail/surface_edges.hpp"
#include "core/geometry/mesh/surface_check.hpp"

namespace klang::mesh {
namespace {

using detail::HalfEdge;
using Eigen::Vector3d;
using Triangle = std::array<int, 3>;

constexpr double kWeldOfSize = 1e-6;
constexpr double kLastPlaces = 4.0 * 1.1920929e-07;  // of 32-bit coordinates

/// Vertices within distance of each other are joined (chains too). @return for each vertex the first of its cluster
std::vector<int> weld_map(const Points& points, double distance) {
  const auto n = static_cast<std::size_t>(points.rows());
  // Along a direction in which grids and symmetric bodies do not line up.
  const Vector3d along = Vector3d(0.5377, 0.6243, 0.5671).normalized();
  const Eigen::VectorXd place = points * along;
  std::vector<int> order(n), root(n);
  std::iota(order.begin(), order.end(), 0);
  std::iota(root.begin(), root.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return place[a] != place[b] ? place[a] < place[b] : a < b; });
  const auto find = [&root](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  const double reach = distance + 1e-15 * (n > 0 ? points.cwiseAbs().maxCoeff() : 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 1; k < n && place[order[k]] - place[order[i]] <= reach; ++k) {
      if (!((points.row(order[i]) - points.row(order[k])).norm() <= distance)) continue;
      const int a = find(order[i]), b = find(order[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  for (std::size_t v = 0; v < n; ++v) root[v] = find(static_cast<int>(v));
  return root;
}

/// Triangles on the way to a closed surface, and what was done to them.
class Mender {
 public:
  explicit Mender(const SurfaceMesh& surface) : points_(surface.vertices_m) {
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
      triangles_.push_back({surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
    size_ =
        surface.vertices_m.rows() > 0 ? (points_.colwise().maxCoeff() - points_.colwise().minCoeff()).maxCoeff() : 0.0;
  }

  void weld(double distance) {
    const std::vector<int> root = weld_map(points_, distance);
    for (std::size_t v = 0; v < root.size(); ++v) {
      if (root[v] == static_cast<int>(v)) continue;
      ++repairs_.n_welded_vertices;
      repairs_.weld_distance_m =
          std::max(repairs_.weld_distance_m, (points_.row(static_cast<Eigen::Index>(v)) - points_.row(root[v])).norm());
    }
    for (Triangle& t : triangles_)
      for (int& v : t) v = root[v];
  }

  /// pairs: of two faces on the same corners both go (an inner wall, a part without inside), else one stays.
  void drop_faces(bool pairs) {
    const auto collapsed = [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; };
    repairs_.n_collapsed_faces += static_cast<int>(std::erase_if(triangles_, collapsed));
    const auto sorted = [](Triangle t) {
      std::sort(t.begin(), t.end());
      return t;
    };
    std::vector<int> order(triangles_.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      const Triangle x = sorted(triangles_[a]), y = sorted(triangles_[b]);
      return x != y ? x < y : a < b;
    });
    std::vector<bool> goes(triangles_.size(), false);
    for (std::size_t i = 0; i < order.size();) {
      std::size_t end = i + 1;
      while (end < order.size() && sorted(triangles_[order[end]]) == sorted(triangles_[order[i]])) ++end;
      const std::size_t n_kept = pairs ? (end - i) % 2 : 1;
      for (std::size_t k = i + n_kept; k < end; ++k) goes[order[k]] = true;
      i = end;
    }
    std::vector<Triangle> kept;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (!goes[t]) kept.push_back(triangles_[t]);
    repairs_.n_duplicate_faces += static_cast<int>(triangles_.size() - kept.size());
    triangles_ = std::move(kept);
  }

  /// Turns the faces that are wound against most of their part; a part with one side only stays as it is.
  void orient() {
    const auto n = static_cast<int>(triangles_.size());
    struct Neighbour {
      int triangle = -1;
      bool against = false;
    };
    std::vector<std::array<Neighbour, 3>> neighbours(triangles_.size());
    std::vector<int> n_neighbours(triangles_.size(), 0);
    const std::vector<HalfEdge> edges = detail::sorted_half_edges(rows());
    detail::for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* end) {
      if (end - first != 2) return;
      const bool against = first->forward == first[1].forward;
      neighbours[first->triangle][n_neighbours[first->triangle]++] = {first[1].triangle, against};
      neighbours[first[1].triangle][n_neighbours[first[1].triangle]++] = {first->triangle, against};
    });
    std::vector<int> turn(triangles_.size(), -1), part;
    for (int seed = 0; seed < n; ++seed) {
      if (turn[seed] >= 0) continue;
      part.assign(1, seed);
      turn[seed] = 0;
      bool has_sides = true;
      std::size_t n_turned = 0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        n_turned += static_cast<std::size_t>(turn[part[i]]);
        for (int k = 0; k < n_neighbours[part[i]]; ++k) {
          const auto [other, against] = neighbours[part[i]][k];
          const int wanted = turn[part[i]] ^ static_cast<int>(against);
          if (turn[other] < 0) {
            turn[other] = wanted;
            part.push_back(other);
          } else if (turn[other] != wanted) {
            has_sides = false;
          }
        }
      }
      const int turned = 2 * n_turned > part.size() ? 0 : 1;
      for (const int t : part) {
        if (!has_sides || turn[t] != turned) continue;
        std::swap(triangles_[t][1], triangles_[t][2]);
        ++repairs_.n_turned_faces;
      }
    }
  }

  /// Faces without height that lie on their longest edge: that edge is put the other way in the pair with the neighbour.
  void recut_flat_faces() {
    for (int pass = 0; pass < 4; ++pass) {
      int n_cut = 0;
      std::vector<bool> touched(triangles_.size(), false);
      const std::vector<HalfEdge> edges = detail::sorted_half_edges(rows());
      const auto shared = [&](int a, int b) {
        const std::pair wanted(std::min(a, b), std::max(a, b));
        const auto by_ends = [](const HalfEdge& e, const std::pair<int, int>& w) {
          return std::pair(e.low, e.high) < w;
        };
        const auto first = std::lower_bound(edges.begin(), edges.end(), wanted, by_ends);
        std::vector<int> faces;
        for (auto e = first; e != edges.end() && std::pair(e->low, e->high) == wanted; ++e)
          faces.push_back(e->triangle);
        return faces;
      };
      for (std::size_t t = 0; t < triangles_.size(); ++t) {
        if (touched[t] || !is_flat(triangles_[t])) continue;
        Triangle own = triangles_[t];
        const auto length = [&](int c) { return (point(own[(c + 1) % 3]) - point(own[c])).norm(); };
        const int longest = length(0) >= length(1) && length(0) >= length(2) ? 0 : length(1) >= length(2) ? 1 : 2;
        std::rotate(own.begin(), own.begin() + longest, own.end());  // a, b: the longest edge; c lies on it
        const std::vector<int> faces = shared(own[0], own[1]);
        if (faces.size() != 2) continue;
        const auto other = static_cast<std::size_t>(faces[0] == static_cast<int>(t) ? faces[1] : faces[0]);
        if (other == t || touched[other] || is_flat(triangles_[other])) continue;
        const auto far = std::find_if(triangles_[other].begin(), triangles_[other].end(),
                                      [&](int v) { return v != own[0] && v != own[1]; });
        if (far == triangles_[other].end() || *far == own[2] || !shared(own[2], *far).empty()) continue;
        const int d = *far;
        touched[t] = touched[other] = true;
        triangles_[t] = {own[0], d, own[2]};
        triangles_[other] = {d, own[1], own[2]};
        ++n_cut;
      }
      repairs_.n_recut_faces += n_cut;
      if (n_cut == 0) return;
    }
  }

  /// Parts that are inside out, where that can be told.
  void turn_parts() {
    const SurfaceMesh whole = surface();
    int n_parts = 0;
    const auto n = static_cast<int>(triangles_.size());
    const std::vector<int> part_of = detail::parts_over_edges(detail::sorted_half_edges(whole.triangles), n, n_parts);
    if (n_parts > kMostSurfaceParts) return;
    const std::vector<detail::PartGeometry> parts = detail::part_geometry(whole, part_of, n_parts);
    std::vector<bool> turns(parts.size(), false);
    for (int depth = 0, n_left = n_parts; n_left > 0; ++depth)
      for (std::size_t p = 0; p < parts.size(); ++p) {
        if (parts[p].depth != depth) continue;
        --n_left;
        const bool wrong = (parts[p].volume_m3 < 0.0) != (depth % 2 == 1);
        turns[p] = wrong && (depth % 2 == 0 || turns[parts[p].within]);
      }
    for (int t = 0; t < n; ++t)
      if (turns[part_of[t]]) std::swap(triangles_[t][1], triangles_[t][2]);
    repairs_.n_turned_parts += static_cast<int>(std::count(turns.begin(), turns.end(), true));
  }

  /// Edges that two faces do not share, and faces without height.
  long n_faults() const {
    long n = 0;
    detail::for_each_edge(detail::sorted_half_edges(rows()), [&n](const HalfEdge* first, const HalfEdge* end) {
      if (end - first != 2) ++n;
    });
    return n + std::count_if(triangles_.begin(), triangles_.end(), [this](const Triangle& t) { return is_flat(t); });
  }

  bool has_faces() const { return !triangles_.empty(); }
  double size() const { return size_; }
  const SurfaceRepairs& repairs() const { return repairs_; }

  SurfaceMesh surface() const {
    SurfaceMesh result;
    result.vertices_m = points_;
    result.triangles = rows();
    return result;
  }

 private:
  Vector3d point(int v) const { return points_.row(v).transpose(); }

  bool is_flat(const Triangle& t) const { return is_flat_triangle({point(t[0]), point(t[1]), point(t[2])}, size_); }

  IndexRows rows() const {
    IndexRows result(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (int c = 0; c < 3; ++c) result(static_cast<Eigen::Index>(t), c) = triangles_[t][c];
    return result;
  }

  const Points& points_;
  std::vector<Triangle> triangles_;
  double size_ = 0.0;
  SurfaceRepairs repairs_;
};

std::vector<int> used_vertices(const SurfaceMesh& surface, const std::string& name) {
  const auto n = static_cast<int>(surface.vertices_m.rows());
  std::vector<int> used(static_cast<std::size_t>(n), 0);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int v = surface.triangles(t, c);
      if (v < 0 || v >= n)
        throw InputError(name, "face " + std::to_string(t) + ": vertex out of range", std::to_string(v),
                         "0 to " + std::to_string(n - 1));
      if (!surface.vertices_m.row(v).allFinite())
        throw InputError(name, "face " + std::to_string(t) + ": vertex " + std::to_string(v) + " is not finite");
      used[static_cast<std::size_t>(v)] = 1;
    }
  return used;
}

/// Without the vertices that no face has.
SurfaceMesh compacted(const SurfaceMesh& surface, const std::string& name) {
  const std::vector<int> used = used_vertices(surface, name);
  std::vector<int> number(used.size(), -1);
  const auto n_used = std::accumulate(used.begin(), used.end(), 0);
  if (n_used == static_cast<int>(used.size())) return surface;
  SurfaceMesh result;
  result.vertices_m.resize(n_used, 3);
  int next = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    number[v] = next;
    result.vertices_m.row(next++) = surface.vertices_m.row(static_cast<Eigen::Index>(v));
  }
  result.triangles = surface.triangles.unaryExpr([&number](int v) { return number[v]; });
  return result;
}

}  // namespace

bool SurfaceRepairs::any() const {
  return n_unused_vertices + n_welded_vertices + n_collapsed_faces + n_duplicate_faces + n_recut_faces +
                 n_turned_faces + n_turned_parts >
             0 ||
         n_extra_bytes > 0;
}

std::string SurfaceRepairs::text() const {
  std::string result;
  const auto say = [&result](std::int64_t n, const char* one, const char* many) {
    if (n > 0) result += (result.empty() ? "" : ", ") + std::to_string(n) + " " + (n == 1 ? one : many);
  };
  say(n_welded_vertices, "repeated corner welded", "repeated corners welded");
  if (n_welded_vertices > 0 && weld_distance_m > 0.0) {
    char distance[40];
    std::snprintf(distance, sizeof distance, " (up to %.2g m apart)", weld_distance_m);
    result += distance;
  }
  say(n_collapsed_faces, "collapsed facet left out", "collapsed facets left out");
  say(n_duplicate_faces, "repeated facet left out", "repeated facets left out");
  say(n_recut_faces, "facet without height cut anew", "facets without height cut anew");
  say(n_turned_faces, "facet turned", "facets turned");
  say(n_turned_parts, "part turned inside out", "parts turned inside out");
  say(n_unused_vertices, "unused vertex left out", "unused vertices left out");
  say(n_extra_bytes, "byte behind the last facet left out", "bytes behind the last facet left out");
  return result;
}

SurfaceMesh repaired_surface(const SurfaceMesh& surface, const std::string& name, SurfaceRepairs& repairs) {
  const SurfaceMesh whole = compacted(surface, name);
  const Mender as_it_is(whole);
  const double weld = kWeldOfSize * as_it_is.size();
  std::vector<double> distances{-1.0, 0.0, weld};
  const double places = whole.vertices_m.rows() == 0 ? 0.0 : kLastPlaces * whole.vertices_m.cwiseAbs().maxCoeff();
  if (places > weld && places < 1e-3 * as_it_is.size()) distances.push_back(places);
  std::optional<Mender> best;
  long fewest = -1;
  const auto attempt = [&](double distance, bool pairs) {
    Mender mender = as_it_is;
    if (distance >= 0.0) mender.weld(distance);
    mender.drop_faces(pairs);
    mender.orient();
    mender.recut_flat_faces();
    if (!mender.has_faces()) return;
    const long n_faults = mender.n_faults();
    if (fewest >= 0 && n_faults >= fewest) return;
    fewest = n_faults;
    best.emplace(std::move(mender));
  };
  for (const double distance : distances) {
    attempt(distance, false);
    if (fewest != 0) attempt(distance, true);
    if (fewest == 0) break;
  }
  if (!best) return surface;  // nothing but collapsed faces
  if (fewest == 0) best->turn_parts();
  repairs = best->repairs();
  repairs.n_unused_vertices = static_cast<int>(surface.vertices_m.rows() - whole.vertices_m.rows());
  return compacted(best->surface(), name);
}

}  // namespace klang::mesh
