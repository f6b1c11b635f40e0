#pragma once
#include <vector>

namespace klang::tally {

/// How many of the times [s] lie at or after from_s.
int count_taps(const std::vector<double>& times_s, double from_s);

}  // namespace klang::tally
