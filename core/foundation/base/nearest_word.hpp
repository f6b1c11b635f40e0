#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang {

/// "a, b, c".
std::string word_list(const std::vector<std::string>& words);

/// The word among the known ones that was most likely meant: the fewest letters left out, put in, changed or swapped with their
/// neighbour (optimal string alignment; upper case as lower, "_" as "-"), at most one in three of the longer word; empty when
/// none is that near. Among equally near ones the first. Else by parts between "_" or "-": "glass" means soda_lime_glass.
std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

/// "; did you mean WORD", or nothing when no known word is near.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

/// InputError(place, problem, value, "a, b, c") with "; did you mean WORD" at its end where a known word is near.
InputError unknown_word(std::string_view place, std::string_view problem, std::string_view value, std::string_view word,
                        const std::vector<std::string>& known);

}  // namespace klang
