#pragma once
#include "core/sound/soundbank/soundbank_build.hpp"

namespace klang::test {

inline solid::Material glass() { return solid::from_youngs_modulus(6.2e10, 0.2, 2600.0); }

/// Stout shapes, few modes: a second or two.
inline soundbank::BuildOptions small_options() {
  soundbank::BuildOptions options;
  options.material = glass();
  options.thinnest = 0.5;
  options.tolerance = 0.02;
  options.n_checked_modes = 4;
  options.modes_per_cell = 4;
  options.degree = 8;
  options.check_shapes = 12;
  options.radiation = false;
  return options;
}

inline const soundbank::Soundbank& small_bank() {
  static const soundbank::Soundbank bank = soundbank::build_soundbank(small_options()).bank;
  return bank;
}

}  // namespace klang::test
