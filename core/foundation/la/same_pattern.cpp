#include "core/foundation/la/same_pattern.hpp"

#include <algorithm>

#include "core/foundation/base/huge_pages.hpp"

namespace klang::la {

SparseMatrix room_for(Eigen::Index n_rows, Eigen::Index n_columns, Eigen::Index n_entries) {
  SparseMatrix made(n_rows, n_columns);
  made.resizeNonZeros(n_entries);
  advise_huge_pages(made.innerIndexPtr(), static_cast<std::size_t>(n_entries) * sizeof(int));
  advise_huge_pages(made.valuePtr(), static_cast<std::size_t>(n_entries) * sizeof(double));
  return made;
}

SparseMatrix same_pattern(const SparseMatrix& matrix) {
  SparseMatrix made = room_for(matrix.rows(), matrix.cols(), matrix.nonZeros());
  std::copy_n(matrix.outerIndexPtr(), matrix.cols() + 1, made.outerIndexPtr());
  std::copy_n(matrix.innerIndexPtr(), matrix.nonZeros(), made.innerIndexPtr());
  return made;
}

}  // namespace klang::la
