#include "core/foundation/la/detail/tree_cholesky.hpp"

#include <algorithm>
#include <memory>

#include "core/foundation/base/huge_pages.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la::detail {
namespace {

constexpr int kCholeskyPanel = 128;  // columns eliminated together
constexpr int kRowsOfJob = 512;
constexpr double kDivideTogetherFrom = 4e6;  // multiplications

// X L^T = B for the rows below a diagonal block.
void divide_below(int n_below, int width, const double* block, double* below, int stride) {
  const auto rows = [&](int from, int to) {
    const int n = to - from;
    const double one = 1.0;
    dtrsm_("R", "L", "T", "N", &n, &width, &one, block, &stride, below + from, &stride);
  };
  if (static_cast<double>(n_below) * width * width < kDivideTogetherFrom) {
    if (n_below > 0) rows(0, n_below);
    return;
  }
  parallel_for(static_cast<std::size_t>((n_below + kRowsOfJob - 1) / kRowsOfJob), 1,
               [&](std::size_t from, std::size_t to) {
                 rows(static_cast<int>(from) * kRowsOfJob, std::min(static_cast<int>(to) * kRowsOfJob, n_below));
               });
}

class CholeskyElimination {
 public:
  CholeskyElimination(const FrontTree& tree, const double* value, std::vector<HugeValues>& update)
      : tree_(tree), value_(value), update_(update), local_(static_cast<std::size_t>(tree.n)) {}

  // False at a pivot that is not positive.
  bool eliminate(int s, double* columns) {
    const int n = tree_.n_rows(s), m = tree_.n_columns(s), below = n - m;
    std::fill(columns, columns + static_cast<std::size_t>(n) * m, 0.0);
    update_[s] = huge_zeros(static_cast<std::size_t>(below) * below);
    for (int i = 0; i < n; ++i) local_[tree_.rows(s)[i]] = i;
    const FrontTree::Front front{local_.data(), columns, update_[s].get()};
    tree_.add_entries(s, value_, front);
    for (const int child : tree_.children[s]) {
      tree_.add_update(child, update_[child].get(), s, front);
      update_[child].reset();
    }
    for (int first = 0; first < m; first += kCholeskyPanel) {
      const int width = std::min(kCholeskyPanel, m - first), rest = n - first - width;
      double* block = columns + static_cast<std::size_t>(first) * n + first;
      int info = 0;
      dpotrf_("L", &width, block, &n, &info);
      if (info != 0) return false;
      double* panel = block + width;
      divide_below(rest, width, block, panel, n);
      subtract(
          {rest, m - first - width, width, {panel, n}, {panel, n}, panel + static_cast<std::size_t>(width) * n, n});
    }
    subtract({below, below, m, {columns + m, n}, {columns + m, n}, update_[s].get(), below});
    return true;
  }

 private:
  const FrontTree& tree_;
  const double* value_;
  std::vector<HugeValues>& update_;  // what a front leaves to its parent: its lower triangle, by columns
  std::vector<int> local_;           // of a row in the front at hand
};

}  // namespace

bool tree_cholesky(const FrontTree& tree, const double* value, double* l) {
  std::vector<HugeValues> update(static_cast<std::size_t>(tree.n_supernodes));
  std::vector<std::unique_ptr<CholeskyElimination>> job(static_cast<std::size_t>(tree.n_jobs()));
  return tree.run([&](int k, int s) {
    if (!job[k]) job[k] = std::make_unique<CholeskyElimination>(tree, value, update);
    return job[k]->eliminate(s, l + tree.value_begin[s]);
  });
}

}  // namespace klang::la::detail
