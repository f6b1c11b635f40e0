#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/foundation/base/conventions.hpp"

namespace klang::apps {

/// "20:20000" with 0 <= low < high; InputError names the option.
Band parse_band(const std::string& option, const std::string& text);

/// "0.1,0,2.5e-3" with exactly n numbers (n < 0: any).
std::vector<double> parse_numbers(const std::string& option, const std::string& text, int n);

Eigen::Vector3d parse_vector(const std::string& option, const std::string& text);

}  // namespace klang::apps
