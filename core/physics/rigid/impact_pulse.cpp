#include "core/physics/rigid/impact_pulse.hpp"

#include <cmath>

namespace klang::rigid {

double contact_modulus_pa(const Skin& a, const Skin& b) {
  const auto compliance = [](const Skin& s) { return (1 - s.poissons_ratio * s.poissons_ratio) / s.youngs_modulus_pa; };
  return 1 / (compliance(a) + compliance(b));
}

double hertz_duration_s(double mass_kg, double radius_m, double contact_modulus_pa, double approach_m_s) {
  static const double constant = 0.8 * std::beta(0.4, 0.5) * std::pow(15.0 / 16.0, 0.4);
  return constant *
         std::pow(mass_kg * mass_kg / (radius_m * contact_modulus_pa * contact_modulus_pa * approach_m_s), 0.2);
}

}  // namespace klang::rigid
