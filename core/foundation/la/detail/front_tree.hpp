#pragma once
#include <functional>
#include <vector>

#include "core/foundation/la/sparse_matrix.hpp"

struct cholmod_factor_struct;

namespace klang::la::detail {

/// The elimination tree of supernodes of P A P^T: which rows a front has, whose updates it takes, and where the entries of A go.
/// Made once for a pattern, used for each matrix that has it.
struct FrontTree {
  /// Refers to the factor's arrays, which must outlive this. factor: supernodal and postordered; lower: a matrix of the pattern.
  FrontTree(const cholmod_factor_struct& factor, const SparseMatrix& lower);

  int n_columns(int s) const { return begin[s + 1] - begin[s]; }
  int n_rows(int s) const { return row_begin[s + 1] - row_begin[s]; }
  const int* rows(int s) const { return row + row_begin[s]; }

  /// A front while it is assembled.
  struct Front {
    const int* local;  ///< of each row of the matrix, its place in the front
    double* columns;   ///< those that are eliminated here, n_rows x n_columns, column-major
    double* below;     ///< lower triangle of what is left, a square
  };
  /// Adds the entries of the matrix with these values (in lower's order) to the front of supernode s.
  void add_entries(int s, const double* value, const Front& front) const;
  /// Adds the lower triangle that a child has left to the front of its parent.
  void add_update(int child, const double* update, int parent, const Front& front) const;

  /// Calls eliminate(job, s) for each supernode after its children: jobs 0 to n_jobs() - 2 are disjoint subtrees, side by side; what
  /// lies above them is the last job. How the tree is cut depends on the tree alone. Ends early once one returns false.
  bool run(const std::function<bool(int job, int s)>& eliminate) const;
  int n_jobs() const { return static_cast<int>(subtrees.size()) + 1; }

  int n, n_supernodes;
  const int* begin;      ///< first column of each supernode
  const int* row_begin;  ///< first place of its rows in row
  const int* row;
  const int* value_begin;  ///< first place of its entries in a supernodal factor
  std::vector<std::vector<int>> children;
  std::vector<int> subtrees;  ///< roots of the subtrees that are eliminated side by side

 private:
  void map_entries(const int* order, const SparseMatrix& lower);
  void cut();
  int first_of_subtree(int root) const;

  std::vector<int> roots_;
  std::vector<int> entry_begin_, entry_row_, entry_source_;  // of each column of P A P^T, rows in any order
};

/// C := C - A B^T, of which what lies on and below the diagonal of the first n_columns rows is wanted. Stripes of columns run in
/// parallel where there is much to do: the same bits on any number of threads.
struct LowerProduct {
  struct Columns {
    const double* at;
    int stride;
  };
  int n_rows, n_columns, depth;
  Columns a, b;  ///< n_rows x depth
  double* c;
  int c_stride;
};
void subtract(const LowerProduct& product);

}  // namespace klang::la::detail
