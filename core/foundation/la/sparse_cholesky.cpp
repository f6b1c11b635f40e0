#include "core/foundation/la/sparse_cholesky.hpp"

#include <algorithm>
#include <new>
#include <optional>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/detail/analysed_pattern.hpp"
#include "core/foundation/la/detail/cholmod_session.hpp"
#include "core/foundation/la/detail/tree_cholesky.hpp"
#include "core/foundation/la/supernodal_solve.hpp"

namespace klang::la {
namespace {

constexpr Eigen::Index kOwnSolveFrom = 3;  // columns

}  // namespace

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

bool SparseCholesky::factor(const SparseMatrix& lower, const std::vector<int>& order) {
  return factor(lower, FactorPattern(lower, order));
}

bool SparseCholesky::factor(const SparseMatrix& lower, const FactorPattern& pattern) {
  state_->release();
  cholmod_common& common = state_->common;
  if (!pattern) {
    common.status = pattern.out_of_memory() ? CHOLMOD_OUT_OF_MEMORY : CHOLMOD_TOO_LARGE;
    return false;
  }
  cholmod_factor*& factor = state_->factor;
  factor = cholmod_copy_factor(pattern.analysed().symbolic, &common);
  if (factor == nullptr || !cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, factor, &common)) {
    state_->release();
    common.status = CHOLMOD_OUT_OF_MEMORY;
    return false;
  }
  KLANG_CHECK(lower.rows() == static_cast<Eigen::Index>(factor->n), "the pattern is of another matrix");
  try {
    const BlasThreads one_each(1);  // fronts are shared out here
    if (!detail::tree_cholesky(pattern.analysed().tree, lower.valuePtr(), static_cast<double*>(factor->x))) {
      state_->release();
      common.status = CHOLMOD_NOT_POSDEF;
      return false;
    }
  } catch (const std::bad_alloc&) {
    state_->release();
    common.status = CHOLMOD_OUT_OF_MEMORY;
    return false;
  }
  common.status = CHOLMOD_OK;
  state_->many_columns.emplace(*factor);
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
