#pragma once
#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// "stiffness_only": decay = a omega^2 / 2, Rayleigh's law without mass; a = rayleigh_stiffness_s.
const DampingLaw& stiffness_only_law();

}  // namespace klang::damping
