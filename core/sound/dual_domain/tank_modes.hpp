#pragma once
#include <vector>

#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::bubble {

/// A resonance of a box of liquid with rigid walls and floor and a free top:
///   f = c/2 sqrt((m/Lx)^2 + (n/Ly)^2 + ((p + 1/2)/H)^2)
struct TankMode {
  double frequency_hz = 0.0;
  int m = 0, n = 0, p = 0;
};

/// Those in [low_hz, high_hz] of a box as wide as the liquid and as deep as its volume makes it; in rising order, at most 200. Empty without
/// rigid walls. At such a mode the transfer of a liquid without loss is infinite; real walls give way to water, so that their modes
/// are lower and damped (Zheng and James 2009 do not mention them).
std::vector<TankMode> tank_modes(const LiquidBoundary& boundary, double sound_speed_m_s, double low_hz, double high_hz);

}  // namespace klang::bubble
