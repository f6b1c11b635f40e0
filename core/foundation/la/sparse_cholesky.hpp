#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/foundation/la/factor_pattern.hpp"
#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la {

/// Supernodal Cholesky factor of a symmetric positive definite matrix: analysed by CHOLMOD, computed front by front on all threads
/// with the same bits on any number of them.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Factors the lower triangle `lower`; false when a pivot is not positive or memory runs out (see
  /// message()).
  bool factor(const SparseMatrix& lower, const std::vector<int>& order);
  /// The same for a matrix whose pattern has been analysed.
  bool factor(const SparseMatrix& lower, const FactorPattern& pattern);
  /// X = A^-1 B for n x n_columns values in column-major order; X may be B. Not to be called by two threads
  /// at once.
  void solve(const double* b, double* x, Eigen::Index n_columns = 1);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b);
  double n_factor_entries() const;
  const char* message() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace klang::la
