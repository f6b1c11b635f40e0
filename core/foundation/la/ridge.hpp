#pragma once
#include <Eigen/Core>
#include <complex>
#include <string>
#include <type_traits>

namespace klang::la {

template <class Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

/// Least squares with a ridge, HF eq. 34:  minimise ||A x - b||^2 + eps^2 ||x||^2,  A: n_rows x n, n_rows > n.
/// A = rows * diag(scale), given as adjoint = rows^H (n x n_rows), so that a sample's row is contiguous. n is a multiple of
/// kMultiple<Scalar> (lanes of the kernels); functions that are not there are columns of zeros.
template <class Scalar>
inline constexpr Eigen::Index kMultiple = std::is_same_v<Scalar, double> ? 8 : 4;

enum class RidgeMethod {
  kSketch,  ///< conjugate gradients preconditioned by the Cholesky factor of a random sketch
  kDirect   ///< Householder QR of [A; eps I]: LAPACK's xGELS
};

template <class Scalar>
struct RidgeSolution {
  bool solved = false;
  std::string message;
  Matrix<Scalar> x;      ///< n x n_columns
  int n_iterations = 0;  ///< 0 for kDirect
};

/// Sketch: every row of A, with two random signs, is added into 2 of 4 n buckets (a sparse embedding, Clarkson and Woodruff
/// 2013); R from the Cholesky factor of sketch^H sketch + eps^2 I makes A R^-1 well conditioned (singular values near 1 +- 1/2),
/// whatever A is (Rokhlin and Tygert 2008; Blendenpik, Avron, Maymounkov and Toledo 2010), so that conjugate gradients win a
/// factor of 2 to 3 per step. A is read once per step and never factored: 4 n^2 (4 n) / 2 + 4/3 n^3 + 16 n n_rows n_steps flops for
/// complex numbers, where QR takes 8 n^2 (n_rows + n).
/// The same bits on any number of threads. It starts from the solution of the sketched problem and ends when the error of A x is
/// 1e-3 of the residual that stays (the residual itself then is within 1e-6), or 1e-7 of the data.
template <class Scalar>
RidgeSolution<Scalar> solve_ridge(const Matrix<Scalar>& adjoint, const Eigen::VectorXd& scale, const Matrix<Scalar>& b,
                                  double eps, RidgeMethod method);

extern template RidgeSolution<double> solve_ridge(const Matrix<double>&, const Eigen::VectorXd&, const Matrix<double>&,
                                                  double, RidgeMethod);
extern template RidgeSolution<std::complex<double>> solve_ridge(const Matrix<std::complex<double>>&,
                                                                const Eigen::VectorXd&,
                                                                const Matrix<std::complex<double>>&, double,
                                                                RidgeMethod);

/// rows x (no scale), in parallel.
template <class Scalar>
Matrix<Scalar> times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& x);
extern template Matrix<double> times(const Matrix<double>&, const Matrix<double>&);
extern template Matrix<std::complex<double>> times(const Matrix<std::complex<double>>&,
                                                   const Matrix<std::complex<double>>&);

}  // namespace klang::la
