#include "core/physics/tally/tap_count.hpp"

#include <algorithm>

namespace klang::tally {

int count_taps(const std::vector<double>& times_s, double from_s) {
  return static_cast<int>(std::count_if(times_s.begin(), times_s.end(), [&](double t) { return t >= from_s; }));
}

}  // namespace klang::tally
