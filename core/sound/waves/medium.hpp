#pragma once
#include "core/foundation/config/fields.hpp"

namespace klang::acoustics {

/// The fluid around a body, without losses; the default is air at 20 C.
struct Medium {
  double density_kg_m3 = 1.2041;
  double sound_speed_m_s = 343.0;
  void validate() const;  ///< InputError
  /// k = 2 pi frequency_hz / sound_speed_m_s
  double wavenumber_per_m(double frequency_hz) const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"density_kg_m3", "Density of the fluid", between(1e-3, 1e4)}, self.density_kg_m3);
    visit({"sound_speed_m_s", "Sound speed of the fluid", between(10.0, 1e4)}, self.sound_speed_m_s);
  }
};

}  // namespace klang::acoustics
