#include "core/geometry/mesh/surface_coarsening.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/surface_check.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector3d;

constexpr double kLongest = 1.4;        ///< of the wanted edge
constexpr double kSmallestTurn = 0.5;   ///< cosine between a triangle's normal before and after
constexpr double kWorstQuality = 0.25;  ///< 4 sqrt(3) area / sum of squared edges; 1 equilateral

/// Sum over planes of area x squared distance, x^T A x + 2 b^T x + c, about a common origin.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double c = 0.0, weight = 0.0;
  void add_plane(const Vector3d& normal, const Vector3d& point, double area) {
    const double d = -normal.dot(point);
    a += area * normal * normal.transpose();
    b += area * d * normal;
    c += area * d * d;
    weight += area;
  }
  Quadric operator+(const Quadric& other) const {
    return {a + other.a, b + other.b, c + other.c, weight + other.weight};
  }
  double mean_sq(const Vector3d& x) const { return std::max(x.dot(a * x) + 2.0 * b.dot(x) + c, 0.0) / weight; }
};

class Collapser {
 public:
  Collapser(const SurfaceMesh& surface, const CoarseningOptions& options, const std::vector<int>& planes_of_vertex,
            const std::vector<double>& times_larger)
      : options_(options), planes_(planes_of_vertex), times_larger_(times_larger) {
    const auto n = static_cast<int>(surface.triangles.rows());
    origin_ = surface.vertices_m.row(surface.triangles(0, 0));
    points_.resize(static_cast<std::size_t>(surface.vertices_m.rows()));
    planes_.resize(points_.size(), 0);
    times_larger_.resize(points_.size(), 1.0);
    for (std::size_t v = 0; v < points_.size(); ++v)
      points_[v] = surface.vertices_m.row(static_cast<Eigen::Index>(v)).transpose() - origin_;
    quadrics_.resize(points_.size());
    of_vertex_.resize(points_.size());
    stamp_.assign(points_.size(), 0);
    for (int t = 0; t < n; ++t) {
      triangles_.push_back({surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
      const Vector3d doubled = doubled_normal(triangles_.back());
      for (const int v : triangles_.back()) {
        of_vertex_[v].push_back(t);
        quadrics_[v].add_plane(doubled.normalized(), points_[v], 0.5 * doubled.norm());
      }
    }
    alive_.assign(triangles_.size(), true);
    n_alive_ = n;
  }

  SurfaceMesh run() {
    for (const auto& t : triangles_)
      for (int c = 0; c < 3; ++c)
        if (t[c] < t[(c + 1) % 3]) push(t[c], t[(c + 1) % 3]);
    while (!queue_.empty() && n_alive_ > options_.stop_at_triangles) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (entry.stamp_a != stamp_[entry.a] || entry.stamp_b != stamp_[entry.b]) continue;
      try_collapse(entry.a, entry.b);
    }
    return result();
  }

 private:
  struct Entry {
    double length;
    int a, b, stamp_a, stamp_b;
    bool operator<(const Entry& other) const {  // the queue gives the largest first
      return std::tie(length, a, b) > std::tie(other.length, other.a, other.b);
    }
  };

  Vector3d doubled_normal(const std::array<int, 3>& t) const {
    return (points_[t[1]] - points_[t[0]]).cross(points_[t[2]] - points_[t[0]]);
  }

  void push(int a, int b) {
    if (a > b) std::swap(a, b);
    const double length = (points_[a] - points_[b]).norm() / times_larger(a, b);
    if (length < options_.edge_m) queue_.push({length, a, b, stamp_[a], stamp_[b]});
  }

  double times_larger(int a, int b) const { return 0.5 * (times_larger_[a] + times_larger_[b]); }

  std::vector<int> neighbours(int v) const {
    std::vector<int> found;
    for (const int t : of_vertex_[v])
      for (const int w : triangles_[t])
        if (w != v) found.push_back(w);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// The triangles of v but not of its partner, with v moved to x: nothing turned over, no sliver, no edge too long.
  bool stays_sound(int v, int partner, const Vector3d& x) const {
    for (const int t : of_vertex_[v]) {
      const auto& triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), partner) != triangle.end()) continue;
      std::array<Vector3d, 3> p;
      for (int c = 0; c < 3; ++c) p[c] = triangle[c] == v ? x : points_[triangle[c]];
      const Vector3d before = doubled_normal(triangle), after = (p[1] - p[0]).cross(p[2] - p[0]);
      if (!(before.dot(after) > kSmallestTurn * before.norm() * after.norm())) return false;
      double sum_sq = 0.0;
      for (int c = 0; c < 3; ++c) {
        const double edge_sq = (p[(c + 1) % 3] - p[c]).squaredNorm();
        const bool moved = triangle[c] == v || triangle[(c + 1) % 3] == v;
        if (moved &&
            edge_sq > std::pow(kLongest * options_.edge_m * times_larger(triangle[c], triangle[(c + 1) % 3]), 2))
          return false;
        sum_sq += edge_sq;
      }
      const double quality = 2.0 * std::sqrt(3.0) * after.norm() / sum_sq;
      double old_sum_sq = 0.0;
      for (int c = 0; c < 3; ++c) old_sum_sq += (points_[triangle[(c + 1) % 3]] - points_[triangle[c]]).squaredNorm();
      const double old_quality = 2.0 * std::sqrt(3.0) * before.norm() / old_sum_sq;
      if (quality < std::min(kWorstQuality, old_quality)) return false;
    }
    return true;
  }

  void try_collapse(int a, int b) {
    const std::vector<int> of_a = neighbours(a), of_b = neighbours(b);
    std::vector<int> common;
    std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(common));
    // Along the open edge there is one triangle; elsewhere two vertices of it must not meet.
    const int on_both = planes_[a] & planes_[b], on_one = planes_[a] | planes_[b];
    if (on_one != planes_[a] && on_one != planes_[b]) return;
    if (common.size() != (on_both != 0 ? 1U : 2U)) return;  // would pinch the surface
    for (const int w : common)
      if (of_vertex_[w].size() <= (planes_[w] != 0 ? 1U : 3U)) return;  // would leave triangles on the same corners
    const Quadric sum = quadrics_[a] + quadrics_[b];
    // The best point on the planes; in the directions that they leave free, the middle.
    const Vector3d middle = 0.5 * (points_[a] + points_[b]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sum.a);
    const Vector3d slope = sum.a * middle + sum.b;
    Vector3d best = middle;
    for (int i = 0; i < 3; ++i) {
      const double stiffness = eigen.eigenvalues()[i];
      if (stiffness > 1e-3 * eigen.eigenvalues()[2])
        best -= eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(slope) / stiffness);
    }
    for (int axis = 0; axis < 3; ++axis)
      if ((on_both >> axis & 1) != 0) best[axis] = points_[a][axis];
    if ((best - middle).norm() > (points_[a] - points_[b]).norm()) best = middle;
    std::array<std::pair<double, Vector3d>, 4> choices{{{sum.mean_sq(best), best},
                                                        {sum.mean_sq(middle), middle},
                                                        {sum.mean_sq(points_[a]), points_[a]},
                                                        {sum.mean_sq(points_[b]), points_[b]}}};
    std::stable_sort(choices.begin() + 1, choices.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    for (const auto& [error_sq, x] : choices) {
      if (planes_[a] != planes_[b] && x != points_[planes_[a] == on_one ? a : b]) continue;
      if (!(error_sq <= options_.tolerance_m * options_.tolerance_m)) continue;
      if (!stays_sound(a, b, x) || !stays_sound(b, a, x)) continue;
      collapse(a, b, x, sum);
      return;
    }
  }

  void collapse(int a, int b, const Vector3d& x, const Quadric& sum) {
    points_[a] = x;
    planes_[a] |= planes_[b];
    times_larger_[a] = times_larger(a, b);
    quadrics_[a] = sum;
    ++stamp_[a];
    ++stamp_[b];
    for (const int t : of_vertex_[b]) {
      auto& triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), a) != triangle.end()) {
        alive_[t] = false;
        --n_alive_;
        for (const int w : triangle)
          if (w != b) std::erase(of_vertex_[w], t);
      } else {
        std::replace(triangle.begin(), triangle.end(), b, a);
        of_vertex_[a].push_back(t);
      }
    }
    of_vertex_[b].clear();
    for (const int w : neighbours(a)) push(a, w);
  }

  SurfaceMesh result() const {
    SurfaceMesh surface;
    std::vector<int> number(points_.size(), -1), kept;
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (!of_vertex_[v].empty()) {
        number[v] = static_cast<int>(kept.size());
        kept.push_back(static_cast<int>(v));
      }
    surface.vertices_m.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t i = 0; i < kept.size(); ++i)
      surface.vertices_m.row(static_cast<Eigen::Index>(i)) = (points_[kept[i]] + origin_).transpose();
    surface.triangles.resize(std::count(alive_.begin(), alive_.end(), true), 3);
    Eigen::Index row = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!alive_[t]) continue;
      for (int c = 0; c < 3; ++c) surface.triangles(row, c) = number[triangles_[t][c]];
      ++row;
    }
    return surface;
  }

  CoarseningOptions options_;
  Vector3d origin_;
  std::vector<Vector3d> points_;
  std::vector<int>
      planes_;  ///< by vertex, bits: normals of the planes at which the surface is open and on which it lies
  std::vector<double> times_larger_;
  std::vector<Quadric> quadrics_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<bool> alive_;
  int n_alive_ = 0;
  std::vector<std::vector<int>> of_vertex_;
  std::vector<int> stamp_;
  std::priority_queue<Entry> queue_;
};

}  // namespace

void CoarseningOptions::validate() const { validate_fields("coarsening", *this); }

SurfaceMesh coarsened(const SurfaceMesh& surface, const CoarseningOptions& options,
                      const std::vector<int>& planes_of_vertex, const std::vector<double>& times_larger) {
  options.validate();
  return Collapser(surface, options, planes_of_vertex, times_larger).run();
}

SurfaceMesh checked_coarsened(const SurfaceMesh& surface, CoarseningOptions options) {
  for (int attempt = 0; attempt < 3; ++attempt) {
    SurfaceMesh result = coarsened(surface, options);
    try {
      check_closed_surface(result, "coarsened surface");
      return result;
    } catch (const InputError&) {
      options.tolerance_m *= 0.25;
    }
  }
  return coarsened(surface, {1e-300, 0.0});
}

double wall_tolerance_m(const SurfaceMesh& surface) {
  const auto n = surface.triangles.rows();
  const Eigen::Index step = std::max<Eigen::Index>(1, n / 400);
  const auto at = [&](Eigen::Index t, int c) -> Vector3d {
    return surface.vertices_m.row(surface.triangles(t, c)).transpose();
  };
  std::vector<double> walls;
  for (Eigen::Index t = 0; t < n; t += step) {
    const Vector3d from = (at(t, 0) + at(t, 1) + at(t, 2)) / 3.0;
    const Vector3d inward = -(at(t, 1) - at(t, 0)).cross(at(t, 2) - at(t, 0)).normalized();
    double nearest = HUGE_VAL;
    for (Eigen::Index other = 0; other < n; ++other) {
      if (other == t) continue;
      const Vector3d e1 = at(other, 1) - at(other, 0), e2 = at(other, 2) - at(other, 0), h = inward.cross(e2);
      const double det = e1.dot(h);
      if (det == 0.0) continue;
      const Vector3d s = from - at(other, 0);
      const double u = s.dot(h) / det, v = inward.dot(s.cross(e1)) / det, way = e2.dot(s.cross(e1)) / det;
      if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && way > 0.0) nearest = std::min(nearest, way);
    }
    if (std::isfinite(nearest)) walls.push_back(nearest);
  }
  if (walls.empty()) return 0.0;
  std::sort(walls.begin(), walls.end());
  return 0.1 * walls[walls.size() / 10];
}

}  // namespace klang::mesh
