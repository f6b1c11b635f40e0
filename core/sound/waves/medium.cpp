#include "core/sound/waves/medium.hpp"

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::acoustics {

void Medium::validate() const {
  checked("medium", "density_kg_m3", density_kg_m3, 1e-3, 1e4);
  checked("medium", "sound_speed_m_s", sound_speed_m_s, 10.0, 1e4);
}

double Medium::wavenumber_per_m(double frequency_hz) const { return 2.0 * kPi * frequency_hz / sound_speed_m_s; }

}  // namespace klang::acoustics
