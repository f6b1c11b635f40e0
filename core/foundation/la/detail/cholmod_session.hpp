#pragma once
#include <cholmod.h>

#include <vector>

#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la::detail {

/// CHOLMOD's workspace and options; failures are returned, not printed.
struct CholmodSession {
  cholmod_common common;
  CholmodSession();
  ~CholmodSession();
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;

  /// Analyses for a supernodal, postordered factor in the order given. Null when memory or 32-bit indices do not reach.
  cholmod_factor* analyse_supernodal(const SparseMatrix& lower, const std::vector<int>& order);
};

/// CHOLMOD reads, and never writes, what this shallow view of a lower triangle points at.
cholmod_sparse cholmod_view(const SparseMatrix& lower);

}  // namespace klang::la::detail
