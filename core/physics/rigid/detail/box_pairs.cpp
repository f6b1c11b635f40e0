#include "core/physics/rigid/detail/box_pairs.hpp"

#include <algorithm>
#include <numeric>

namespace klang::rigid::detail {

const std::vector<std::array<int, 2>>& BoxPairs::find(const std::vector<PartBox>& boxes) {
  pairs_.clear();
  if (order_.size() != boxes.size()) {
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0);
  }
  // Along the axis on which the boxes lie farthest apart.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  for (const PartBox& box : boxes) {
    const Eigen::Vector3d middle = 0.5 * (box.low + box.high);
    sum += middle;
    squares += middle.cwiseAbs2();
  }
  Eigen::Index axis = 0;
  if (!boxes.empty()) (squares - sum.cwiseAbs2() / static_cast<double>(boxes.size())).maxCoeff(&axis);
  const auto low = [&](int i) { return boxes[static_cast<std::size_t>(i)].low[axis]; };
  for (std::size_t i = 1; i < order_.size(); ++i) {  // nearly sorted
    const int moved = order_[i];
    std::size_t at = i;
    for (; at > 0 && low(order_[at - 1]) > low(moved); --at) order_[at] = order_[at - 1];
    order_[at] = moved;
  }
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const PartBox& one = boxes[static_cast<std::size_t>(order_[i])];
    for (std::size_t k = i + 1; k < order_.size() && low(order_[k]) <= one.high[axis]; ++k) {
      const PartBox& other = boxes[static_cast<std::size_t>(order_[k])];
      if (one.body == other.body || !(one.moves || other.moves)) continue;
      if (meet(one, other)) pairs_.push_back({std::min(order_[i], order_[k]), std::max(order_[i], order_[k])});
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
  return pairs_;
}

}  // namespace klang::rigid::detail
