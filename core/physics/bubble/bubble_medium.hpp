#pragma once

namespace klang::bubble {

/// A gas bubble's surroundings and filling; the defaults are air in water (Zheng and James 2009, Table 3).
struct BubbleMedium {
  double liquid_density_kg_m3 = 1000.0;    ///< rho, 100 to 2e4
  double liquid_sound_speed_m_s = 1497.0;  ///< c_f, 100 to 1e4
  double liquid_viscosity_pa_s = 8.9e-4;   ///< shear viscosity mu_f, 0 to 10
  double surface_tension_n_m = 0.0726;     ///< sigma, 0 to 1
  double static_pressure_pa = 101325.0;    ///< p0 of the liquid around the bubble, 1e3 to 1e8
  double heat_capacity_ratio = 1.4;        ///< gamma of the gas, 1.01 to 1.7
  double gas_diffusivity_m2_s = 2.122e-5;  ///< thermal diffusivity D of the gas, 1e-8 to 1e-2
  double gas_density_kg_m3 = 1.2041;       ///< of the gas in the bubble: its weight when it rises; 0 to 100
  void validate() const;                   ///< InputError
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
