#pragma once
#include <array>
#include <optional>
#include <string>

namespace klang::fit {

/// One estimated number. When the data do not determine it, identifiable is false, std and ci95 are empty (or prior-only)
/// and why says which combination is determined instead.
struct FitParameter {
  std::string name;  ///< "lame_lambda_pa", "youngs_modulus_pa", "rayleigh_stiffness_s", "D3.length_m", ...
  double value = 0.0;
  std::optional<double> std;
  std::optional<std::array<double, 2>> ci95;
  bool identifiable = false;
  std::string why;  ///< empty, or one sentence
  double start_value = 0.0;
  bool derived = false;  ///< computed from the fitted ones with its covariance (E, nu from lambda, mu)
};

}  // namespace klang::fit
