#pragma once
#include <CLI/App.hpp>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/kit/command.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang::apps {

/// --band-hz, which parse_band() reads. Messages about the fields band.low_hz and band.high_hz name it.
void add_band_option(CLI::App& app, CommonOptions& common, std::string& band,
                     const std::string& help = "LOW:HIGH in Hz");

/// "20:20000" with 0 <= low < high; InputError names the option.
Band parse_band(const std::string& option, const std::string& text);

/// "0.1,0,2.5e-3" with exactly n numbers (n < 0: any).
std::vector<double> parse_numbers(const std::string& option, const std::string& text, int n);

Eigen::Vector3d parse_vector(const std::string& option, const std::string& text);

}  // namespace klang::apps
