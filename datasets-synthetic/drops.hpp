#pragma once
#include "datasets-synthetic/drop_recipe.hpp"
#include "datasets-synthetic/recipe.hpp"

namespace klang::datasets {

/// Sound of one bubble as a small far source: strength * r^2 q''(t) * entrainment velocity, from its onset until its
/// amplitude is a millionth, at the recording's frames. q by integrate_oscillator (order 8), not by the closed forms
/// that a fit uses.
struct DropSound {
  Eigen::Index first_frame = 0;
  Eigen::VectorXd samples;
  double ring_mean_square = 0.0;  ///< from the onset until the amplitude of the sound is a tenth
  double amplitude = 0.0;         ///< of the envelope at the onset
  double life_s = 0.0;            ///< until the amplitude of q is a thousandth
  std::vector<double> time_s, frequency_hz, decay_per_s, phi_m;  ///< truth each millisecond of its life, from the onset
};
DropSound drop_sound(const Drop& drop, const DropRecipe& recipe);

/// Recordings and truth of a recipe of kind "drops"; specimen_toml stays empty.
Dataset make_drops(std::string_view toml, const std::string& name, std::uint64_t seed,
                   Monitor& monitor = silent_monitor());

}  // namespace klang::datasets
