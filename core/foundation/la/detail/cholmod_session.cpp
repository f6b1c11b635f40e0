#include "core/foundation/la/detail/cholmod_session.hpp"

#include "core/foundation/base/huge_pages.hpp"

namespace klang::la::detail {

cholmod_sparse cholmod_view(const SparseMatrix& lower) {
  cholmod_sparse a{};
  a.nrow = static_cast<std::size_t>(lower.rows());
  a.ncol = static_cast<std::size_t>(lower.cols());
  a.nzmax = static_cast<std::size_t>(lower.nonZeros());
  a.p = const_cast<int*>(lower.outerIndexPtr());
  a.i = const_cast<int*>(lower.innerIndexPtr());
  a.x = const_cast<double*>(lower.valuePtr());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

CholmodSession::CholmodSession() {
  static const bool large_pages = (SuiteSparse_config.malloc_func = huge_malloc, true);  // for the factors
  static_cast<void>(large_pages);
  cholmod_start(&common);
  common.print = 0;
  common.error_handler = nullptr;
  common.try_catch = 1;
}

CholmodSession::~CholmodSession() { cholmod_finish(&common); }

cholmod_factor* CholmodSession::analyse_supernodal(const SparseMatrix& lower, const std::vector<int>& order) {
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 1;
  common.final_ll = 1;
  // Blocks of 3 make CHOLMOD's own supernodes short: merging more of them costs a tenth more entries and saves a tenth
  // or more of the time.
  common.nrelax[0] = 16;
  common.nrelax[1] = 64;
  common.nrelax[2] = 256;
  cholmod_sparse a = cholmod_view(lower);
  return cholmod_analyze_p(&a, const_cast<int*>(order.data()), nullptr, 0, &common);
}

}  // namespace klang::la::detail
