#pragma once
#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// "mass_only": decay = b / 2, Rayleigh's law without stiffness; b = rayleigh_mass_per_s.
const DampingLaw& mass_only_law();

}  // namespace klang::damping
