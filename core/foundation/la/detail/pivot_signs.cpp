#include "core/foundation/la/detail/pivot_signs.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <new>
#include <numeric>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/detail/cholmod_session.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la::detail {
namespace {

constexpr int kPanel = 64;  // columns eliminated together
constexpr int kStripe =
    256;  // columns of a symmetric product computed together; what lies above its diagonal is wasted

constexpr std::size_t kSubtrees = 16;  // eliminated side by side

using Values = std::unique_ptr<double[]>;

Values zeros(std::size_t n) { return Values(new double[n]()); }

// The lower triangle of P A P^T by columns, rows in any order.
struct Permuted {
  std::vector<int> start, row;
  std::vector<double> value;

  Permuted(const SparseMatrix& lower, const int* order) {
    const int n = static_cast<int>(lower.rows());
    std::vector<int> place(n);
    for (int k = 0; k < n; ++k) place[order[k]] = k;
    start.assign(static_cast<std::size_t>(n) + 1, 0);
    const auto each = [&](const auto& use) {
      for (int j = 0; j < n; ++j) {
        for (int k = lower.outerIndexPtr()[j]; k < lower.outerIndexPtr()[j + 1]; ++k) {
          const auto [column, below] = std::minmax(place[j], place[lower.innerIndexPtr()[k]]);
          use(column, below, lower.valuePtr()[k]);
        }
      }
    };
    each([&](int column, int, double) { ++start[column + 1]; });
    for (int j = 0; j < n; ++j) start[j + 1] += start[j];
    std::vector<int> next(start.begin(), start.end() - 1);
    row.resize(static_cast<std::size_t>(lower.nonZeros()));
    value.resize(row.size());
    each([&](int column, int below, double a) {
      row[next[column]] = below;
      value[next[column]++] = a;
    });
  }
};

// A block of columns, `stride` apart.
struct Block {
  double* at;
  int stride;
  double* column(int j) const { return at + static_cast<std::size_t>(j) * stride; }
};

// C := C - A B^T with `depth` columns in A and B, of which only what lies on and below the diagonal of the first `n_columns`
// rows is wanted.
void subtract_lower(int n_rows, int n_columns, int depth, const Block& a, const Block& b, const Block& c) {
  for (int j = 0; j < n_columns; j += kStripe) {
    const int width = std::min(kStripe, n_columns - j);
    gemm('N', 'T', n_rows - j, width, depth, -1.0, a.at + j, a.stride, b.at + j, b.stride, 1.0, c.column(j) + j,
         c.stride);
  }
}

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

// The elimination tree of supernodes: which rows a front has, and whose updates it takes.
struct Tree {
  int n, n_supernodes;
  const int* begin;      // first column of each supernode
  const int* row_begin;  // first place of its rows in row
  const int* row;
  std::vector<std::vector<int>> children;
  std::vector<int> roots;

  explicit Tree(const cholmod_factor& factor)
      : n(static_cast<int>(factor.n)),
        n_supernodes(static_cast<int>(factor.nsuper)),
        begin(static_cast<const int*>(factor.super)),
        row_begin(static_cast<const int*>(factor.pi)),
        row(static_cast<const int*>(factor.s)),
        children(static_cast<std::size_t>(n_supernodes)) {
    std::vector<int> owner(static_cast<std::size_t>(n));
    for (int s = 0; s < n_supernodes; ++s) std::fill(owner.begin() + begin[s], owner.begin() + begin[s + 1], s);
    for (int s = 0; s < n_supernodes; ++s) {
      (n_rows(s) > n_columns(s) ? children[owner[rows(s)[n_columns(s)]]] : roots).push_back(s);
    }
  }
  int n_columns(int s) const { return begin[s + 1] - begin[s]; }
  int n_rows(int s) const { return row_begin[s + 1] - row_begin[s]; }
  const int* rows(int s) const { return row + row_begin[s]; }

  // Supernodes are postordered: a subtree is the range that ends with its root. The heaviest is cut at its root until there are
  // n_subtrees; how depends on the tree alone.
  std::vector<int> heaviest_subtrees(std::size_t n_subtrees) const {
    std::vector<double> work(static_cast<std::size_t>(n_supernodes));
    for (int s = 0; s < n_supernodes; ++s) {
      work[s] = static_cast<double>(n_columns(s)) * n_rows(s) * n_rows(s);
      for (const int child : children[s]) work[s] += work[child];
    }
    const auto lighter = [&](int a, int b) { return work[a] < work[b]; };
    std::vector<int> heap = roots;
    std::make_heap(heap.begin(), heap.end(), lighter);
    while (heap.size() < n_subtrees && !children[heap.front()].empty()) {
      const int root = heap.front();
      std::pop_heap(heap.begin(), heap.end(), lighter);
      heap.pop_back();
      for (const int child : children[root]) {
        heap.push_back(child);
        std::push_heap(heap.begin(), heap.end(), lighter);
      }
    }
    std::sort(heap.begin(), heap.end());
    return heap;
  }
  int first_of_subtree(int root) const {
    while (!children[root].empty()) root = children[root].front();
    return root;
  }
};

// Eliminates supernodes one after another; each thread has one of these.
class Elimination {
 public:
  Elimination(const Permuted& a, const Tree& tree, std::vector<Values>& update)
      : a_(a), tree_(tree), update_(update), local_(static_cast<std::size_t>(tree.n)) {
    size.assign(static_cast<std::size_t>(tree.n), 0.0);
  }

  // False at a pivot of zero.
  bool eliminate(int s) {
    const int n = tree_.n_rows(s), m = tree_.n_columns(s), below = n - m;
    Values columns = zeros(static_cast<std::size_t>(n) * m);
    update_[s] = zeros(static_cast<std::size_t>(below) * below);
    assemble(s, columns.get(), update_[s].get());
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
      subtract_lower(rest, inside, width, {panel, n}, {scaled, n}, {Block{panel, n}.column(width), n});
    }
    subtract_lower(below, below, m, {columns.get() + m, n}, {scaled_.data() + m, n}, {update_[s].get(), below});
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

  // Adds the entries of A and the children's updates to the front: its eliminated columns and the rest below them.
  void assemble(int s, double* columns, double* rest) {
    const int n = tree_.n_rows(s), m = tree_.n_columns(s), below = n - m, first = tree_.begin[s];
    for (int i = 0; i < n; ++i) local_[tree_.rows(s)[i]] = i;
    for (int j = 0; j < m; ++j) {
      double* column = columns + static_cast<std::size_t>(j) * n;
      for (int k = a_.start[first + j]; k < a_.start[first + j + 1]; ++k) column[local_[a_.row[k]]] += a_.value[k];
    }
    std::vector<int> to;
    for (const int child : tree_.children[s]) {
      const int* child_rows = tree_.rows(child) + tree_.n_columns(child);
      const int k = tree_.n_rows(child) - tree_.n_columns(child);
      to.resize(static_cast<std::size_t>(k));
      for (int i = 0; i < k; ++i) to[i] = local_[child_rows[i]];
      for (int j = 0; j < k; ++j) {
        const double* from = update_[child].get() + static_cast<std::size_t>(j) * k;
        const bool eliminated = to[j] < m;
        double* column = eliminated ? columns + static_cast<std::size_t>(to[j]) * n
                                    : rest + static_cast<std::size_t>(to[j] - m) * below;
        const int shift = eliminated ? 0 : m;
        for (int i = j; i < k; ++i) column[to[i] - shift] += from[i];
      }
      update_[child].reset();
    }
  }

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

  const Permuted& a_;
  const Tree& tree_;
  std::vector<Values>& update_;  // what a front leaves to its parent: its lower triangle, by columns
  std::vector<int> local_;       // of a row in the front at hand
  std::vector<double> scaled_;
};

std::optional<PivotSigns> eliminate_all(const Permuted& a, const Tree& tree) {
  std::vector<Values> update(static_cast<std::size_t>(tree.n_supernodes));
  const std::vector<int> subtrees = tree.heaviest_subtrees(kSubtrees);
  std::vector<std::vector<double>> size(subtrees.size());
  std::vector<long> n_negative(subtrees.size());
  std::vector<char> inside(static_cast<std::size_t>(tree.n_supernodes), 0);
  std::atomic<bool> vanished = false;
  for (const int root : subtrees) std::fill(inside.begin() + tree.first_of_subtree(root), inside.begin() + root + 1, 1);
  // Not for_each_job, which sets BLAS' threads for the whole process: a Cholesky factor may be at work beside this.
  parallel_for(subtrees.size(), 1, [&](std::size_t i, std::size_t) {
    Elimination one(a, tree, update);
    for (int s = tree.first_of_subtree(subtrees[i]); s <= subtrees[i] && !vanished; ++s) {
      if (!one.eliminate(s)) vanished = true;
    }
    size[i] = std::move(one.size);
    n_negative[i] = one.n_negative;
  });
  Elimination top(a, tree, update);
  for (int s = 0; s < tree.n_supernodes && !vanished; ++s) {
    if (!inside[s] && !top.eliminate(s)) vanished = true;
  }
  if (vanished) return std::nullopt;
  PivotSigns result{top.n_negative, 0};
  for (const long n : n_negative) result.n_negative += n;
  double grown = std::accumulate(top.size.begin(), top.size.end(), 0.0), diagonal = 0;
  for (const auto& of_subtree : size) grown += std::accumulate(of_subtree.begin(), of_subtree.end(), 0.0);
  for (int j = 0; j < tree.n; ++j) {
    for (int k = a.start[j]; k < a.start[j + 1]; ++k) {
      if (a.row[k] == j) diagonal += std::abs(a.value[k]);
    }
  }
  result.growth = grown / diagonal;
  return result;
}

}  // namespace

std::optional<PivotSigns> pivot_signs(const SparseMatrix& lower, const std::vector<int>& order) {
  CholmodSession session;
  cholmod_factor* factor = session.analyse_supernodal(lower, order);
  if (factor == nullptr) return std::nullopt;
  std::optional<PivotSigns> result;
  try {
    if (factor->is_super != 0) {
      result = eliminate_all(Permuted(lower, static_cast<const int*>(factor->Perm)), Tree(*factor));
    }
  } catch (const std::bad_alloc&) {
    result.reset();
  }
  cholmod_free_factor(&factor, &session.common);
  return result;
}

}  // namespace klang::la::detail
