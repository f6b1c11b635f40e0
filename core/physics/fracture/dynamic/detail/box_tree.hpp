#pragma once
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace klang::fracture::detail {

/// Boxes in a tree that is halved along the longest side of their middles.
class BoxTree {
 public:
  /// @param boxes  number of each with its box
  explicit BoxTree(std::vector<std::pair<int, Eigen::AlignedBox3d>> boxes);
  /// All pairs (lower number first) of boxes that intersect, ascending.
  std::vector<std::array<int, 2>> pairs() const;
  /// All pairs (one of these, one of those) that intersect, ascending.
  std::vector<std::array<int, 2>> pairs_with(const BoxTree& others) const;

 private:
  struct Knot {
    Eigen::AlignedBox3d box;
    int left = -1, right = -1;  ///< knots; -1: a leaf
    int first = 0, last = 0;    ///< its boxes
  };
  int build(int first, int last);
  void within(int knot, std::vector<std::array<int, 2>>& found) const;
  void between(int a, int b, std::vector<std::array<int, 2>>& found) const;
  void across(const BoxTree& others, int a, int b, std::vector<std::array<int, 2>>& found) const;
  void add(int i, int j, std::vector<std::array<int, 2>>& found) const;

  std::vector<std::pair<int, Eigen::AlignedBox3d>> boxes_;
  std::vector<Knot> knots_;
};

}  // namespace klang::fracture::detail
