#pragma once
#include <optional>
#include <string>

#include "core/foundation/config/fields.hpp"

namespace klang::fit {

/// What one source of error contributes to the standard deviation of a parameter.
struct BudgetEntry {
  std::string parameter, source;
  std::optional<double> sensitivity, contribution_std, share;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"parameter", "as in parameters"}, self.parameter);
    visit({"source",
           "SPECIMEN.length_m and other dimensions, SPECIMEN.size of a mesh, SPECIMEN.mass_kg, density_kg_m3; "
           "partials: their scatter; mesh: of the "
           "elements; decays"},
          self.source);
    visit({"sensitivity",
           "d ln parameter / d ln source, of given quantities: linear, at this fit's weights of the partials"},
          self.sensitivity);
    visit({"contribution_std",
           "to the parameter's std, which is the root of their sum of squares; null: no tolerance given"},
          self.contribution_std);
    visit({"share", "of the variance, 0 to 1"}, self.share);
  }
};

/// Stands at a number whose given dimensions and mass have no tolerances.
inline constexpr const char* kWithoutTolerances = "without the tolerances of dimensions and mass";

}  // namespace klang::fit
