#pragma once
#include <Eigen/Core>

#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::acoustics {

/// Spherical solutions of the Helmholtz equation around the origin, for e^{+i omega t}:
///   regular   R_n^m(r) = j_n(k |r|)     Y_n^m(r / |r|)      (everywhere)
///   singular  S_n^m(r) = h_n^(2)(k |r|) Y_n^m(r / |r|)      (outgoing, r != 0)
/// with G(x, y) = e^{-ik|x-y|} / (4 pi |x-y|) = -ik sum_nm S_n^m(x) conj(R_n^m(y)) for |x| > |y| (errata 38).
enum class Wave { kRegular, kSingular };

/// Values and gradients of all functions to one order. Constant after construction, so one object serves all threads.
class HelmholtzBasis {
 public:
  explicit HelmholtzBasis(int order);
  int order() const { return order_; }
  Eigen::Index size() const { return basis_size(order_); }

  /// values (basis_size(order), resized) at r_m. r_m may be 0 for regular functions only.
  void values(Wave wave, double wavenumber_per_m, const Eigen::Vector3d& r_m, Eigen::VectorXcd& values) const;

  /// Also the gradients (basis_size(order) x 3, per metre): combinations of the neighbours of order n + 1 and n - 1, so
  /// neither the poles nor r = 0 (regular) need care.
  void values_and_gradients(Wave wave, double wavenumber_per_m, const Eigen::Vector3d& r_m, Eigen::VectorXcd& values,
                            Eigen::MatrixX3cd& gradients) const;

 private:
  int order_;
  SphericalHarmonics harmonics_;  // one order more than asked, for the gradients
};

/// The six ladder coefficients of one (n, m), F standing for R or S and d+- for d/dx +- i d/dy:
///   (1/k) d/dz F_n^m = z_down F_{n-1}^m     - z_up F_{n+1}^m
///   (1/k) d+   F_n^m = plus_down F_{n-1}^{m+1}  + plus_up F_{n+1}^{m+1}
///   (1/k) d-   F_n^m = -minus_down F_{n-1}^{m-1} - minus_up F_{n+1}^{m-1}
/// The down coefficients vanish where F_{n-1} has no such m.
struct Ladder {
  double z_up, z_down, plus_up, plus_down, minus_up, minus_down;
  Ladder(int n, int m);
};

}  // namespace klang::acoustics
