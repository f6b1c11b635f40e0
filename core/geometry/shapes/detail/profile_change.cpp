#include "core/geometry/shapes/detail/profile_change.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;

constexpr double kThinnestWall = 0.2, kThickestWall = 3.0;  // times the drawn one
constexpr double kSmallest = 1e-3, kLargest = 1e3;          // times the drawn size

double cross_of(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

std::string wall_name(int zone) { return "wall_" + std::to_string(zone) + "_m"; }

/// Of a counter-clockwise polygon: to the left of its sides.
Vector2d inward_normal(const std::vector<Vector2d>& p, std::size_t i) {
  const std::size_t n = p.size();
  const auto left = [](const Vector2d& side) { return Vector2d(-side.y(), side.x()).normalized(); };
  return (left(p[i] - p[(i + n - 1) % n]) + left(p[(i + 1) % n] - p[i])).normalized();
}

/// From a corner along its inward normal to the polygon's other side.
double wall_at(const std::vector<Vector2d>& p, std::size_t i) {
  const std::size_t n = p.size();
  const Vector2d along = inward_normal(p, i);
  double nearest = HUGE_VAL;
  for (std::size_t j = 0; j < n; ++j) {
    if (j == i || (j + 1) % n == i) continue;
    const Vector2d side = p[(j + 1) % n] - p[j], to = p[j] - p[i];
    const double determinant = cross_of(along, side);
    if (determinant == 0.0) continue;
    const double distance = cross_of(to, side) / determinant, share = cross_of(to, along) / determinant;
    if (distance > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, distance);
  }
  return nearest;
}

std::set<int> zones_of(const Profile& profile) {
  std::set<int> zones(profile.zones.begin(), profile.zones.end());
  zones.erase(0);
  return zones;
}

double mean_wall_m(const Profile& profile, int zone) {
  double sum_m = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < profile.points_m.size(); ++i)
    if (profile.zones[i] == zone) sum_m += wall_at(profile.points_m, i), ++count;
  if (!std::isfinite(sum_m))
    throw InputError(profile.name, "zone " + std::to_string(zone) + " has a point without a wall behind it");
  return sum_m / count;
}

}  // namespace

std::map<std::string, double> ProfileChange::drawn_dimensions_m(const Profile& drawn) {
  std::map<std::string, double> dims{{"size_m", profile_extent_m(drawn)}};
  for (const int zone : zones_of(drawn)) dims[wall_name(zone)] = mean_wall_m(drawn, zone);
  return dims;
}

ProfileChange::ProfileChange(const Profile& drawn, const std::map<std::string, double>& dims)
    : drawn_(drawn), changed_(drawn) {
  if (dims.empty()) return;
  const std::map<std::string, double> as_drawn = drawn_dimensions_m(drawn);
  std::vector<std::string> known;
  for (const auto& [name, value] : as_drawn) known.push_back(name);
  for (const auto& [name, value] : dims)
    if (!as_drawn.count(name)) throw unknown_word(drawn.name, "unknown dimension", name, name, known);
  double factor = 1.0;
  if (const auto size = dims.find("size_m"); size != dims.end()) {
    const double drawn_m = as_drawn.at("size_m");
    factor = checked_open(drawn.name, "size_m", size->second, kSmallest * drawn_m, kLargest * drawn_m) / drawn_m;
  }
  std::vector<Vector2d>& p = changed_.points_m;
  for (const int zone : zones_of(drawn)) {
    const auto wall = dims.find(wall_name(zone));
    if (wall == dims.end()) continue;
    const double drawn_m = factor * as_drawn.at(wall->first);
    const double share =
        checked_open(drawn.name, wall->first, wall->second, kThinnestWall * drawn_m, kThickestWall * drawn_m) / drawn_m;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (drawn.zones[i] == zone) p[i] += (1.0 - share) * wall_at(drawn.points_m, i) * inward_normal(drawn.points_m, i);
  }
  for (Vector2d& point : p) {
    point *= factor;
    if (!(point.x() >= 0.0)) throw InputError(drawn.name, "profile thus changed crosses the axis");
  }
  check_simple(p, drawn.name + ", changed", 1e-9 * profile_extent_m(changed_));
}

Vector2d ProfileChange::operator()(const Vector2d& drawn_m) const {
  const std::vector<Vector2d>& from = drawn_.points_m;
  const std::vector<Vector2d>& to = changed_.points_m;
  const std::size_t n = from.size();
  const double tiny = 1e-12 * profile_extent_m(drawn_);
  // Half tangents of the angles under which the sides are seen; on a side itself they are infinite.
  std::vector<double> half_tangent(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    const Vector2d a = from[i] - drawn_m, b = from[next] - drawn_m;
    const double length_m = (b - a).norm(), area = cross_of(a, b), projection = a.dot(b);
    if (a.norm() <= tiny) return to[i];
    if (std::abs(area) <= tiny * length_m && projection <= 0.0)
      return to[i] + (a.norm() / length_m) * (to[next] - to[i]);
    half_tangent[i] = area / (a.norm() * b.norm() + projection);
  }
  Vector2d moved = Vector2d::Zero();
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double weight = (half_tangent[(i + n - 1) % n] + half_tangent[i]) / (from[i] - drawn_m).norm();
    moved += weight * to[i];
    sum += weight;
  }
  return moved / sum;
}

}  // namespace klang::mesh::detail
