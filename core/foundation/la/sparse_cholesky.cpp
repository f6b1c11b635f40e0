#include "core/foundation/la/sparse_cholesky.hpp"

#include <algorithm>
#include <mutex>
#include <optional>

#include "core/foundation/base/check.hpp"
#include "core/foundation/la/detail/cholmod_session.hpp"
#include "core/foundation/la/supernodal_solve.hpp"

namespace klang::la {
namespace {

using Lower = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

constexpr int kAmdLimitNodes = 3000;
constexpr Eigen::Index kOwnSolveFrom = 3;  // columns

// METIS draws from the C library's rand(), which it seeds at each call: two at a time would take each other's numbers, and
// the order, and with it the last bits of every solution, would change from run to run.
std::mutex metis_mutex;

}  // namespace

std::vector<int> block_ordering(const Lower& lower) {
  const int n_nodes = static_cast<int>(lower.rows() / 3);
  KLANG_CHECK(lower.rows() == 3 * n_nodes, "3 x 3 node blocks");
  std::vector<int> start(n_nodes + 1, 0), row;
  row.reserve(static_cast<std::size_t>(lower.nonZeros() / 8));
  for (int j = 0; j < n_nodes; ++j) {
    // Column 3 j holds every node below: each third row of it, after the diagonal block.
    const int* outer = lower.outerIndexPtr();
    for (int k = outer[3 * j]; k < outer[3 * j + 1]; ++k) {
      const int i = lower.innerIndexPtr()[k] / 3;
      if (row.empty() || static_cast<int>(row.size()) == start[j] || row.back() != i) row.push_back(i);
    }
    start[j + 1] = static_cast<int>(row.size());
  }
  detail::CholmodSession session;
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = static_cast<std::size_t>(n_nodes);
  graph.nzmax = row.size();
  graph.p = start.data();
  graph.i = row.data();
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.sorted = 1;
  graph.packed = 1;
  std::vector<int> nodes(n_nodes);
  int done = 0;
  if (n_nodes > kAmdLimitNodes) {
    const std::lock_guard lock(metis_mutex);
    done = cholmod_metis(&graph, nullptr, 0, 1, nodes.data(), &session.common);
  }
  if (!done) done = cholmod_amd(&graph, nullptr, 0, nodes.data(), &session.common);
  if (!done) {
    for (int i = 0; i < n_nodes; ++i) nodes[i] = i;
  }
  std::vector<int> order(3 * static_cast<std::size_t>(n_nodes));
  for (int k = 0; k < n_nodes; ++k) {
    for (int a = 0; a < 3; ++a) order[3 * k + a] = 3 * nodes[k] + a;
  }
  return order;
}

struct SparseCholesky::State {
  detail::CholmodSession session;
  cholmod_common& common = session.common;
  cholmod_factor* factor = nullptr;
  std::optional<SupernodalSolve> many_columns;
  cholmod_dense* y = nullptr;  // workspace that cholmod_solve2 keeps between calls
  cholmod_dense* e = nullptr;
  cholmod_dense* x = nullptr;

  void release() {
    many_columns.reset();
    cholmod_free_factor(&factor, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_free_dense(&x, &common);
  }
  ~State() { release(); }
};

SparseCholesky::SparseCholesky() : state_(std::make_unique<State>()) {}
SparseCholesky::~SparseCholesky() = default;

bool SparseCholesky::factor(const Lower& lower, const std::vector<int>& order) {
  state_->release();
  cholmod_common& common = state_->common;
  state_->factor = state_->session.analyse_supernodal(lower, order);
  if (state_->factor == nullptr) return false;
  cholmod_sparse a = detail::cholmod_view(lower);
  const int done = cholmod_factorize(&a, state_->factor, &common);
  if (!done || common.status != CHOLMOD_OK || state_->factor->minor != state_->factor->n) return false;
  state_->many_columns.emplace(*state_->factor);
  return true;
}

void SparseCholesky::solve(const double* b, double* x, Eigen::Index n_columns) {
  KLANG_CHECK(state_->factor != nullptr, "factor() comes first");
  const std::size_t n = state_->factor->n;
  if (n_columns >= kOwnSolveFrom) {
    for (Eigen::Index first = 0; first < n_columns; first += SupernodalSolve::kWidth) {
      const auto at = static_cast<std::size_t>(first) * n;
      state_->many_columns->solve(b + at, x + at,
                                  static_cast<int>(std::min<Eigen::Index>(SupernodalSolve::kWidth, n_columns - first)));
    }
    return;
  }
  cholmod_dense rhs{};
  rhs.nrow = n;
  rhs.ncol = static_cast<std::size_t>(n_columns);
  rhs.nzmax = n * rhs.ncol;
  rhs.d = n;
  rhs.x = const_cast<double*>(b);
  rhs.xtype = CHOLMOD_REAL;
  rhs.dtype = CHOLMOD_DOUBLE;
  const int done = cholmod_solve2(CHOLMOD_A, state_->factor, &rhs, nullptr, &state_->x, nullptr, &state_->y, &state_->e,
                                  &state_->common);
  KLANG_CHECK(done, "out of memory in a triangular solve");
  const double* from = static_cast<const double*>(state_->x->x);
  std::copy(from, from + rhs.nzmax, x);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& b) {
  Eigen::MatrixXd x(b.rows(), b.cols());
  solve(b.data(), x.data(), b.cols());
  return x;
}

double SparseCholesky::n_factor_entries() const {
  return state_->factor == nullptr ? 0.0 : static_cast<double>(state_->factor->xsize);
}

const char* SparseCholesky::message() const {
  switch (state_->common.status) {
    case CHOLMOD_OK:
      return "ok";
    case CHOLMOD_NOT_POSDEF:
      return "the shifted matrix is not positive definite";
    case CHOLMOD_OUT_OF_MEMORY:
      return "out of memory";
    case CHOLMOD_TOO_LARGE:
      return "the factor is too large for 32-bit indices";
    default:
      return "CHOLMOD failed";
  }
}

}  // namespace klang::la
