#pragma once
#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la {

/// A compressed matrix with room for so many entries, none of them written yet, rows and starts of columns neither.
SparseMatrix room_for(Eigen::Index n_rows, Eigen::Index n_columns, Eigen::Index n_entries);

/// A matrix with the pattern of another compressed one; its values are still to be written.
SparseMatrix same_pattern(const SparseMatrix& matrix);

}  // namespace klang::la
