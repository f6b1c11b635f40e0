#pragma once
#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// "zener": one relaxation of strength D and time tau, decay = (D/2) omega (omega tau) / (1 + (omega tau)^2): highest loss
/// per cycle where omega tau = 1.
const DampingLaw& zener_law();

}  // namespace klang::damping
