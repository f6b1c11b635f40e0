#include "core/sound/dual_domain/liquid_boundary.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/dual_domain/detail/closest_point.hpp"

namespace klang::bubble {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr std::size_t kTrianglesPerRange = 2048;

std::string words(const Vector3d& x) { return to_text(x.x()) + "," + to_text(x.y()) + "," + to_text(x.z()); }

/// Vertices closer than the tolerance along every axis become one: sorted by x, then looked for in a window.
std::vector<int> weld(const mesh::Points& points, double tolerance) {
  std::vector<int> order(static_cast<std::size_t>(points.rows())), target(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::iota(target.begin(), target.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return points(a, 0) != points(b, 0) ? points(a, 0) < points(b, 0) : a < b; });
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t k = i; k-- > 0 && points(order[i], 0) - points(order[k], 0) <= tolerance;)
      if (target[static_cast<std::size_t>(order[k])] == order[k] &&
          (points.row(order[i]) - points.row(order[k])).cwiseAbs().maxCoeff() <= tolerance) {
        target[static_cast<std::size_t>(order[i])] = order[k];
        break;
      }
  return target;
}

}  // namespace

void BoundaryOptions::validate() const { validate_fields("liquid boundary", *this); }

bool LiquidBoundary::counts(std::size_t triangle, bool of_liquid) const {
  const auto region = static_cast<BoundaryRegion>(region_[triangle]);
  return region != (of_liquid ? BoundaryRegion::kDrySolid : BoundaryRegion::kWetSolid);
}

LiquidBoundary::LiquidBoundary(const BoundaryMesh& mesh, const BoundaryOptions& options)
    : region_(mesh.region), name_(mesh.name) {
  options.validate();
  const Index n_vertices = mesh.surface.vertices_m.rows(), n_triangles = mesh.surface.triangles.rows();
  KLANG_CHECK(region_.size() == static_cast<std::size_t>(n_triangles), "a boundary has one region per triangle");
  if (n_triangles == 0) throw InputError(name_, "the boundary has no triangles");
  for (Index i = 0; i < n_vertices; ++i)
    if (!mesh.surface.vertices_m.row(i).allFinite())
      throw InputError(name_, "vertex " + std::to_string(i) + " is not finite");
  const Vector3d low = mesh.surface.vertices_m.colwise().minCoeff().transpose(),
                 high = mesh.surface.vertices_m.colwise().maxCoeff().transpose();
  const double size = (high - low).norm();
  if (!(size > 0.0)) throw InputError(name_, "the boundary has no size");
  surface_.vertices_m = mesh.surface.vertices_m;
  surface_.triangles.resize(n_triangles, 3);
  target_ = weld(surface_.vertices_m, 1e-9 * size);
  for (Index t = 0; t < n_triangles; ++t) {
    const std::string face = "face " + std::to_string(t);
    for (int c = 0; c < 3; ++c) {
      const int v = mesh.surface.triangles(t, c);
      if (v < 0 || v >= n_vertices)
        throw InputError(name_, face + ": vertex out of range", std::to_string(v),
                         "0 to " + std::to_string(n_vertices - 1));
      surface_.triangles(t, c) = welded_vertex(v);
    }
    const int region = region_[static_cast<std::size_t>(t)];
    if (region < 0 || region > 3)
      throw InputError(name_, face + " has an unknown region", std::to_string(region),
                       "0 free surface, 1 rigid wall, 2 solid in the liquid, 3 its dry part");
  }
  if (std::find(region_.begin(), region_.end(), 0) == region_.end())
    throw InputError(name_, "the liquid has no free surface", "no face of region 0");
  check_closed(true);
  const bool has_solid = std::find(region_.begin(), region_.end(), 2) != region_.end() ||
                         std::find(region_.begin(), region_.end(), 3) != region_.end();
  if (has_solid) check_closed(false);

  measure();
  if (!(volume_m3_ > 0.0))
    throw InputError(name_, "the normals point into the liquid", "volume " + to_text(volume_m3_) + " m3",
                     "faces counter-clockwise seen from outside");
  sample(options.crease_angle_deg);
  if (options.expand_m > 0.0) {
    std::vector<Vector3d> shift(static_cast<std::size_t>(n_vertices), Vector3d::Zero());
    for (const BoundarySample& s : samples_)
      if (s.region == BoundaryRegion::kFreeSurface) shift[static_cast<std::size_t>(s.vertex)] += s.area_m2 * s.normal;
    for (Index i = 0; i < n_vertices; ++i) {
      const double length = shift[static_cast<std::size_t>(i)].norm();
      if (length > 0.0)
        surface_.vertices_m.row(i) += options.expand_m / length * shift[static_cast<std::size_t>(i)].transpose();
    }
    measure();
    sample(options.crease_angle_deg);
  }
}

void LiquidBoundary::check_closed(bool of_liquid) const {
  struct Use {
    int from, to, triangle;
  };
  std::vector<Use> uses;
  for (Index t = 0; t < surface_.triangles.rows(); ++t) {
    if (!counts(static_cast<std::size_t>(t), of_liquid)) continue;
    for (int c = 0; c < 3; ++c) {
      const int a = surface_.triangles(t, c), b = surface_.triangles(t, (c + 1) % 3);
      if (a == b) throw InputError(name_, "face " + std::to_string(t) + " has no area", "two of its corners agree");
      uses.push_back({a, b, static_cast<int>(t)});
    }
  }
  const auto key = [](const Use& u) { return std::pair(std::min(u.from, u.to), std::max(u.from, u.to)); };
  std::sort(uses.begin(), uses.end(),
            [&](const Use& a, const Use& b) { return key(a) != key(b) ? key(a) < key(b) : a.triangle < b.triangle; });
  const std::string air = of_liquid ? "" : ", seen from the air without the wet solid,";
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i + 1;
    while (end < uses.size() && key(uses[end]) == key(uses[i])) ++end;
    const std::string face = "face " + std::to_string(uses[i].triangle);
    const std::string at = words(surface_.vertices_m.row(uses[i].from).transpose()) + " to " +
                           words(surface_.vertices_m.row(uses[i].to).transpose());
    if (end - i == 1)
      throw InputError(name_, "the boundary" + air + " is open at an edge of " + face, at,
                       "a closed surface around the liquid");
    if (end - i == 2 && uses[i].from == uses[i + 1].from)
      throw InputError(name_,
                       "inconsistent normals: " + face + " and face " + std::to_string(uses[i + 1].triangle) +
                           " run the same way along their edge",
                       at, "faces counter-clockwise seen from outside");
    // Splashes touch themselves along edges: as many faces must run each way.
    int balance = 0;
    for (std::size_t k = i; k < end; ++k) balance += uses[k].from < uses[k].to ? 1 : -1;
    if (balance != 0)
      throw InputError(name_, "inconsistent normals: " + std::to_string(end - i) + " faces share an edge of " + face,
                       at, "as many one way as the other");
    i = end;
  }
}

void LiquidBoundary::measure() {
  volume_m3_ = free_area_m2_ = rigid_area_m2_ = 0.0;
  Vector3d moment = Vector3d::Zero();
  const Vector3d origin = corner(0, 0);  // keeps the digits of a small body far from zero
  for (Index t = 0; t < surface_.triangles.rows(); ++t) {
    if (!counts(static_cast<std::size_t>(t), true)) continue;
    const Vector3d a = corner(t, 0) - origin, b = corner(t, 1) - origin, c = corner(t, 2) - origin;
    const double six = a.dot(b.cross(c)), area = 0.5 * (b - a).cross(c - a).norm();
    volume_m3_ += six / 6.0;
    moment += six / 24.0 * (a + b + c);
    (region_[static_cast<std::size_t>(t)] == 0 ? free_area_m2_ : rigid_area_m2_) += area;
  }
  if (!(volume_m3_ > 0.0)) return;
  centre_m_ = origin + moment / volume_m3_;
  radius_m_ = 0.0;
  for (Index t = 0; t < surface_.triangles.rows(); ++t)
    if (counts(static_cast<std::size_t>(t), true))
      for (int c = 0; c < 3; ++c) radius_m_ = std::max(radius_m_, (corner(t, c) - centre_m_).norm());
}

void LiquidBoundary::sample(double crease_angle_deg) {
  struct Group {
    int region;
    Vector3d first, sum;
    double area;
  };
  const double crease = std::cos(crease_angle_deg * kPi / 180.0);
  std::vector<std::vector<Group>> groups(static_cast<std::size_t>(surface_.vertices_m.rows()));
  double area = 0.0;
  for (Index t = 0; t < surface_.triangles.rows(); ++t) {
    const Vector3d cross = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
    const double twice = cross.norm();
    if (!(twice > 0.0)) continue;  // slivers of marching tetrahedra
    const Vector3d normal = cross / twice;
    area += 0.5 * twice;
    for (int c = 0; c < 3; ++c) {
      const Vector3d u = (corner(t, (c + 1) % 3) - corner(t, c)).normalized(),
                     v = (corner(t, (c + 2) % 3) - corner(t, c)).normalized();
      const double angle = std::acos(std::clamp(u.dot(v), -1.0, 1.0));
      auto& list = groups[static_cast<std::size_t>(surface_.triangles(t, c))];
      const int region = region_[static_cast<std::size_t>(t)];
      const auto it = std::find_if(list.begin(), list.end(),
                                   [&](const Group& g) { return g.region == region && g.first.dot(normal) >= crease; });
      if (it == list.end()) {
        list.push_back({region, normal, angle * normal, twice / 6.0});
      } else {
        it->sum += angle * normal;
        it->area += twice / 6.0;
      }
    }
  }
  samples_.clear();
  for (std::size_t v = 0; v < groups.size(); ++v)
    for (const Group& g : groups[v]) {
      const double length = g.sum.norm();
      samples_.push_back({surface_.vertices_m.row(static_cast<Index>(v)).transpose(),
                          length > 0.0 ? Vector3d(g.sum / length) : g.first, g.area,
                          static_cast<BoundaryRegion>(g.region), static_cast<int>(v)});
    }
  spacing_m_ = std::sqrt(area / static_cast<double>(samples_.size()));
}

bool LiquidBoundary::inside(const Vector3d& x_m, bool of_liquid) const {
  const auto n = static_cast<std::size_t>(surface_.triangles.rows());
  std::vector<double> turns((n + kTrianglesPerRange - 1) / kTrianglesPerRange, 0.0);
  // Half the solid angles (van Oosterom and Strackee 1983): 2 pi from inside.
  parallel_for(n, kTrianglesPerRange, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t t = begin; t < end; ++t) {
      if (!counts(t, of_liquid)) continue;
      const auto face = static_cast<Index>(t);
      const Vector3d a = corner(face, 0) - x_m, b = corner(face, 1) - x_m, c = corner(face, 2) - x_m;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    turns[begin / kTrianglesPerRange] = sum;
  });
  return std::accumulate(turns.begin(), turns.end(), 0.0) > kPi;
}

bool LiquidBoundary::inside_liquid(const Vector3d& x_m) const { return inside(x_m, true); }
bool LiquidBoundary::inside_air_boundary(const Vector3d& x_m) const { return inside(x_m, false); }

template <class Wanted>
std::optional<Vector3d> LiquidBoundary::nearest(const Vector3d& x_m, const Wanted& wanted) const {
  const auto n = static_cast<std::size_t>(surface_.triangles.rows());
  struct Best {
    double distance_sq = HUGE_VAL;
    Vector3d point;
  };
  std::vector<Best> best((n + kTrianglesPerRange - 1) / kTrianglesPerRange);
  parallel_for(n, kTrianglesPerRange, [&](std::size_t begin, std::size_t end) {
    Best& here = best[begin / kTrianglesPerRange];
    for (std::size_t t = begin; t < end; ++t) {
      if (!counts(t, true) || !wanted(region_[t])) continue;
      const auto face = static_cast<Index>(t);
      const Vector3d at = detail::closest_point(x_m, corner(face, 0), corner(face, 1), corner(face, 2));
      const double distance_sq = (at - x_m).squaredNorm();
      if (distance_sq < here.distance_sq) here = {distance_sq, at};
    }
  });
  const Best& first = *std::min_element(best.begin(), best.end(),
                                        [](const Best& a, const Best& b) { return a.distance_sq < b.distance_sq; });
  return first.distance_sq < HUGE_VAL ? std::optional(first.point) : std::nullopt;
}

double LiquidBoundary::distance_m(const Vector3d& x_m) const {
  return (*nearest(x_m, [](int) { return true; }) - x_m).norm();
}

std::optional<Vector3d> LiquidBoundary::nearest_point_m(const Vector3d& x_m, bool free_surface) const {
  return nearest(x_m, [&](int region) { return (region == 0) == free_surface; });
}

void LiquidBoundary::check_bubble(const Vector3d& x_m, double clearance_m) const {
  if (!x_m.allFinite()) throw InputError("bubble", "position is not finite", words(x_m));
  const double distance = distance_m(x_m);
  if (!(distance > clearance_m))
    throw InputError("bubble", "lies on the boundary of the liquid (" + name_ + ")", words(x_m),
                     "more than " + to_text(clearance_m) + " m from it; --expand-m moves the free surface out");
  if (!inside_liquid(x_m)) throw InputError("bubble", "lies outside the liquid (" + name_ + ")", words(x_m));
}

}  // namespace klang::bubble
