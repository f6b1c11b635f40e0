#pragma once
#include <Eigen/Core>

#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::validate::detail {

/// A box of liquid around the z axis, floor at -depth_m, with a crater in its free top as a drop leaves it: a dimple with a raised
/// rim, height(r) = -dimple_m (1 - (r/w)^2) exp(-(r/w)^2), flat at the walls. Floor and walls rigid.
struct DimpledTank {
  double side_m = 0.14, depth_m = 0.08;
  double dimple_m = 0.006, width_m = 0.03;  ///< depth and w of the crater; 0: flat
  double height_m(double x, double y) const;
  bool inside(const Eigen::Vector3d& x_m) const;
  bubble::BoundaryMesh mesh(double h_m) const;
};

}  // namespace klang::validate::detail
