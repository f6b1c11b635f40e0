#pragma once
#include <cstddef>
#include <vector>

struct cholmod_factor_struct;

namespace klang::la {

/// Triangular solves with a supernodal factor P A P^T = L L^T for kWidth columns at once, which share each load of an
/// entry of L: the columns lie side by side in memory, so that an entry times a row of them is one vector operation
/// (CHOLMOD's own solve takes two to three times as long for 8 columns). Disjoint subtrees of the elimination tree
/// run in parallel; how the tree is cut does not depend on the number of threads, nor do the bits of the result.
class SupernodalSolve {
 public:
  static constexpr int kWidth = 8;

  /// Refers to the factor, which must outlive this and be LL^T, supernodal and postordered.
  explicit SupernodalSolve(const cholmod_factor_struct& factor);

  /// X = A^-1 B for n_columns <= kWidth columns of length n; X may be B.
  void solve(const double* b, double* x, int n_columns) const;

 private:
  struct Range {
    int first, last;  ///< supernodes, last not included
  };
  void cut_tree();
  void forward(int supernode, int last_inside, double* x, double* outside) const;
  void backward(int supernode, double* x) const;
  void forward_shared(int supernode, double* x) const;  ///< by all threads
  void backward_shared(int supernode, double* x) const;

  int n_ = 0, n_supernodes_ = 0;
  const int* begin_;      // first column of each supernode
  const int* row_begin_;  // first place of its rows in row_
  const int* value_begin_;
  const int* row_;
  const int* permutation_;
  const double* value_;  // n_rows x n_columns of each supernode, column-major
  std::vector<Range> subtrees_;
  std::vector<int> top_;        // supernodes above the subtrees, ascending
  std::vector<int> top_place_;  // of each row, -1 where a subtree owns it
  int n_top_rows_ = 0;
};

}  // namespace klang::la
