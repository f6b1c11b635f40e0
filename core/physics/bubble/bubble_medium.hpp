#pragma once
#include "core/foundation/config/fields.hpp"

namespace klang::bubble {

/// A gas bubble's surroundings and filling; the defaults are air in water (Zheng and James 2009, Table 3).
struct BubbleMedium {
  double liquid_density_kg_m3 = 1000.0;    ///< rho
  double liquid_sound_speed_m_s = 1497.0;  ///< c_f
  double liquid_viscosity_pa_s = 8.9e-4;   ///< mu_f
  double surface_tension_n_m = 0.0726;     ///< sigma
  double static_pressure_pa = 101325.0;    ///< p0, around the bubble
  double heat_capacity_ratio = 1.4;        ///< gamma
  double gas_diffusivity_m2_s = 2.122e-5;  ///< D
  double gas_density_kg_m3 = 1.2041;       ///< its weight when it rises
  void validate() const;                   ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"liquid_density_kg_m3", "Density of the liquid", between(100.0, 2e4)}, self.liquid_density_kg_m3);
    visit({"liquid_sound_speed_m_s", "Its sound speed", between(100.0, 1e4)}, self.liquid_sound_speed_m_s);
    visit({"liquid_viscosity_pa_s", "Its shear viscosity", between(0.0, 10.0)}, self.liquid_viscosity_pa_s);
    visit({"surface_tension_n_m", "Surface tension", between(0.0, 1.0)}, self.surface_tension_n_m);
    visit({"static_pressure_pa", "Pressure in the liquid", between(1e3, 1e8)}, self.static_pressure_pa);
    visit({"heat_capacity_ratio", "Of the gas", between(1.01, 1.7)}, self.heat_capacity_ratio);
    visit({"gas_diffusivity_m2_s", "Thermal diffusivity of the gas", between(1e-8, 1e-2)}, self.gas_diffusivity_m2_s);
    visit({"gas_density_kg_m3", "Density of the gas", between(0.0, 100.0)}, self.gas_density_kg_m3);
  }
};

/// Smallest and largest radius: below, the gas is isothermal and tension dominates; above, no bubble stays round.
inline constexpr double kSmallestRadiusM = 1e-5, kLargestRadiusM = 0.05;

/// Which formulas give frequency and damping.
enum class BubbleTheory {
  kLeighton,  ///< gas pressure p0 + 2 sigma/r, adiabatic; thermal damping by Devin's formula with f0 in Hz and g near 1
  kProsperetti,  ///< the exact thermal theory: complex polytropic index at the bubble's own frequency
  kPaper         ///< as Zheng and James 2009 print it (eqs. 36-38): tension lowers the pitch, g = 9.8 and omega0 in psi
};

}  // namespace klang::bubble
