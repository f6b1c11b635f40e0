#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

namespace klang::acoustics {

/// Place of (n, m) among the (order + 1)^2 basis functions of every table in this folder: n (n + 1) + m.
constexpr Eigen::Index basis_index(int n, int m) { return Eigen::Index{n} * (n + 1) + m; }
constexpr Eigen::Index basis_size(int order) { return Eigen::Index{order + 1} * (order + 1); }

/// Orthonormal complex spherical harmonics with the Condon-Shortley phase,
///   Y_n^m(s) = N_n^m P_n^m(cos theta) e^{i m phi},  integral over the sphere of Y_n^m conj(Y_n'^m') = 1 where equal, else 0,
/// so that Y_n^{-m} = (-1)^m conj(Y_n^m). Evaluated as q_n^m(s_z) (s_x + i s_y)^m with q_n^m a polynomial: nothing special
/// happens at the poles. Source of the recurrence in n: Holmes and Featherstone 2002, J. Geodesy 76, 279-299.
class SphericalHarmonics {
 public:
  explicit SphericalHarmonics(int order);  ///< tables of O(order^2) numbers; evaluation does not allocate
  int order() const { return order_; }

  /// Y_n^m at basis_index(n, m) for all n <= order. direction must have length 1; values holds basis_size(order).
  void evaluate(const Eigen::Vector3d& direction, std::complex<double>* values) const;

  /// Derivatives on the unit sphere: column j of gradients (basis_size(order) x 3) is the derivative along axis j of
  /// Y(x / |x|) at |x| = 1, a vector tangent to the sphere. Safe at the poles.
  void evaluate(const Eigen::Vector3d& direction, std::complex<double>* values,
                Eigen::Ref<Eigen::MatrixXcd> gradients) const;

  /// The constants of the recurrence, for evaluation elsewhere (vectorised, on a device):
  ///   q_m^m = diagonal[m],  q_n^m = by_z s_z q_{n-1}^m - by_previous q_{n-2}^m  with both at n (n + 1) / 2 + m
  const std::vector<double>& diagonal() const { return diagonal_; }
  const std::vector<double>& by_z() const { return by_z_; }
  const std::vector<double>& by_previous() const { return by_previous_; }

 private:
  int order_;
  std::vector<double> diagonal_, by_z_, by_previous_;
};

}  // namespace klang::acoustics
