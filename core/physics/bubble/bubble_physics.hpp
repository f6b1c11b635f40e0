#pragma once
#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::bubble {

/// How a bubble at rest far from every surface rings: exp(-decay_per_s t) cos(2 pi damped_frequency_hz t).
struct BubbleOscillation {
  double undamped_frequency_hz = 0.0;
  double damped_frequency_hz = 0.0;  ///< what is heard: sqrt(omega0^2 - decay^2) / 2 pi
  double decay_per_s = 0.0;          ///< of the amplitude
  double delta_radiation = 0.0, delta_viscous = 0.0, delta_thermal = 0.0;
  double polytropic_index =
      0.0;  ///< of the gas at that frequency; the heat capacity ratio unless Prosperetti's theory is used
};

/// @param radius_m  1e-5 to 0.05
/// @throws InputError: a radius or medium out of range; a bubble so small that the chosen formulas have no real
/// solution Source: Leighton 1994, The Acoustic Bubble; Zheng and James 2009, appendix A, corrected (docs/errata.md).
BubbleOscillation bubble_oscillation(double radius_m, const BubbleMedium& medium = {},
                                     BubbleTheory theory = BubbleTheory::kLeighton);

/// The radius of a bubble that rings at this frequency when it is not damped.
/// @throws InputError for a frequency that no bubble between the smallest and the largest radius has
double bubble_radius_m(double undamped_frequency_hz, const BubbleMedium& medium = {},
                       BubbleTheory theory = BubbleTheory::kLeighton);

/// Excitation of a newly closed bubble by the Laplace pressure p = 2 sigma / r, as radial velocity at onset [m/s].
///   pressure step: p / (rho r omega0), that is the force 4 pi r^2 p for a time 1/omega0 on the mass 4 pi rho r^3;
///                  the amplitude is then p / (rho r omega0 omega_d), 3.4e-7 m for a millimetre
double entrainment_velocity_m_s(double radius_m, const BubbleMedium& medium = {},
                                BubbleTheory theory = BubbleTheory::kLeighton);

/// The same as Zheng and James 2009 print it, p / (4 pi rho r^3): its unit is 1/(m s) times that of a velocity, so that
/// only ratios between bubbles mean anything, and small bubbles are too loud by r^-3.
double printed_entrainment(double radius_m, const BubbleMedium& medium = {});

}  // namespace klang::bubble
