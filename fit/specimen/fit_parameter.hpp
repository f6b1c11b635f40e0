#pragma once
#include <array>
#include <optional>
#include <string>

#include "core/foundation/config/fields.hpp"
#include "fit/specimen/verdict.hpp"

namespace klang::fit {

/// One estimated number. When the data do not determine it, identifiable is false, std and ci95 are empty (or prior-only)
/// and why says which combination is determined instead.
struct FitParameter {
  std::string name;  ///< "lame_lambda_pa", "youngs_modulus_pa", "rayleigh_stiffness_s", "D3.length_m", ...
  double value = 0.0;
  std::optional<double> std;
  std::optional<std::array<double, 2>> ci95;
  bool identifiable = false;
  std::string why;                        ///< empty, or one sentence
  Verdict verdict = Verdict::kNotJudged;  ///< by all that the data say (fit/judge)
  double start_value = 0.0;
  bool given = false;    ///< as it was given: nothing that was fitted moves it
  std::string caveat;    ///< what its std leaves out; empty: nothing
  bool derived = false;  ///< computed from the fitted ones with its covariance (E, nu from lambda, mu)

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "with its unit; of a specimen's own: NAME.length_m"}, self.name);
    visit({"value", "the estimate"}, self.value);
    visit({"std", "its standard deviation"}, self.std);
    visit({"ci95", "its 95 % interval"}, self.ci95);
    visit({"identifiable", "the data determine it"}, self.identifiable);
    visit({"start_value", "where the fit began"}, self.start_value);
    visit({"derived", "computed from the fitted ones with their covariance"}, self.derived);
    visit({"verdict", "whether it may be believed: see judgement"}, self.verdict);
    visit({"given", "it stands as it was given: no part of the fit"}, self.given);
    visit(absent_if_empty({"caveat", "what its std leaves out"}), self.caveat);
    visit({"why", "empty, or why the data do not determine it"}, self.why);
  }
};

}  // namespace klang::fit
