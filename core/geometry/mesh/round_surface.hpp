#pragma once
#include <Eigen/Core>

namespace klang::mesh {

/// The image of the unit ball, centre_m + axes_m u with |u| <= 1: an ellipsoid, a disc where axes_m has a column of zeros (the third), a point where
/// all are zero. Of its surface only what has an outward normal n with n . pole >= least_cosine belongs to the body.
struct RoundSurface {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes_m = Eigen::Matrix3d::Zero();
  Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();  ///< unit
  double least_cosine = -2.0;

  bool is_disc() const { return axes_m.col(2).isZero(0) && !axes_m.col(0).isZero(0); }
  /// Half of what it measures along a unit direction.
  double half_width_m(const Eigen::Vector3d& direction) const { return (axes_m.transpose() * direction).norm(); }
  /// Farthest in a unit direction; of a disc that lies across it its middle.
  Eigen::Vector3d farthest_m(const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d along = axes_m.transpose() * direction;
    const double half = along.norm();
    return half > 0 ? Eigen::Vector3d(centre_m + axes_m * along / half) : centre_m;
  }
};

}  // namespace klang::mesh
