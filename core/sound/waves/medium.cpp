#include "core/sound/waves/medium.hpp"

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::acoustics {

void Medium::validate() const { validate_fields("medium", *this); }

double Medium::wavenumber_per_m(double frequency_hz) const { return 2.0 * kPi * frequency_hz / sound_speed_m_s; }

}  // namespace klang::acoustics
