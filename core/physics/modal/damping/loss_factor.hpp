#pragma once
#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// "loss_factor": decay = eta omega / 2, the same share of the energy in each cycle.
const DampingLaw& loss_factor_law();

}  // namespace klang::damping
