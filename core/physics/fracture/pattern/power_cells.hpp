#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/physics/fracture/pattern/region_cut.hpp"
#include "core/physics/fracture/pattern/seeds.hpp"

namespace klang::fracture {

/// The half-space normal . x <= offset_m.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of length 1
  double offset_m = 0.0;
};

/// Cells |x - p_i|^2 - w_i least: convex, with plane faces (power or Laguerre cells). SB's cells, k_i |x - p_i| least, are bounded
/// by balls, not convex, and can lie inside one another (errata 55).
///
/// SB's weights k_i = density_i^alpha say where a boundary cuts the line from p_i to p_j: at the fraction k_j/(k_i + k_j) of the
/// distance d. A plane of power cells cuts it at 1/2 + (w_i - w_j)/(2 d^2). No w makes both equal for all pairs, so w is the least
/// squares solution, pair (i, j) weighed by 1/d^2 because it is near pairs that have a common boundary:
///   min sum_{i<j} d_ij^-6 (w_i - w_j - d_ij^2 (k_j - k_i)/(k_i + k_j))^2,   sum w_i = 0.
/// For two seeds the plane touches SB's ball on the line between them; high density makes small cells, as there. Then all w are
/// scaled, if need be, so that |w_i - w_j| <= 0.6 d_ij^2: no boundary comes nearer to a seed than a fifth of the distance to the
/// other, and no cell is empty.
class PowerCells {
 public:
  PowerCells(std::vector<Seed> seeds, double alpha);

  int n_cells() const { return static_cast<int>(seeds_.size()); }
  const std::vector<Seed>& seeds() const { return seeds_; }
  const Eigen::VectorXd& weights_m2() const { return weights_m2_; }

  /// What is left of |x - p_i|^2 - w_i without |x|^2, linear in x.
  RegionFields fields(const mesh::TetMesh& mesh) const;
  /// One for each other cell: the cell is their intersection.
  std::vector<HalfSpace> half_spaces(int cell) const;

 private:
  std::vector<Seed> seeds_;
  Eigen::VectorXd weights_m2_;
};

/// Corners of the part of a convex hull that lies in a half-space; none where nothing of it does. The corners that are cut off are replaced by those
/// of the section: the plane hull of where lines from corners inside to corners outside meet the plane.
Eigen::Matrix3Xd clipped_corners(const Eigen::Matrix3Xd& corners_m, const HalfSpace& half_space);

}  // namespace klang::fracture
