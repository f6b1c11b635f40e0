#include "core/foundation/la/sturm_count.hpp"

#include <dmumps_c.h>

#include <mutex>
#include <vector>

#include "core/foundation/la/detail/analysed_pattern.hpp"
#include "core/foundation/la/detail/pivot_signs.hpp"

namespace klang::la {
namespace {

// MUMPS keeps its sequential MPI stand-in in global variables.
std::mutex mumps_mutex;

constexpr int kUseCommWorld = -987654;

class Mumps {
 public:
  Mumps() {
    id_.job = -1;
    id_.par = 1;
    id_.sym = 2;
    id_.comm_fortran = kUseCommWorld;
    dmumps_c(&id_);
    for (const int k : {1, 2, 3}) icntl(k) = -1;  // says nothing
    icntl(4) = 0;
  }
  ~Mumps() {
    id_.job = -2;
    dmumps_c(&id_);
  }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  int& icntl(int k) { return id_.icntl[k - 1]; }
  int infog(int k) const { return id_.infog[k - 1]; }
  DMUMPS_STRUC_C& operator*() { return id_; }
  bool run(int job) {
    id_.job = job;
    dmumps_c(&id_);
    return infog(1) >= 0;
  }

 private:
  DMUMPS_STRUC_C id_{};
};

// How much worse than a Cholesky factor's the round-off may be: the modes next to a shift are told apart by far more.
constexpr double kGrowthLimit = 1e3;

std::optional<long> n_negative_with_exchanges(const SparseMatrix& lower, const std::vector<int>& order) {
  const std::lock_guard lock(mumps_mutex);
  const auto n = static_cast<int>(lower.rows());
  std::vector<int> row(lower.nonZeros()), column(lower.nonZeros()), position(n);
  for (int j = 0; j < n; ++j) {
    for (int k = lower.outerIndexPtr()[j]; k < lower.outerIndexPtr()[j + 1]; ++k) {
      row[k] = lower.innerIndexPtr()[k] + 1;
      column[k] = j + 1;
    }
  }
  for (int k = 0; k < n; ++k) position[order[k]] = k + 1;

  Mumps mumps;
  (*mumps).n = n;
  (*mumps).nnz = lower.nonZeros();
  (*mumps).irn = row.data();
  (*mumps).jcn = column.data();
  (*mumps).a = const_cast<double*>(lower.valuePtr());
  (*mumps).perm_in = position.data();
  mumps.icntl(6) = 0;   // no permutation to a large diagonal: it would spoil the order
  mumps.icntl(7) = 1;   // the order given
  mumps.icntl(12) = 1;  // ordinary symmetric order
  mumps.icntl(31) = 1;  // only the inertia is wanted: factors are thrown away
  if (!mumps.run(1)) return std::nullopt;
  for (const int extra_percent : {30, 100, 400}) {
    mumps.icntl(14) = extra_percent;
    if (mumps.run(2)) return mumps.infog(12);
    if (mumps.infog(1) != -8 && mumps.infog(1) != -9) break;  // anything but too little workspace
  }
  return std::nullopt;
}

}  // namespace

std::optional<long> n_negative_eigenvalues(const SparseMatrix& lower, const FactorPattern& pattern) {
  if (pattern) {
    const auto signs = detail::pivot_signs(pattern.analysed().tree, lower);
    if (signs && signs->growth <= kGrowthLimit) return signs->n_negative;
  }
  return n_negative_with_exchanges(lower, pattern.order());
}

}  // namespace klang::la
