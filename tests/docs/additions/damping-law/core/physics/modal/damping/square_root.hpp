#pragma once
#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// "square_root": decay = a sqrt(omega).
const DampingLaw& square_root_law();

}  // namespace klang::damping
