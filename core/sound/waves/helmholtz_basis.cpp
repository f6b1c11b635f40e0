#include "core/sound/waves/helmholtz_basis.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/sound/waves/spherical_bessel.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;

// Fills values to harmonics.order() at r.
void fill(const SphericalHarmonics& harmonics, Wave wave, double k, const Eigen::Vector3d& r, Complex* values) {
  const double distance = r.norm();
  const int order = harmonics.order();
  KLANG_CHECK(wave == Wave::kRegular || (k > 0.0 && distance > 0.0), "singular basis functions need k r > 0");
  harmonics.evaluate(distance > 0.0 ? Eigen::Vector3d(r / distance) : Eigen::Vector3d::UnitZ(), values);
  Eigen::VectorXcd h(order + 1);
  if (wave == Wave::kSingular) {
    spherical_hankel2(k * distance, {h.data(), static_cast<std::size_t>(order) + 1});
  } else {
    Eigen::VectorXd j(order + 1);
    spherical_bessel_j(k * distance, {j.data(), static_cast<std::size_t>(order) + 1});
    h = j.cast<Complex>();
  }
  for (int n = 0; n <= order; ++n) {
    for (int m = -n; m <= n; ++m) values[basis_index(n, m)] *= h[n];
  }
}

}  // namespace

HelmholtzBasis::HelmholtzBasis(int order) : order_(order), harmonics_(order + 1) {
  KLANG_CHECK(order >= 0, "order of a Helmholtz basis");
}

void HelmholtzBasis::values(Wave wave, double wavenumber_per_m, const Eigen::Vector3d& r_m,
                            Eigen::VectorXcd& values) const {
  Eigen::VectorXcd all(basis_size(order_ + 1));
  fill(harmonics_, wave, wavenumber_per_m, r_m, all.data());
  values = all.head(size());
}

void HelmholtzBasis::values_and_gradients(Wave wave, double wavenumber_per_m, const Eigen::Vector3d& r_m,
                                          Eigen::VectorXcd& values, Eigen::MatrixX3cd& gradients) const {
  Eigen::VectorXcd all(basis_size(order_ + 1));
  fill(harmonics_, wave, wavenumber_per_m, r_m, all.data());
  values = all.head(size());
  gradients.resize(size(), 3);
  const double half_k = 0.5 * wavenumber_per_m;
  for (int n = 0; n <= order_; ++n) {
    for (int m = -n; m <= n; ++m) {
      const Ladder ladder(n, m);
      Complex dz = -ladder.z_up * all[basis_index(n + 1, m)];
      Complex plus = ladder.plus_up * all[basis_index(n + 1, m + 1)];
      Complex minus = -ladder.minus_up * all[basis_index(n + 1, m - 1)];
      if (std::abs(m) <= n - 1) dz += ladder.z_down * all[basis_index(n - 1, m)];
      if (std::abs(m + 1) <= n - 1) plus += ladder.plus_down * all[basis_index(n - 1, m + 1)];
      if (std::abs(m - 1) <= n - 1) minus -= ladder.minus_down * all[basis_index(n - 1, m - 1)];
      const Eigen::Index i = basis_index(n, m);
      gradients(i, 0) = half_k * (plus + minus);
      gradients(i, 1) = half_k * (plus - minus) * Complex(0.0, -1.0);
      gradients(i, 2) = wavenumber_per_m * dz;
    }
  }
}

Ladder::Ladder(int n, int m) {
  const double up = (2.0 * n + 1.0) * (2.0 * n + 3.0), down = (2.0 * n - 1.0) * (2.0 * n + 1.0);
  const double p = n + m, q = n - m;
  z_up = std::sqrt((q + 1.0) * (p + 1.0) / up);
  plus_up = std::sqrt((p + 1.0) * (p + 2.0) / up);
  minus_up = std::sqrt((q + 1.0) * (q + 2.0) / up);
  z_down = n == 0 ? 0.0 : std::sqrt(p * q / down);
  plus_down = n == 0 ? 0.0 : std::sqrt(std::max(0.0, q * (q - 1.0)) / down);
  minus_down = n == 0 ? 0.0 : std::sqrt(std::max(0.0, p * (p - 1.0)) / down);
}

}  // namespace klang::acoustics
