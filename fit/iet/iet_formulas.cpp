#include "fit/iet/iet_formulas.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::fit::e1876 {
namespace {

double square(double x) { return x * x; }

}  // namespace

double bar_youngs_modulus_pa(const Bar& bar, double flexural_hz, double nu) {
  const double slender_sq = square(bar.thickness_m / bar.length_m);
  const double t1 = 1.0 + 6.585 * (1.0 + 0.0752 * nu + 0.8109 * nu * nu) * slender_sq - 0.868 * square(slender_sq) -
                    8.340 * (1.0 + 0.2023 * nu + 2.173 * nu * nu) * square(slender_sq) /
                        (1.0 + 6.338 * (1.0 + 0.1408 * nu + 1.536 * nu * nu) * slender_sq);
  return 0.9465 * bar.mass_kg * square(flexural_hz) / bar.width_m * std::pow(bar.length_m / bar.thickness_m, 3) * t1;
}

double bar_shear_modulus_pa(const Bar& bar, double torsional_hz) {
  const double flat = bar.width_m / bar.thickness_m, wide = bar.width_m / bar.length_m;
  const double r = (1.0 + flat * flat) / (4.0 - 2.521 / flat * (1.0 - 1.991 / (std::exp(kPi * flat) + 1.0))) *
                       (1.0 + 0.00851 * wide * wide) -
                   0.060 * std::pow(wide, 1.5) * square(flat - 1.0);
  return 4.0 * bar.length_m * bar.mass_kg * square(torsional_hz) / (bar.width_m * bar.thickness_m) * r;
}

double rod_youngs_modulus_pa(const Rod& rod, double flexural_hz, double nu) {
  const double slender_sq = square(rod.diameter_m / rod.length_m);
  const double t1 = 1.0 + 4.939 * (1.0 + 0.0752 * nu + 0.8109 * nu * nu) * slender_sq - 0.4883 * square(slender_sq) -
                    4.691 * (1.0 + 0.2023 * nu + 2.173 * nu * nu) * square(slender_sq) /
                        (1.0 + 4.754 * (1.0 + 0.1408 * nu + 1.536 * nu * nu) * slender_sq);
  return 1.6067 * std::pow(rod.length_m, 3) / std::pow(rod.diameter_m, 4) * rod.mass_kg * square(flexural_hz) * t1;
}

double rod_shear_modulus_pa(const Rod& rod, double torsional_hz) {
  return 16.0 * rod.length_m * rod.mass_kg * square(torsional_hz) / (kPi * square(rod.diameter_m));
}

double disc_youngs_modulus_pa(const Disc& disc, double frequency_hz, double factor, double nu) {
  return 37.6991 * square(frequency_hz * disc.diameter_m / factor) * disc.mass_kg * (1.0 - nu * nu) /
         std::pow(disc.thickness_m, 3);
}

double disc_factor(const Disc& disc, double frequency_hz, double youngs_modulus_pa, double nu) {
  return std::sqrt(disc_youngs_modulus_pa(disc, frequency_hz, 1.0, nu) / youngs_modulus_pa);
}

}  // namespace klang::fit::e1876
