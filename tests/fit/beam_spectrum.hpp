#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "fit/elastic/spectrum_model.hpp"

namespace klang::tests {

/// Closed-form stand-in for a struck tube or bar: pairs (or, for a flat bar, singles) of bending modes with a shear and
/// rotary correction of Timoshenko's form, and torsion that sounds or not.
///   omega^2 = E r^2 (beta / L)^4 / rho / (1 + (r beta / L)^2 (1 + E / (kappa mu))),  torsion omega^2 = c mu (pi j / L)^2 / rho
class BeamSpectrum : public fit::SpectrumModel {
 public:
  BeamSpectrum(double length_m, double gyration_m, bool pairs, double torsion_visibility, bool length_is_free = false,
               int n_bending = 8, double torsion_factor = 1.0)
      : length_(length_m),
        gyration_(gyration_m),
        pairs_(pairs),
        length_free_(length_is_free),
        n_bending_(n_bending),
        torsion_visibility_(torsion_visibility),
        torsion_factor_(torsion_factor) {}

  Eigen::Index n_modes() const override { return n_bending_ * (pairs_ ? 2 : 1) + kTorsion; }
  fit::Spectrum spectrum(const fit::SpectrumPoint& point) const override {
    const auto rows = all(point);
    fit::Spectrum spectrum;
    spectrum.log_angular_frequency_sq.resize(n_modes());
    spectrum.derivative.resize(n_modes(), length_free_ ? 4 : 3);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      spectrum.log_angular_frequency_sq[k] = rows[i].log_omega_sq;
      spectrum.derivative.row(k) << rows[i].by_lambda, rows[i].by_mu, -1.0;
      if (length_free_) spectrum.derivative(k, 3) = rows[i].by_length;
    }
    return spectrum;
  }
  /// Of the order at the nominal aluminium.
  Eigen::VectorXd visibility() const override {
    Eigen::VectorXd v(n_modes());
    const auto rows = all({4.98e10, 2.57e10, 2700.0, {}});
    for (std::size_t i = 0; i < rows.size(); ++i) {
      v[static_cast<Eigen::Index>(i)] = rows[i].torsion ? torsion_visibility_ : 1.0;
    }
    return v;
  }

 private:
  static constexpr int kTorsion = 3;
  struct Row {
    double log_omega_sq, by_lambda, by_mu, by_length;
    bool torsion;
  };
  std::vector<Row> all(const fit::SpectrumPoint& p) const {
    const double l = p.lame_lambda_pa, m = p.lame_mu_pa, s = l + m;
    const double young = m * (3 * l + 2 * m) / s;
    const double young_l = m * m / (s * s), young_m = (3 * l * l + 4 * l * m + 2 * m * m) / (s * s);
    const double length = length_free_ && !p.dimensions.empty() ? p.dimensions[0] : length_;
    std::vector<Row> rows;
    for (int k = 0; k < n_bending_; ++k) {
      const double beta = k == 0 ? 4.730040744862704 : k == 1 ? 7.853204624095838 : kPi * (k + 1.5);
      const double q = std::pow(gyration_ * beta / length, 2), kappa = 0.53;
      const double d = 1 + q * (1 + young / (kappa * m));
      const double base = std::log(young * gyration_ * gyration_ * std::pow(beta / length, 4) / p.density_kg_m3 / d);
      const double by_young = 1 / young - q / (kappa * m) / d, by_m = q * young / (kappa * m * m) / d;
      const double by_length = -4 / length + 2 * q / length * (1 + young / (kappa * m)) / d;
      for (int copy = 0; copy < (pairs_ ? 2 : 1); ++copy) {
        rows.push_back({base, by_young * young_l, by_young * young_m + by_m, by_length, false});
      }
    }
    for (int j = 1; j <= kTorsion; ++j) {
      rows.push_back({std::log(torsion_factor_ * m / p.density_kg_m3 * std::pow(kPi * j / length, 2)), 0.0, 1 / m,
                      -2 / length, true});
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const Row& a, const Row& b) { return a.log_omega_sq < b.log_omega_sq; });
    return rows;
  }
  double length_, gyration_;
  bool pairs_, length_free_;
  int n_bending_;
  double torsion_visibility_, torsion_factor_;
};

}  // namespace klang::tests
