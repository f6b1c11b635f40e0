#include "core/geometry/shapes/detail/profile.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;

/// Numbers of a line; false when it holds anything else.
bool numbers_of(std::string_view line, std::vector<double>& numbers) {
  numbers.clear();
  const char* at = line.data();
  const char* end = at + line.size();
  while (true) {
    while (at < end && (*at == ' ' || *at == '\t' || *at == ',' || *at == ';' || *at == '\r')) ++at;
    if (at == end) return true;
    if (*at == '+') ++at;
    double value = 0.0;
    const auto [rest, error] = std::from_chars(at, end, value);
    if (error != std::errc()) return false;
    numbers.push_back(value);
    at = rest;
  }
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double point_segment_distance(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (p - a - t * d).norm();
}

bool segments_meet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d, double tolerance_m) {
  const double c_side = cross(b - a, c - a), d_side = cross(b - a, d - a);
  const double a_side = cross(d - c, a - c), b_side = cross(d - c, b - c);
  if (((c_side > 0) != (d_side > 0)) && ((a_side > 0) != (b_side > 0)) && c_side != d_side && a_side != b_side)
    return true;
  return point_segment_distance(a, c, d) <= tolerance_m || point_segment_distance(b, c, d) <= tolerance_m ||
         point_segment_distance(c, a, b) <= tolerance_m || point_segment_distance(d, a, b) <= tolerance_m;
}

std::string side_name(std::size_t i, std::size_t n) { return std::to_string(i) + " to " + std::to_string((i + 1) % n); }

void close_polygon(Profile& profile, double tolerance_m) {
  std::vector<Vector2d>& p = profile.points_m;
  const std::string& name = profile.name;
  if (p.size() > 1 && (p.front() - p.back()).norm() <= tolerance_m) {
    p.pop_back();
    profile.zones.pop_back();
    return;
  }
  if (p.front().x() == 0.0 && p.back().x() == 0.0) return;
  double longest = 0.0;
  for (std::size_t i = 0; i + 1 < p.size(); ++i) longest = std::max(longest, (p[i + 1] - p[i]).norm());
  const double gap = (p.front() - p.back()).norm();
  if (!(gap <= 2.0 * longest))
    throw InputError(name, "open profile: the last point does not meet the first", "gap " + to_text(gap) + " m",
                     "a closed polygon; repeat the first point to force it");
}

constexpr int kMostZones = 99;

/// The zone of a line's third number, 0 where it has none.
int zone_of(const std::vector<double>& numbers, const std::string& place) {
  if (numbers.size() < 3) return 0;
  if (!(numbers[2] >= 0.0 && numbers[2] <= kMostZones) || numbers[2] != std::floor(numbers[2]))
    throw InputError(place, "zone", to_text(numbers[2]), "a whole number, 0 to " + std::to_string(kMostZones));
  return static_cast<int>(numbers[2]);
}

}  // namespace

void check_simple(const std::vector<Vector2d>& p, const std::string& name, double tolerance) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d& a = p[i];
    const Vector2d& b = p[(i + 1) % n];
    const Vector2d& next = p[(i + 2) % n];
    // A side that turns straight back touches its neighbour along a line.
    if (std::abs(cross(b - a, next - b)) <= tolerance * (b - a).norm() && (b - a).dot(next - b) < 0.0)
      throw InputError(name, "profile touches itself at side (0-based points)", side_name(i, n), "a simple polygon");
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (std::max(p[j].x(), p[(j + 1) % n].x()) < std::min(a.x(), b.x()) - tolerance ||
          std::min(p[j].x(), p[(j + 1) % n].x()) > std::max(a.x(), b.x()) + tolerance)
        continue;
      if (segments_meet(a, b, p[j], p[(j + 1) % n], tolerance))
        throw InputError(name, "profile touches or crosses itself: sides (0-based points)",
                         side_name(i, n) + " and " + side_name(j, n), "a simple polygon");
    }
  }
}

Profile parse_profile(std::string_view text, const std::string& name) {
  Profile profile;
  profile.name = name;
  std::vector<Vector2d>& p = profile.points_m;
  std::vector<int> lines;
  std::vector<double> numbers;
  int line_number = 0;
  bool first = true;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++line_number;
    line = line.substr(0, std::min(line.find('#'), line.size()));
    if (line.find_first_not_of(" \t\r,;") == std::string_view::npos) continue;
    const bool numeric = numbers_of(line, numbers);
    const std::string place = name + ": line " + std::to_string(line_number);
    if (!numeric && first) {  // header
      const std::size_t r_at = line.find("r_m"), z_at = line.find("z_m");
      if (r_at == std::string_view::npos || z_at == std::string_view::npos || r_at > z_at)
        throw InputError(place, "not a profile", std::string(line.substr(0, 40)),
                         "header r_m,z_m or r_m,z_m,zone, or two or three numbers");
      first = false;
      continue;
    }
    first = false;
    if (!numeric || numbers.size() < 2 || numbers.size() > 3)
      throw InputError(place, "not two numbers", std::string(line.substr(0, 40)), "r_m, z_m, and a zone where wanted");
    if (!std::isfinite(numbers[0]) || !std::isfinite(numbers[1]) || std::abs(numbers[1]) > 1e6)
      throw InputError(place, "not a finite length", std::string(line.substr(0, 40)), "up to 1e6 m");
    if (!(numbers[0] >= 0.0 && numbers[0] <= 1e6)) throw InputError(place, "r_m", to_text(numbers[0]), "0 to 1e6");
    p.push_back({numbers[0], numbers[1]});
    profile.zones.push_back(zone_of(numbers, place));
    lines.push_back(line_number);
    if (p.size() > 20000) throw InputError(place, "too many points", "", "up to 20000");
  }
  if (p.size() < 3) throw InputError(name, "too few points", std::to_string(p.size()), "3 or more");

  Vector2d low = p[0], high = p[0];
  for (const Vector2d& point : p) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double size = std::max({(high - low).maxCoeff(), high.x(), 1e-300});
  const double tolerance = 1e-9 * size;
  for (Vector2d& point : p)
    if (point.x() <= 1e-9 * size) point.x() = 0.0;
  close_polygon(profile, tolerance);
  const std::size_t n = p.size();
  if (n < 3) throw InputError(name, "too few points", std::to_string(n), "3 or more");

  double area = 0.0;
  for (std::size_t i = 0; i < n; ++i) area += 0.5 * cross(p[i] - p[0], p[(i + 1) % n] - p[0]);
  for (std::size_t i = 0; i < n; ++i)
    if ((p[(i + 1) % n] - p[i]).norm() <= tolerance)
      throw InputError(name + ": line " + std::to_string(lines[i]), "repeated point", "", "distinct points");
  check_simple(p, name, tolerance);
  if (!(std::abs(area) > 1e-10 * size * size)) throw InputError(name, "profile encloses no area");
  if (area < 0.0) std::reverse(p.begin(), p.end()), std::reverse(profile.zones.begin(), profile.zones.end());
  for (std::size_t i = 0; i < n; ++i)
    if (p[i].x() == 0.0 && p[(i + 1) % n].x() > 0.0 && p[(i + n - 1) % n].x() > 0.0)
      throw InputError(name, "profile touches the axis in a single point, z_m", to_text(p[i].y()),
                       "a side along the axis, or r_m > 0");
  return profile;
}

Profile read_profile(const std::filesystem::path& path) {
  return parse_profile(read_file(path, std::size_t{1} << 24), path.string());
}

double profile_volume_m3(const Profile& profile) {
  // Sum of signed frustums: V = pi/3 sum (r0^2 + r0 r1 + r1^2) (z1 - z0), counter-clockwise.
  double volume = 0.0;
  const std::size_t n = profile.points_m.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d& a = profile.points_m[i];
    const Vector2d& b = profile.points_m[(i + 1) % n];
    volume += kPi / 3.0 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x()) * (b.y() - a.y());
  }
  return volume;
}

double profile_area_m2(const Profile& profile) {
  double area = 0.0;
  const std::size_t n = profile.points_m.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d& a = profile.points_m[i];
    const Vector2d& b = profile.points_m[(i + 1) % n];
    area += kPi * (a.x() + b.x()) * (b - a).norm();
  }
  return area;
}

double profile_extent_m(const Profile& profile) {
  Vector2d low = profile.points_m[0], high = low;
  for (const Vector2d& point : profile.points_m) low = low.cwiseMin(point), high = high.cwiseMax(point);
  return (high - low).maxCoeff();
}

double profile_thickness_m(const Profile& profile) {
  double perimeter_m = 0.0, twice_area_m2 = 0.0;
  for (std::size_t i = 0; i < profile.points_m.size(); ++i) {
    const Vector2d &a = profile.points_m[i], &b = profile.points_m[(i + 1) % profile.points_m.size()];
    perimeter_m += (b - a).norm();
    twice_area_m2 += a.x() * b.y() - a.y() * b.x();
  }
  return twice_area_m2 / perimeter_m;
}

}  // namespace klang::mesh::detail
