#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace klang::fit::test {

/// How often 95 % intervals hold the truth, over sounds of tubes that a Ritz series made.
struct Coverage {
  int n_sounds = 0;
  std::vector<std::pair<std::string, int>> held;                ///< E, lambda, mu, the two Rayleigh numbers: times held
  double worst_youngs_error = 0.0, worst_rayleigh_error = 0.0;  ///< relative
};

/// Makes n_seeds datasets of a recipe (first_seed, first_seed + 1, ...) of tubes with Rayleigh damping, fits lambda and mu and
/// the Rayleigh numbers to each as `klang fit` does, and counts.
/// @param highest_hz  modes of the fit's models
Coverage interval_coverage(const std::string& recipe_toml, int n_seeds, std::uint64_t first_seed, double highest_hz);

}  // namespace klang::fit::test
