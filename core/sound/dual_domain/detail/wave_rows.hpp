#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "core/sound/waves/helmholtz_basis.hpp"

namespace klang::bubble::detail {

/// Regular waves j_n(k r) Y_n^m about the origin, n <= order, with real harmonics: column n (n + 1) + m holds
/// sqrt(2) Re for m > 0, sqrt(2) Im (of |m|) for m < 0, the function itself for m = 0. Orthonormal on the sphere. Real for a real k.
class RegularRows {
 public:
  RegularRows(int order, std::complex<double> wavenumber_per_m);
  int size() const { return (order_ + 1) * (order_ + 1); }

  /// What one thread needs.
  struct Scratch {
    Eigen::VectorXcd harmonics;
    std::vector<double> bessel;
    std::vector<std::complex<double>> lossy_bessel;
  };
  Scratch scratch() const;

  /// Values (size()) at r_m; for a real k.
  void values(const Eigen::Vector3d& r_m, Scratch& scratch, double* row) const;
  /// Derivatives along the unit vector normal, per metre.
  void slopes(const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal, Scratch& scratch, double* row) const;
  /// The same for any k.
  void values(const Eigen::Vector3d& r_m, Scratch& scratch, std::complex<double>* row) const;
  void slopes(const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal, Scratch& scratch,
              std::complex<double>* row) const;

 private:
  void fill(const Eigen::Vector3d& r_m, Scratch& scratch) const;
  void fill_lossy(const Eigen::Vector3d& r_m, Scratch& scratch) const;
  int order_;
  std::complex<double> lossy_wavenumber_;
  double wavenumber_per_m_;                  // its real part
  acoustics::SphericalHarmonics harmonics_;  // one order more, for slopes
  std::vector<acoustics::Ladder> ladders_;   // by n (n + 1) / 2 + m, m >= 0
};

/// The functions of one source up to quadrupoles, l = 0, 1, 2, with real harmonics:
///   1, x, y, z, xy, yz, zx, (x^2 - y^2)/2, (2z^2 - x^2 - y^2)/(2 sqrt 3)  times  j_l or h_l^(2)(k r) / r^l, orthonormal on the sphere.
inline constexpr int kQuadrupoleSize = 9;
void regular_quadrupole(double wavenumber_per_m, const Eigen::Vector3d& r_m, double* values);
void regular_quadrupole_slopes(double wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal,
                               double* slopes);
void regular_quadrupole(std::complex<double> wavenumber_per_m, const Eigen::Vector3d& r_m,
                        std::complex<double>* values);
void regular_quadrupole_slopes(std::complex<double> wavenumber_per_m, const Eigen::Vector3d& r_m,
                               const Eigen::Vector3d& normal, std::complex<double>* slopes);
void singular_quadrupole(double wavenumber_per_m, const Eigen::Vector3d& r_m, std::complex<double>* values);
void singular_quadrupole_slopes(double wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal,
                                std::complex<double>* slopes);
/// y_l(k r) Y for any k: standing waves that are singular at the origin.
void standing_quadrupole(std::complex<double> wavenumber_per_m, const Eigen::Vector3d& r_m,
                         const Eigen::Vector3d* normal, std::complex<double>* out);

/// -e^{-ikR} / (4 pi R), the field of a unit source (HF eq. 19), and its derivative along normal.
std::complex<double> monopole(std::complex<double> wavenumber_per_m, const Eigen::Vector3d& r_m);
std::complex<double> monopole_slope(std::complex<double> wavenumber_per_m, const Eigen::Vector3d& r_m,
                                    const Eigen::Vector3d& normal);

}  // namespace klang::bubble::detail
