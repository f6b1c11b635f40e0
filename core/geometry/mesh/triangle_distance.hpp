#pragma once
#include <Eigen/Core>
#include <array>

namespace klang::mesh {

/// Squared distance of a point from a triangle. Source: Ericson, Real-Time Collision Detection (2005), section 5.1.5.
double distance_sq(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& t);

}  // namespace klang::mesh
