#include "core/physics/modal/damping/assumed_damping.hpp"

#include <cmath>

#include "core/foundation/config/fields.hpp"
#include "core/physics/modal/damping/loss_factor.hpp"

namespace klang::damping {

LawValue assumed_damping() { return {&loss_factor_law(), {kAssumedLossFactor}}; }

std::string assumed_damping_words(const std::string& whose) {
  return "no damping was measured (" + whose + "): a loss factor of 1/" +
         to_text(std::round(1.0 / kAssumedLossFactor)) + " is assumed";
}

}  // namespace klang::damping
