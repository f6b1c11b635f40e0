#pragma once
#include <utility>
#include <vector>

#include "fit/ringdown/partial_table.hpp"

namespace klang::validate::detail {

/// Partials that belong together: index in a, index in b, both rising (partials do not change places). The set of pairs that
/// costs least, where a pair costs (cents / 50)^2 + (level difference / 30 dB)^2, a partial left alone 1, and no pair is
/// further apart than 50 cents.
/// @param a, b     ascending in frequency
/// @param gain_db  level of b above a
std::vector<std::pair<std::size_t, std::size_t>> paired(const std::vector<fit::Partial>& a,
                                                        const std::vector<fit::Partial>& b, double gain_db);

/// Level of b above a [dB]: mean over the pairs weighted by what is known of each, after leaving out those further than 6 dB
/// from the median; its standard deviation beside it. 0 and 0 without pairs.
struct Gain {
  double db = 0.0, std_db = 0.0;
};
Gain gain_between(const std::vector<fit::Partial>& a, const std::vector<fit::Partial>& b,
                  const std::vector<std::pair<std::size_t, std::size_t>>& pairs);

/// Pairs and gain found in turn: first by frequency alone from the energies' ratio, then with levels.
struct Pairing {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  Gain gain;
};
Pairing pairing(const std::vector<fit::Partial>& a, const std::vector<fit::Partial>& b);

}  // namespace klang::validate::detail
