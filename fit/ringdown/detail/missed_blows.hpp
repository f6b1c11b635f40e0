#pragma once
#include <vector>

#include "fit/ringdown/detail/ring_data.hpp"

namespace klang::fit::detail {

/// Times [s, from the signal's start] at which what the partials leave begins anew: it rises by 6 dB and more within 20 ms, is a quarter of
/// what is heard there, and this is within 30 dB of the loudest. Such a blow was not found as a strike (a body that bounces),
/// and the fit bends decays to it. Of the first channel's first difference, in which rumble is small.
std::vector<double> missed_blows(const RingData& data, const std::vector<RingPartial>& rings);

}  // namespace klang::fit::detail
