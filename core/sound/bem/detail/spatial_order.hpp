#pragma once
#include <Eigen/Core>
#include <vector>

namespace klang::acoustics::detail {

/// Points in the order of a space-filling curve (Morton): neighbours in space are neighbours in the matrix.
std::vector<int> spatial_order(const Eigen::Matrix3Xd& points);

}  // namespace klang::acoustics::detail
