#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/pitch_formulas.hpp"

namespace klang::bubble {

void PitchModel::validate() const {
  checked("pitch", "k_delta_per_m", k_delta_per_m, 0.0, 1e4);
  checked("pitch", "eta", eta, 0.01, 100.0);
  checked("pitch", "phi0_m", phi0_m, -1.0, -1e-5);
  checked("pitch", "largest_factor", largest_factor, 1.0, 1000.0);
}

}  // namespace klang::bubble
