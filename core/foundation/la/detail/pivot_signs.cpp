#include "core/foundation/la/detail/pivot_signs.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

#include "core/foundation/base/huge_pages.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la::detail {
namespace {

constexpr int kPanel = 64;  // columns eliminated together

// L D L^T of the n x n block at `a`, in place: D on the diagonal, L below. False at a pivot of zero.
bool eliminate_block(int n, double* a, int lda) {
  for (int j = 0; j < n; ++j) {
    double* column = a + static_cast<std::size_t>(j) * lda;
    const double pivot = column[j];
    if (!(std::abs(pivot) > 0) || !std::isfinite(pivot)) return false;
    for (int c = j + 1; c < n; ++c) {
      const double l = column[c] / pivot;
      double* target = a + static_cast<std::size_t>(c) * lda;
      for (int i = c; i < n; ++i) target[i] -= l * column[i];
    }
    for (int i = j + 1; i < n; ++i) column[i] /= pivot;
  }
  return true;
}

// Eliminates supernodes one after another; each thread has one of these.
class Elimination {
 public:
  Elimination(const FrontTree& tree, const double* value, std::vector<HugeValues>& update)
      : tree_(tree), value_(value), update_(update), local_(static_cast<std::size_t>(tree.n)) {
    size.assign(static_cast<std::size_t>(tree.n), 0.0);
  }

  // False at a pivot of zero.
  bool eliminate(int s) {
    const int n = tree_.n_rows(s), m = tree_.n_columns(s), below = n - m;
    HugeValues columns = huge_zeros(static_cast<std::size_t>(n) * m);
    update_[s] = huge_zeros(static_cast<std::size_t>(below) * below);
    for (int i = 0; i < n; ++i) local_[tree_.rows(s)[i]] = i;
    const FrontTree::Front front{local_.data(), columns.get(), update_[s].get()};
    tree_.add_entries(s, value_, front);
    for (const int child : tree_.children[s]) {
      tree_.add_update(child, update_[child].get(), s, front);
      update_[child].reset();
    }
    scaled_.resize(std::max(scaled_.size(), static_cast<std::size_t>(n) * m));
    for (int first = 0; first < m; first += kPanel) {
      const int width = std::min(kPanel, m - first), rest = n - first - width, inside = m - first - width;
      double* block = columns.get() + static_cast<std::size_t>(first) * n + first;
      if (!eliminate_block(width, block, n)) return false;
      double* panel = block + width;
      const double one = 1.0;
      if (rest > 0) dtrsm_("R", "L", "T", "U", &rest, &width, &one, block, &n, panel, &n);
      double* scaled = scaled_.data() + static_cast<std::size_t>(first) * n + first + width;
      book(tree_.rows(s) + first, width, {block, scaled, n, rest});
      subtract({rest, inside, width, {panel, n}, {scaled, n}, panel + static_cast<std::size_t>(width) * n, n});
    }
    subtract({below, below, m, {columns.get() + m, n}, {scaled_.data() + m, n}, update_[s].get(), below});
    return true;
  }

  std::vector<double> size;  // sum_j l_ij^2 |d_j| of each row
  long n_negative = 0;

 private:
  struct Panel {
    double* block;   // eliminated block, and L D below it
    double* scaled;  // takes L D
    int stride, n_below;
  };

  // Counts the panel's pivots and turns what stands below them from L D into L; `scaled` keeps L D.
  void book(const int* row, int width, const Panel& panel) {
    for (int j = 0; j < width; ++j) {
      double* column = panel.block + static_cast<std::size_t>(j) * panel.stride;
      const double pivot = column[j], magnitude = std::abs(pivot);
      if (pivot < 0) ++n_negative;
      size[row[j]] += magnitude;
      for (int i = j + 1; i < width; ++i) size[row[i]] += column[i] * column[i] * magnitude;
      double* l = column + width;
      double* ld = panel.scaled + static_cast<std::size_t>(j) * panel.stride;
      for (int i = 0; i < panel.n_below; ++i) {
        ld[i] = l[i];
        l[i] /= pivot;
        size[row[width + i]] += std::abs(l[i] * ld[i]);
      }
    }
  }

  const FrontTree& tree_;
  const double* value_;
  std::vector<HugeValues>& update_;  // what a front leaves to its parent: its lower triangle, by columns
  std::vector<int> local_;           // of a row in the front at hand
  std::vector<double> scaled_;
};

}  // namespace

std::optional<PivotSigns> pivot_signs(const FrontTree& tree, const SparseMatrix& lower) try {
  std::vector<HugeValues> update(static_cast<std::size_t>(tree.n_supernodes));
  std::vector<std::unique_ptr<Elimination>> job(static_cast<std::size_t>(tree.n_jobs()));
  const BlasThreads one_each(1);  // fronts are shared out here
  const bool done = tree.run([&](int k, int s) {
    if (!job[k]) job[k] = std::make_unique<Elimination>(tree, lower.valuePtr(), update);
    return job[k]->eliminate(s);
  });
  if (!done) return std::nullopt;
  PivotSigns result;
  double grown = 0, diagonal = 0;
  for (const auto& one : job) {
    if (!one) continue;
    result.n_negative += one->n_negative;
    grown += std::accumulate(one->size.begin(), one->size.end(), 0.0);
  }
  for (Eigen::Index j = 0; j < lower.cols(); ++j) diagonal += std::abs(lower.coeff(j, j));
  result.growth = grown / diagonal;
  return result;
} catch (const std::bad_alloc&) {
  return std::nullopt;
}

}  // namespace klang::la::detail
