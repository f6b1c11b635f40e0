#include "core/physics/bubble/bubble_physics.hpp"

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/bubble/bubble_formulas.hpp"

namespace klang::bubble {

void BubbleMedium::validate() const { validate_fields("bubble medium", *this); }

BubbleOscillation bubble_oscillation(double radius_m, const BubbleMedium& medium, BubbleTheory theory) {
  checked("bubble", "radius_m", radius_m, kSmallestRadiusM, kLargestRadiusM);
  medium.validate();
  const double omega0 = undamped_angular_frequency_rad_s(medium, theory, radius_m);
  const BubbleDamping<double> damping = bubble_damping(medium, theory, radius_m, omega0);
  const double damped_sq = (omega0 - damping.decay_per_s) * (omega0 + damping.decay_per_s);
  const bool oscillates = omega0 > 0.0 && damping.decay_per_s >= 0.0 && damping.delta_thermal >= 0.0 && damped_sq > 0.0;
  if (!oscillates) {  // also where a root was not real
    throw InputError("bubble", "does not ring, or the formulas do not hold for it",
                     "radius " + to_text(radius_m) + " m", "a larger radius, or Prosperetti's thermal theory");
  }
  BubbleOscillation result;
  result.undamped_frequency_hz = omega0 / (2.0 * kPi);
  result.damped_frequency_hz = std::sqrt(damped_sq) / (2.0 * kPi);
  result.decay_per_s = damping.decay_per_s;
  result.delta_radiation = damping.delta_radiation;
  result.delta_viscous = damping.delta_viscous;
  result.delta_thermal = damping.delta_thermal;
  result.polytropic_index = theory == BubbleTheory::kProsperetti ? gas_response(medium, radius_m, omega0).real / 3.0
                                                                 : medium.heat_capacity_ratio;
  return result;
}

double bubble_radius_m(double undamped_frequency_hz, const BubbleMedium& medium, BubbleTheory theory) {
  const auto frequency = [&](double radius_m) {
    return bubble_oscillation(radius_m, medium, theory).undamped_frequency_hz;
  };
  double small = kSmallestRadiusM, large = kLargestRadiusM;
  if (!(undamped_frequency_hz <= frequency(small) && undamped_frequency_hz >= frequency(large))) {
    throw_violations("bubble", {{"frequency_hz", "belongs to no bubble", to_text(undamped_frequency_hz),
                                 to_text(frequency(large)) + " to " + to_text(frequency(small)) + " Hz"}});
  }
  for (int turn = 0; turn < 200 && large - small > 1e-15 * large; ++turn) {
    const double middle = 0.5 * (small + large);
    (frequency(middle) > undamped_frequency_hz ? small : large) = middle;
  }
  return 0.5 * (small + large);
}

double entrainment_velocity_m_s(double radius_m, const BubbleMedium& medium, BubbleTheory theory) {
  const double omega0 = 2.0 * kPi * bubble_oscillation(radius_m, medium, theory).undamped_frequency_hz;
  return 2.0 * medium.surface_tension_n_m / (radius_m * radius_m * medium.liquid_density_kg_m3 * omega0);
}

double printed_entrainment(double radius_m, const BubbleMedium& medium) {
  checked("bubble", "radius_m", radius_m, kSmallestRadiusM, kLargestRadiusM);
  const double mass_kg = 4.0 * kPi * medium.liquid_density_kg_m3 * radius_m * radius_m * radius_m;
  return 2.0 * medium.surface_tension_n_m / (radius_m * mass_kg);
}

}  // namespace klang::bubble
