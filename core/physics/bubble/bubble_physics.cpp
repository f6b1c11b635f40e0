#include "core/physics/bubble/bubble_physics.hpp"

#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/bubble_formulas.hpp"

namespace klang::bubble {

void BubbleMedium::validate() const {
  checked("bubble medium", "liquid_density_kg_m3", liquid_density_kg_m3, 100.0, 2e4);
  checked("bubble medium", "liquid_sound_speed_m_s", liquid_sound_speed_m_s, 100.0, 1e4);
  checked("bubble medium", "liquid_viscosity_pa_s", liquid_viscosity_pa_s, 0.0, 10.0);
  checked("bubble medium", "surface_tension_n_m", surface_tension_n_m, 0.0, 1.0);
  checked("bubble medium", "static_pressure_pa", static_pressure_pa, 1e3, 1e8);
  checked("bubble medium", "heat_capacity_ratio", heat_capacity_ratio, 1.01, 1.7);
  checked("bubble medium", "gas_diffusivity_m2_s", gas_diffusivity_m2_s, 1e-8, 1e-2);
  checked("bubble medium", "gas_density_kg_m3", gas_density_kg_m3, 0.0, 100.0);
}

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
