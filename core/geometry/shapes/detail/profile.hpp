#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace klang::mesh::detail {

/// A simple polygon in the half-plane r >= 0, counter-clockwise in (r, z), without a repeated last point.
struct Profile {
  std::vector<Eigen::Vector2d> points_m;
  std::string name;        ///< for messages
  std::vector<int> zones;  ///< one per point: zone of the wall that the point belongs to, 0: none
};

/// Reads columns r_m, z_m and, where there is one, zone (comma, semicolon or blanks between them; an optional header line;
/// # starts a comment). The polygon closes where the last point repeats the first, or by a straight side from the last
/// to the first that is at most twice as long as the longest drawn side, or that runs along the axis; a
/// longer one is taken for an open curve. Points at r = 0 make a solid body; a profile may touch the axis
/// along whole sides and at single ends, but not with one lone point (the body would hang together by a
/// point).
/// @throws InputError naming the line or the side: not finite, r < 0, fewer than 3 points, repeated points,
/// sides that touch or cross, no area, open
Profile read_profile(const std::filesystem::path& path);
Profile parse_profile(std::string_view text, const std::string& name);

/// @throws InputError naming two sides of a polygon that touch or cross
void check_simple(const std::vector<Eigen::Vector2d>& polygon_m, const std::string& name, double tolerance_m);

/// Exact volume (Pappus) and surface of the turned polygon.
double profile_volume_m3(const Profile& profile);
double profile_area_m2(const Profile& profile);

/// Longer side of the polygon's bounding box.
double profile_extent_m(const Profile& profile);
/// Mean thickness of a thin wall: twice area over perimeter.
double profile_thickness_m(const Profile& profile);

}  // namespace klang::mesh::detail
