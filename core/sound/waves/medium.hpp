#pragma once

namespace klang::acoustics {

/// The fluid around a body, without losses; the default is air at 20 C.
struct Medium {
  double density_kg_m3 = 1.2041;   ///< 1e-3 to 1e4
  double sound_speed_m_s = 343.0;  ///< 10 to 1e4
  void validate() const;           ///< InputError
  /// k = 2 pi frequency_hz / sound_speed_m_s
  double wavenumber_per_m(double frequency_hz) const;
};

}  // namespace klang::acoustics
