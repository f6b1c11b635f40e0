#include "core/foundation/la/supernodal_solve.hpp"

#include <cholmod.h>

#include <algorithm>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/parallel.hpp"

// Compiled for several instruction sets and picked at start-up. Sanitizers run before the resolver may, so they get
// the plain version.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define KLANG_CLONES __attribute__((target_clones("avx512f", "avx2,fma", "default")))
#else
#define KLANG_CLONES
#endif

namespace klang::la {
namespace {

constexpr int kWidth = SupernodalSolve::kWidth;
constexpr int kWantedSubtrees = 16;
using Row = double __attribute__((vector_size(kWidth * sizeof(double)), aligned(alignof(double)), may_alias));

// x_i -= sum_j l_ij x_j for the rows below a supernode's diagonal block, four columns at a time. place[i]: where row i
// of x begins.
KLANG_CLONES void subtract_below(const double* l, std::size_t stride, int n_below, int n_columns, const double* top,
                                 double* const* place) {
  int j = 0;
  for (; j + 4 <= n_columns; j += 4) {
    const Row a = *reinterpret_cast<const Row*>(top + kWidth * j);
    const Row b = *reinterpret_cast<const Row*>(top + kWidth * (j + 1));
    const Row c = *reinterpret_cast<const Row*>(top + kWidth * (j + 2));
    const Row d = *reinterpret_cast<const Row*>(top + kWidth * (j + 3));
    const double* la = l + j * stride;
    const double *lb = la + stride, *lc = lb + stride, *ld = lc + stride;
    for (int i = 0; i < n_below; ++i) {
      Row& x = *reinterpret_cast<Row*>(place[i]);
      x -= (la[i] * a + lb[i] * b) + (lc[i] * c + ld[i] * d);
    }
  }
  for (; j < n_columns; ++j) {
    const Row a = *reinterpret_cast<const Row*>(top + kWidth * j);
    const double* la = l + j * stride;
    for (int i = 0; i < n_below; ++i) *reinterpret_cast<Row*>(place[i]) -= la[i] * a;
  }
}

// x_j -= sum_i l_ij x_i, the transpose.
KLANG_CLONES void subtract_above(const double* l, std::size_t stride, int n_below, int n_columns, double* top,
                                 const double* const* place) {
  int j = 0;
  for (; j + 4 <= n_columns; j += 4) {
    Row a{}, b{}, c{}, d{};
    const double* la = l + j * stride;
    const double *lb = la + stride, *lc = lb + stride, *ld = lc + stride;
    for (int i = 0; i < n_below; ++i) {
      const Row x = *reinterpret_cast<const Row*>(place[i]);
      a += la[i] * x;
      b += lb[i] * x;
      c += lc[i] * x;
      d += ld[i] * x;
    }
    *reinterpret_cast<Row*>(top + kWidth * j) -= a;
    *reinterpret_cast<Row*>(top + kWidth * (j + 1)) -= b;
    *reinterpret_cast<Row*>(top + kWidth * (j + 2)) -= c;
    *reinterpret_cast<Row*>(top + kWidth * (j + 3)) -= d;
  }
  for (; j < n_columns; ++j) {
    Row a{};
    const double* la = l + j * stride;
    for (int i = 0; i < n_below; ++i) a += la[i] * *reinterpret_cast<const Row*>(place[i]);
    *reinterpret_cast<Row*>(top + kWidth * j) -= a;
  }
}

// The diagonal block: x := L^-1 x and x := L^-T x, kBlock columns at a time so that the rest is done by the above.
constexpr int kBlock = 16;

KLANG_CLONES void solve_lower(const double* l, std::size_t stride, int n, double* x) {
  for (int j = 0; j < n; ++j) {
    Row& row = *reinterpret_cast<Row*>(x + kWidth * j);
    row /= l[j * stride + j];
    for (int i = j + 1; i < n; ++i) *reinterpret_cast<Row*>(x + kWidth * i) -= l[j * stride + i] * row;
  }
}

KLANG_CLONES void solve_upper(const double* l, std::size_t stride, int n, double* x) {
  for (int j = n - 1; j >= 0; --j) {
    Row row = *reinterpret_cast<const Row*>(x + kWidth * j);
    for (int i = j + 1; i < n; ++i) row -= l[j * stride + i] * *reinterpret_cast<const Row*>(x + kWidth * i);
    *reinterpret_cast<Row*>(x + kWidth * j) = row / l[j * stride + j];
  }
}

}  // namespace

SupernodalSolve::SupernodalSolve(const cholmod_factor_struct& factor)
    : n_(static_cast<int>(factor.n)),
      n_supernodes_(static_cast<int>(factor.nsuper)),
      begin_(static_cast<const int*>(factor.super)),
      row_begin_(static_cast<const int*>(factor.pi)),
      value_begin_(static_cast<const int*>(factor.px)),
      row_(static_cast<const int*>(factor.s)),
      permutation_(static_cast<const int*>(factor.Perm)),
      value_(static_cast<const double*>(factor.x)) {
  KLANG_CHECK(factor.is_super != 0 && factor.is_ll != 0 && factor.itype == CHOLMOD_INT, "a supernodal LL^T factor");
  cut_tree();
}

void SupernodalSolve::cut_tree() {
  std::vector<int> owner(n_);
  for (int s = 0; s < n_supernodes_; ++s) std::fill(owner.begin() + begin_[s], owner.begin() + begin_[s + 1], s);
  std::vector<int> parent(n_supernodes_, -1), first(n_supernodes_);
  std::vector<double> work(n_supernodes_);
  for (int s = 0; s < n_supernodes_; ++s) {
    const int n_columns = begin_[s + 1] - begin_[s], n_rows = row_begin_[s + 1] - row_begin_[s];
    if (n_rows > n_columns) parent[s] = owner[row_[row_begin_[s] + n_columns]];
    work[s] = static_cast<double>(n_columns) * n_rows;
    first[s] = s;
  }
  std::vector<int> roots;
  std::vector<std::vector<int>> children(n_supernodes_);
  double total = 0;
  for (int s = 0; s < n_supernodes_; ++s) {  // children come before parents
    total += work[s];
    if (parent[s] < 0) {
      roots.push_back(s);
      continue;
    }
    work[parent[s]] += work[s];
    first[parent[s]] = std::min(first[parent[s]], first[s]);
    children[parent[s]].push_back(s);
  }
  // The heaviest subtree is opened until all are light enough to be shared out.
  std::vector<int> subtree = roots;
  while (!subtree.empty() && static_cast<int>(subtree.size()) < 8 * kWantedSubtrees) {
    const auto heaviest =
        std::max_element(subtree.begin(), subtree.end(), [&](int a, int b) { return work[a] < work[b]; });
    if (work[*heaviest] <= total / kWantedSubtrees) break;
    const int opened = *heaviest;
    subtree.erase(heaviest);
    top_.push_back(opened);
    subtree.insert(subtree.end(), children[opened].begin(), children[opened].end());
  }
  std::sort(subtree.begin(), subtree.end());
  std::sort(top_.begin(), top_.end());
  for (const int root : subtree) subtrees_.push_back({first[root], root + 1});
  top_place_.assign(n_, -1);
  for (const int s : top_)
    for (int column = begin_[s]; column < begin_[s + 1]; ++column) top_place_[column] = n_top_rows_++;
}

// Supernodes above the subtrees are one after the other, and in bodies of three dimensions they hold half of the factor: what lies
// below their diagonal is shared out by rows (forward) or columns (backward), so that the bits do not depend on the threads.
constexpr int kManyRows = 1024, kPanel = 4 * kBlock, kRowsOfJob = 256, kColumnsOfJob = kBlock;

void SupernodalSolve::forward_shared(int s, double* x) const {
  const int n_columns = begin_[s + 1] - begin_[s], n_rows = row_begin_[s + 1] - row_begin_[s];
  const double* l = value_ + value_begin_[s];
  const auto stride = static_cast<std::size_t>(n_rows);
  std::vector<double*> place(stride);
  for (int i = 0; i < n_rows; ++i) place[i] = x + static_cast<std::size_t>(kWidth) * row_[row_begin_[s] + i];
  const auto top = [&](int j) { return place[0] + static_cast<std::ptrdiff_t>(kWidth) * j; };
  for (int first = 0; first < n_columns; first += kPanel) {
    const int last = std::min(first + kPanel, n_columns);
    for (int j = first; j < last; j += kBlock) {
      const int n = std::min(kBlock, last - j);
      const double* diagonal = l + stride * j + j;
      solve_lower(diagonal, stride, n, top(j));
      subtract_below(diagonal + n, stride, last - j - n, n, top(j), place.data() + j + n);
    }
    const int n_jobs = (n_rows - last + kRowsOfJob - 1) / kRowsOfJob;
    parallel_for(static_cast<std::size_t>(n_jobs), 1, [&](std::size_t begin, std::size_t end) {
      const int from = last + static_cast<int>(begin) * kRowsOfJob;
      const int to = std::min(last + static_cast<int>(end) * kRowsOfJob, n_rows);
      for (int j = first; j < last; j += kBlock)
        subtract_below(l + stride * j + from, stride, to - from, std::min(kBlock, last - j), top(j),
                       place.data() + from);
    });
  }
}

void SupernodalSolve::backward_shared(int s, double* x) const {
  const int n_columns = begin_[s + 1] - begin_[s], n_rows = row_begin_[s + 1] - row_begin_[s];
  const double* l = value_ + value_begin_[s];
  const auto stride = static_cast<std::size_t>(n_rows);
  std::vector<const double*> place(stride);
  for (int i = 0; i < n_rows; ++i) place[i] = x + static_cast<std::size_t>(kWidth) * row_[row_begin_[s] + i];
  const auto top = [&](int j) { return x + static_cast<std::size_t>(kWidth) * (begin_[s] + j); };
  for (int first = (n_columns - 1) / kPanel * kPanel; first >= 0; first -= kPanel) {
    const int last = std::min(first + kPanel, n_columns);
    const int n_jobs = (last - first + kColumnsOfJob - 1) / kColumnsOfJob;
    parallel_for(static_cast<std::size_t>(n_jobs), 1, [&](std::size_t begin, std::size_t end) {
      for (int j = first + static_cast<int>(begin) * kColumnsOfJob;
           j < std::min(first + static_cast<int>(end) * kColumnsOfJob, last); j += kColumnsOfJob)
        subtract_above(l + stride * j + last, stride, n_rows - last, std::min(kColumnsOfJob, last - j), top(j),
                       place.data() + last);
    });
    for (int j = first + (last - first - 1) / kBlock * kBlock; j >= first; j -= kBlock) {
      const int n = std::min(kBlock, last - j);
      const double* diagonal = l + stride * j + j;
      subtract_above(diagonal + n, stride, last - j - n, n, top(j), place.data() + j + n);
      solve_upper(diagonal, stride, n, top(j));
    }
  }
}

void SupernodalSolve::forward(int s, int last_inside, double* x, double* outside) const {
  const int n_columns = begin_[s + 1] - begin_[s], n_rows = row_begin_[s + 1] - row_begin_[s];
  const double* l = value_ + value_begin_[s];
  const auto stride = static_cast<std::size_t>(n_rows);
  thread_local std::vector<double*> place;
  place.resize(stride);
  for (int i = 0; i < n_rows; ++i) {
    const int row = row_[row_begin_[s] + i];
    place[i] = row < last_inside ? x + static_cast<std::size_t>(kWidth) * row
                                 : outside + static_cast<std::size_t>(kWidth) * top_place_[row];
  }
  double* own = place[0];  // the supernode's own rows are consecutive
  for (int j = 0; j < n_columns; j += kBlock) {
    const int n = std::min(kBlock, n_columns - j);
    const double* diagonal = l + stride * j + j;
    solve_lower(diagonal, stride, n, own + static_cast<std::ptrdiff_t>(kWidth) * j);
    subtract_below(diagonal + n, stride, n_rows - j - n, n, own + static_cast<std::ptrdiff_t>(kWidth) * j,
                   place.data() + j + n);
  }
}

void SupernodalSolve::backward(int s, double* x) const {
  const int n_columns = begin_[s + 1] - begin_[s], n_rows = row_begin_[s + 1] - row_begin_[s];
  const double* l = value_ + value_begin_[s];
  const auto stride = static_cast<std::size_t>(n_rows);
  thread_local std::vector<const double*> place;
  place.resize(stride);
  for (int i = 0; i < n_rows; ++i) place[i] = x + static_cast<std::size_t>(kWidth) * row_[row_begin_[s] + i];
  double* own = x + static_cast<std::size_t>(kWidth) * begin_[s];
  for (int j = (n_columns - 1) / kBlock * kBlock; j >= 0; j -= kBlock) {
    const int n = std::min(kBlock, n_columns - j);
    const double* diagonal = l + stride * j + j;
    subtract_above(diagonal + n, stride, n_rows - j - n, n, own + static_cast<std::ptrdiff_t>(kWidth) * j,
                   place.data() + j + n);
    solve_upper(diagonal, stride, n, own + static_cast<std::ptrdiff_t>(kWidth) * j);
  }
}

void SupernodalSolve::solve(const double* b, double* x, int n_columns) const {
  KLANG_CHECK(n_columns >= 1 && n_columns <= kWidth, "1 to 8 columns");
  const auto n = static_cast<std::size_t>(n_);
  std::vector<double> rows(n * kWidth, 0.0);
  constexpr std::size_t kGrain = 8192;
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (int c = 0; c < n_columns; ++c) {
      for (std::size_t i = begin; i < end; ++i) rows[i * kWidth + c] = b[c * n + permutation_[i]];
    }
  });
  const auto has_many_rows = [&](int s) { return row_begin_[s + 1] - row_begin_[s] >= kManyRows; };
  const std::size_t n_outside = static_cast<std::size_t>(n_top_rows_) * kWidth;
  std::vector<double> outside(n_outside * subtrees_.size(), 0.0);
  parallel_for(subtrees_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const int last_inside = begin_[subtrees_[t].last];
      for (int s = subtrees_[t].first; s < subtrees_[t].last; ++s)
        forward(s, last_inside, rows.data(), outside.data() + t * n_outside);
    }
  });
  for (const int s : top_) {
    for (int column = begin_[s]; column < begin_[s + 1]; ++column) {
      for (std::size_t t = 0; t < subtrees_.size(); ++t) {
        const double* from = outside.data() + t * n_outside + static_cast<std::size_t>(kWidth) * top_place_[column];
        for (int c = 0; c < kWidth; ++c) rows[static_cast<std::size_t>(kWidth) * column + c] += from[c];
      }
    }
    if (has_many_rows(s))
      forward_shared(s, rows.data());
    else
      forward(s, n_, rows.data(), nullptr);
  }
  for (auto s = top_.rbegin(); s != top_.rend(); ++s) {
    if (has_many_rows(*s))
      backward_shared(*s, rows.data());
    else
      backward(*s, rows.data());
  }
  parallel_for(subtrees_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      for (int s = subtrees_[t].last - 1; s >= subtrees_[t].first; --s) backward(s, rows.data());
    }
  });
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (int c = 0; c < n_columns; ++c) {
      for (std::size_t i = begin; i < end; ++i) x[c * n + permutation_[i]] = rows[i * kWidth + c];
    }
  });
}

}  // namespace klang::la
