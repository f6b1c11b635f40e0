#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace klang::la {

/// Fill-reducing order of the degrees of freedom of a matrix made of 3 x 3 node blocks (lower triangle):
/// METIS (small graphs: AMD) on the graph of nodes, which is nine times smaller than that of the matrix.
/// order[k] = dof that comes k-th.
std::vector<int> block_ordering(const Eigen::SparseMatrix<double, Eigen::ColMajor, int>& lower);

/// Supernodal Cholesky factor of a symmetric positive definite matrix made of 3 x 3 node blocks (CHOLMOD).
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Factors the lower triangle `lower`; false when a pivot is not positive or memory runs out (see
  /// message()).
  bool factor(const Eigen::SparseMatrix<double, Eigen::ColMajor, int>& lower, const std::vector<int>& order);
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
