#pragma once
#include <string>
#include <vector>

#include "fit/run/fit_document.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports::detail {

/// A row of partials.csv.
struct PartialRow {
  std::string specimen;
  fit::PartialRecord partial;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"specimen", "its name, or the recording's"}, self.specimen);
    fit::PartialRecord::describe(self.partial, visit);
  }
};

ShownEstimate shown(const fit::FitParameter& parameter);

/// Cells: a quantity's name with its symbol, a number with its unit, "value ± std".
std::string name_html(const Quantity& quantity);
std::string with_unit(const std::string& text, const Quantity& quantity);
std::string plus_minus(const Number& value, const Number& std, int digits = 4);

/// Tables of a fit's page, as HTML.
std::string parameter_table(const std::vector<fit::FitParameter>& parameters);
std::string budget_table(const fit::FitDocument& data);       ///< empty without one
std::string correlation_table(const fit::FitDocument& data);  ///< empty for fewer than two
std::string damping_table(const fit::FitDocument& data);
/// @param heard  partials of the spectrum on the same part of the page: rows get buttons that play them; empty: none
std::string match_table(const std::vector<fit::MatchRecord>& matches, const std::vector<fit::Partial>& heard = {});
std::string partial_table(const std::vector<fit::Partial>& partials, const std::vector<fit::Partial>& heard = {});
std::string mode_list(const std::vector<fit::PredictedRecord>& modes);

}  // namespace klang::reports::detail
