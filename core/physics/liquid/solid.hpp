#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/liquid/grid.hpp"

namespace klang::liquid {

enum class SolidShape { kSphere, kBox, kHalfSpace, kCylinder };
enum class SolidMotion { kFixed, kFree, kKeys };

/// Places of a solid at times, linear between, at rest before and after.
struct SolidKeys {
  std::vector<double> time_s;  ///< rising
  std::vector<Eigen::Vector3d> position_m;
  Eigen::Vector3d position_at(double time_s) const;
};

/// A rigid solid in the liquid. It does not turn.
struct Solid {
  SolidShape shape = SolidShape::kSphere;
  double radius_m = 0.0;                                 ///< sphere, cylinder
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();      ///< box; cylinder: x is its length
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();     ///< half space: out of the solid; cylinder: its axis; length 1
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< centre; half space: a point of its plane
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  SolidMotion motion = SolidMotion::kFixed;
  double density_kg_m3 = 0.0;  ///< free
  SolidKeys keys;
  bool streams = false;  ///< its surface moves with velocity_m_s while it stays: where an inlet comes from
  std::string name;

  double distance_m(const Eigen::Vector3d& x_m) const;  ///< below 0 inside
  bool moves() const { return motion != SolidMotion::kFixed; }
  bool is_outside(const Eigen::Vector3d& size_m) const;  ///< wholly, of the box [0, size]
  double volume_m3() const;                              ///< sphere and box
  double outer_radius_m() const;  ///< of a ball about its position that holds it; infinite for a half space
};

/// Which part of the grid is open to liquid.
struct SolidField {
  Field distance_m;    ///< at nodes, of all solids and not of the box's walls; > 0 outside
  MacGrid open;        ///< share of each face that is open; 0 at the box's walls
  Grid3<int> nearest;  ///< per cell: which solid is nearest to its centre; -1: none
  Field open_volume;   ///< share of each cell
  bool any = false;    ///< there are solids
  bool round = false;  ///< shares are those of a sector about the axis x = 0, see sector_field()
  bool whole(int i, int j, int k) const { return round || open_volume(i, j, k) >= 1.0; }
};

/// Shares by the plane through the distances at corners (exact for planes).
SolidField solid_field(const GridShape& shape, const std::vector<Solid>& solids);

/// Of a liquid that is the same all around an axis: the grid is a layer of cells (ny = 1), x the distance from the axis. Faces and cells
/// have shares x / (nx h), as a narrow sector has: with them what flows in and out is what does so in the round.
SolidField sector_field(const GridShape& shape);

/// Share of the square with these values at its corners (in order around it) that is positive.
double positive_area(double a, double b, double c, double d);

}  // namespace klang::liquid
