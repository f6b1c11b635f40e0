#pragma once
#include <array>

namespace klang {

/// 14 points on the reference tetrahedron, exact to degree 5, all weights positive (Walkington 2000).
struct TetRule {
  static constexpr int kPoints = 14;
  std::array<std::array<double, 4>, kPoints> point{};  ///< barycentric coordinates
  std::array<double, kPoints> weight{};                ///< sums to the reference volume 1/6
};
TetRule make_tet_rule();

}  // namespace klang
