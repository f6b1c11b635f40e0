#pragma once
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports::detail {

/// Cells: a quantity's name with its symbol, a number with its unit, "value ± std".
std::string name_html(const Quantity& quantity);
std::string with_unit(const std::string& text, const Quantity& quantity);
std::string plus_minus(const Number& value, const Number& std, int digits = 4);

/// Tables of a fit's page, as HTML.
std::string parameter_table(const std::vector<Estimate>& parameters);
std::string correlation_table(const ResultData& data);  ///< empty for fewer than two
std::string damping_table(const ResultData& data);
std::string match_table(const std::vector<Match>& matches);
std::string partial_table(const std::vector<Partial>& partials);
std::string mode_list(const std::vector<Predicted>& modes);

}  // namespace klang::reports::detail
