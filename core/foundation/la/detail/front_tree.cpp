#include "core/foundation/la/detail/front_tree.hpp"

#include <cholmod.h>

#include <algorithm>
#include <atomic>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la::detail {
namespace {

constexpr std::size_t kSubtrees = 16;  // eliminated side by side
constexpr int kStripe =
    256;  // columns of a symmetric product computed together; what lies above its diagonal is wasted
constexpr int kNarrowStripe = 64;
constexpr double kParallelFrom = 4e6;  // multiplications

}  // namespace

FrontTree::FrontTree(const cholmod_factor_struct& factor, const SparseMatrix& lower)
    : n(static_cast<int>(factor.n)),
      n_supernodes(static_cast<int>(factor.nsuper)),
      begin(static_cast<const int*>(factor.super)),
      row_begin(static_cast<const int*>(factor.pi)),
      row(static_cast<const int*>(factor.s)),
      value_begin(static_cast<const int*>(factor.px)),
      children(static_cast<std::size_t>(n_supernodes)) {
  std::vector<int> owner(static_cast<std::size_t>(n));
  for (int s = 0; s < n_supernodes; ++s) std::fill(owner.begin() + begin[s], owner.begin() + begin[s + 1], s);
  for (int s = 0; s < n_supernodes; ++s)
    (n_rows(s) > n_columns(s) ? children[owner[rows(s)[n_columns(s)]]] : roots_).push_back(s);
  cut();
  map_entries(static_cast<const int*>(factor.Perm), lower);
}

void FrontTree::map_entries(const int* order, const SparseMatrix& lower) {
  std::vector<int> place(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) place[order[k]] = k;
  const auto each = [&](const auto& use) {
    for (int j = 0; j < n; ++j)
      for (int k = lower.outerIndexPtr()[j]; k < lower.outerIndexPtr()[j + 1]; ++k) {
        const auto [column, below] = std::minmax(place[j], place[lower.innerIndexPtr()[k]]);
        use(column, below, k);
      }
  };
  entry_begin_.assign(static_cast<std::size_t>(n) + 1, 0);
  each([&](int column, int, int) { ++entry_begin_[column + 1]; });
  for (int j = 0; j < n; ++j) entry_begin_[j + 1] += entry_begin_[j];
  std::vector<int> next(entry_begin_.begin(), entry_begin_.end() - 1);
  entry_row_.resize(static_cast<std::size_t>(lower.nonZeros()));
  entry_source_.resize(entry_row_.size());
  each([&](int column, int below, int k) {
    entry_row_[next[column]] = below;
    entry_source_[next[column]++] = k;
  });
}

// Supernodes are postordered: a subtree is the range that ends with its root. The heaviest is cut at its root until there are enough.
void FrontTree::cut() {
  std::vector<double> work(static_cast<std::size_t>(n_supernodes));
  for (int s = 0; s < n_supernodes; ++s) {
    work[s] = static_cast<double>(n_columns(s)) * n_rows(s) * n_rows(s);
    for (const int child : children[s]) work[s] += work[child];
  }
  const auto lighter = [&](int a, int b) { return work[a] < work[b]; };
  subtrees = roots_;
  std::make_heap(subtrees.begin(), subtrees.end(), lighter);
  while (!subtrees.empty() && subtrees.size() < kSubtrees && !children[subtrees.front()].empty()) {
    const int root = subtrees.front();
    std::pop_heap(subtrees.begin(), subtrees.end(), lighter);
    subtrees.pop_back();
    for (const int child : children[root]) {
      subtrees.push_back(child);
      std::push_heap(subtrees.begin(), subtrees.end(), lighter);
    }
  }
  std::sort(subtrees.begin(), subtrees.end());
}

int FrontTree::first_of_subtree(int root) const {
  while (!children[root].empty()) root = children[root].front();
  return root;
}

bool FrontTree::run(const std::function<bool(int, int)>& eliminate) const {
  std::atomic<bool> failed = false;
  std::vector<char> inside(static_cast<std::size_t>(n_supernodes), 0);
  for (const int root : subtrees) std::fill(inside.begin() + first_of_subtree(root), inside.begin() + root + 1, 1);
  // Not for_each_job, which sets BLAS' threads for the whole process: another elimination may be at work beside this.
  parallel_for(subtrees.size(), 1, [&](std::size_t i, std::size_t) {
    for (int s = first_of_subtree(subtrees[i]); s <= subtrees[i] && !failed; ++s)
      if (!eliminate(static_cast<int>(i), s)) failed = true;
  });
  const int last_job = n_jobs() - 1;
  for (int s = 0; s < n_supernodes && !failed; ++s)
    if (!inside[s] && !eliminate(last_job, s)) failed = true;
  return !failed;
}

void FrontTree::add_entries(int s, const double* value, const Front& front) const {
  const int n_front = n_rows(s);
  for (int j = 0; j < n_columns(s); ++j) {
    double* column = front.columns + static_cast<std::size_t>(j) * n_front;
    for (int k = entry_begin_[begin[s] + j]; k < entry_begin_[begin[s] + j + 1]; ++k)
      column[front.local[entry_row_[k]]] += value[entry_source_[k]];
  }
}

void FrontTree::add_update(int child, const double* update, int parent, const Front& front) const {
  const int n_front = n_rows(parent), m = n_columns(parent), n_below = n_front - m;
  const int* child_rows = rows(child) + n_columns(child);
  const int k = n_rows(child) - n_columns(child);
  std::vector<int> to(static_cast<std::size_t>(k));
  for (int i = 0; i < k; ++i) to[i] = front.local[child_rows[i]];
  for (int j = 0; j < k; ++j) {
    const double* from = update + static_cast<std::size_t>(j) * k;
    const bool eliminated = to[j] < m;
    double* column = eliminated ? front.columns + static_cast<std::size_t>(to[j]) * n_front
                                : front.below + static_cast<std::size_t>(to[j] - m) * n_below;
    const int shift = eliminated ? 0 : m;
    for (int i = j; i < k; ++i) column[to[i] - shift] += from[i];
  }
}

void subtract(const LowerProduct& product) {
  const int n_columns = product.n_columns;
  if (n_columns <= 0 || product.depth <= 0) return;
  const int width = n_columns <= kStripe ? kNarrowStripe : kStripe;
  const auto stripe = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      const int j = static_cast<int>(k) * width;
      gemm('N', 'T', product.n_rows - j, std::min(width, n_columns - j), product.depth, -1.0, product.a.at + j,
           product.a.stride, product.b.at + j, product.b.stride, 1.0,
           product.c + static_cast<std::size_t>(j) * product.c_stride + j, product.c_stride);
    }
  };
  const auto n_stripes = static_cast<std::size_t>((n_columns + width - 1) / width);
  if (static_cast<double>(product.n_rows) * n_columns * product.depth >= kParallelFrom)
    parallel_for(n_stripes, 1, stripe);
  else
    stripe(0, n_stripes);
}

}  // namespace klang::la::detail
