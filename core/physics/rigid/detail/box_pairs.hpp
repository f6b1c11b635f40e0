#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

namespace klang::rigid::detail {

/// A box along the world's axes about a part of a body.
struct PartBox {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  int body = 0;
  bool moves = true;
};

inline bool meet(const PartBox& a, const PartBox& b) {
  for (int i = 0; i < 3; ++i)
    if (a.low[i] > b.high[i] || b.low[i] > a.high[i]) return false;
  return true;
}

/// Boxes that overlap, of which one moves and which are not of one body: sorted along an axis and swept. They are found in any order.
class BoxPairs {
 public:
  /// Of each pair the one that comes first in the list is first; sorted.
  const std::vector<std::array<int, 2>>& find(const std::vector<PartBox>& boxes);
  const std::vector<std::array<int, 2>>& last() const { return pairs_; }

 private:
  std::vector<int> order_;  // by the lower end: nearly that of the last call
  std::vector<std::array<int, 2>> pairs_;
};

}  // namespace klang::rigid::detail
