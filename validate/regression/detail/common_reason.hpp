#pragma once
#include <string>
#include <vector>

#include "fit/ringdown/partial_table.hpp"

namespace klang::validate::detail {

/// The one sentence for many failed claims, empty where there is none: nearly all strong partials (30 dB) lie higher or lower by
/// one ratio (another sample rate, another speed, another size), or hardly any of them is in the sound (another object).
/// @param expected, found  ascending in frequency
/// @param n_pairs          of the comparison
std::string common_reason(const std::vector<fit::Partial>& expected, const std::vector<fit::Partial>& found,
                          std::size_t n_pairs);

}  // namespace klang::validate::detail
