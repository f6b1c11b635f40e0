#pragma once
#include <map>
#include <string>

#include "core/geometry/shapes/detail/profile.hpp"

namespace klang::mesh::detail {

/// A drawn profile made larger or smaller and its wall thicker or thinner by zones, as a continuous map of the drawn section, so
/// that a mesh of the drawn one keeps its topology.
///
/// Dimensions, all of which may be left out:
///  - "size_m": the longer side of the bounding box of the drawn profile, scaled. Walls that are not named scale along.
///  - "wall_N_m": mean thickness of the wall at the points whose zone is N. Each of them moves along its inward normal by the
///    same share of the wall there, as on a lathe; other points stay.
/// A point's wall: the distance along the inward normal (bisector of its two sides) to the profile's other side. The inside
/// follows the corners by mean value coordinates (Hormann and Floater 2006, doi:10.1145/1183287.1183295, equations 10 and 11).
class ProfileChange {
 public:
  /// @throws InputError: a dimension that the profile does not have, a size beyond 1e-3 to 1e3 or a wall beyond 0.2 to 3 times the drawn
  /// one, a profile that would cross itself
  ProfileChange(const Profile& drawn, const std::map<std::string, double>& dims);

  /// The dimensions as drawn: size_m, and wall_N_m of each zone.
  static std::map<std::string, double> drawn_dimensions_m(const Profile& drawn);

  const Profile& changed() const { return changed_; }
  /// Where a point of the drawn section comes to lie.
  Eigen::Vector2d operator()(const Eigen::Vector2d& drawn_m) const;

 private:
  Profile drawn_, changed_;
};

}  // namespace klang::mesh::detail
