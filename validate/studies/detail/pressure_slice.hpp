#pragma once
#include <functional>

#include "validate/studies/fields.hpp"

namespace klang::validate::detail {

/// A square of side 2 half_m in the plane y = 0 around the origin, n_pixels x n_pixels, filled in parallel. The
/// factory makes one function a range of rows, which may keep tables of its own.
using PointValue = std::function<double(const Eigen::Vector3d& x_m)>;
SliceField pressure_slice(double half_m, int n_pixels, const std::function<PointValue()>& factory);

/// |far field| in every direction: theta in steps of 3 degrees from the z axis, phi likewise.
BalloonField balloon(const std::function<double(const Eigen::Vector3d& direction)>& magnitude);

}  // namespace klang::validate::detail
