#include "core/physics/fracture/dynamic/detail/box_tree.hpp"

#include <algorithm>

#include "core/physics/fracture/dynamic/detail/at.hpp"

namespace klang::fracture::detail {
namespace {
constexpr int kLeaf = 6;
}  // namespace

BoxTree::BoxTree(std::vector<std::pair<int, Eigen::AlignedBox3d>> boxes) : boxes_(std::move(boxes)) {
  if (!boxes_.empty()) build(0, static_cast<int>(boxes_.size()));
}

int BoxTree::build(int first, int last) {
  const int self = static_cast<int>(knots_.size());
  knots_.push_back({{}, -1, -1, first, last});
  Eigen::AlignedBox3d all, middles;
  for (int i = first; i < last; ++i) {
    all.extend(boxes_[at(i)].second);
    middles.extend(boxes_[at(i)].second.center());
  }
  knots_[at(self)].box = all;
  if (last - first <= kLeaf) return self;
  Eigen::Index axis = 0;
  middles.sizes().maxCoeff(&axis);
  const int half = first + (last - first) / 2;
  const auto before = [axis](const auto& a, const auto& b) {
    const double x = a.second.center()[axis], y = b.second.center()[axis];
    return x < y || (x == y && a.first < b.first);
  };
  std::nth_element(boxes_.begin() + first, boxes_.begin() + half, boxes_.begin() + last, before);
  const int left = build(first, half), right = build(half, last);
  knots_[at(self)].left = left;
  knots_[at(self)].right = right;
  return self;
}

void BoxTree::add(int i, int j, std::vector<std::array<int, 2>>& found) const {
  if (!boxes_[at(i)].second.intersects(boxes_[at(j)].second)) return;
  const int a = boxes_[at(i)].first, b = boxes_[at(j)].first;
  found.push_back({std::min(a, b), std::max(a, b)});
}

void BoxTree::within(int knot, std::vector<std::array<int, 2>>& found) const {
  const Knot& k = knots_[at(knot)];
  if (k.left < 0) {
    for (int i = k.first; i < k.last; ++i)
      for (int j = k.first; j < i; ++j) add(i, j, found);
    return;
  }
  within(k.left, found);
  within(k.right, found);
  between(k.left, k.right, found);
}

void BoxTree::between(int a, int b, std::vector<std::array<int, 2>>& found) const {
  const Knot &k = knots_[at(a)], &m = knots_[at(b)];
  if (!k.box.intersects(m.box)) return;
  if (k.left < 0 && m.left < 0) {
    for (int i = k.first; i < k.last; ++i)
      for (int j = m.first; j < m.last; ++j) add(i, j, found);
  } else if (m.left < 0 || (k.left >= 0 && k.last - k.first >= m.last - m.first)) {
    between(k.left, b, found);
    between(k.right, b, found);
  } else {
    between(a, m.left, found);
    between(a, m.right, found);
  }
}

void BoxTree::across(const BoxTree& others, int a, int b, std::vector<std::array<int, 2>>& found) const {
  const Knot &k = knots_[at(a)], &m = others.knots_[at(b)];
  if (!k.box.intersects(m.box)) return;
  if (k.left < 0 && m.left < 0) {
    for (int i = k.first; i < k.last; ++i)
      for (int j = m.first; j < m.last; ++j)
        if (boxes_[at(i)].second.intersects(others.boxes_[at(j)].second))
          found.push_back({boxes_[at(i)].first, others.boxes_[at(j)].first});
  } else if (m.left < 0 || (k.left >= 0 && k.last - k.first >= m.last - m.first)) {
    across(others, k.left, b, found);
    across(others, k.right, b, found);
  } else {
    across(others, a, m.left, found);
    across(others, a, m.right, found);
  }
}

std::vector<std::array<int, 2>> BoxTree::pairs_with(const BoxTree& others) const {
  std::vector<std::array<int, 2>> found;
  if (!knots_.empty() && !others.knots_.empty()) across(others, 0, 0, found);
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::array<int, 2>> BoxTree::pairs() const {
  std::vector<std::array<int, 2>> found;
  if (!knots_.empty()) within(0, found);
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace klang::fracture::detail
