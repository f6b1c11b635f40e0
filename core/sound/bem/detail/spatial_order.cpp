#include "core/sound/bem/detail/spatial_order.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace klang::acoustics::detail {

using Eigen::Vector3d;

std::vector<int> spatial_order(const Eigen::Matrix3Xd& points) {
  const Vector3d low = points.rowwise().minCoeff();
  const double size = std::max((points.rowwise().maxCoeff() - low).maxCoeff(), 1e-300);
  std::vector<std::uint64_t> key(static_cast<std::size_t>(points.cols()), 0);
  for (Eigen::Index v = 0; v < points.cols(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::uint64_t>((points(axis, v) - low[axis]) / size * 1023.0);
      for (int bit = 0; bit < 10; ++bit) key[static_cast<std::size_t>(v)] |= (cell >> bit & 1) << (3 * bit + axis);
    }
  std::vector<int> order(key.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key[a] < key[b]; });
  return order;
}

}  // namespace klang::acoustics::detail
