#pragma once
#include <vector>

#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

/// Says of each ring which other it goes with (what follows from frequencies, decays and amplitudes; nothing is measured anew):
/// - `stage`: two decays at one frequency, one at least twice as fast, their frequencies closer than half the faster one's
///   decay / 2 pi (or than 3 deviations): the body falls in two stages, `early` and `late`.
/// - `beat_hz`: the distance to the loudest other ring within 20 Hz, 2 % and 20 dB, when it is at least the faster decay / 2 pi (half
///   a beat comes before the faster has fallen by 27 dB) and both are not stages of one decay.
/// What is no ring (steady, too short to tell) has neither.
/// @param partials  ascending in frequency
void name_pairs(std::vector<Partial>& partials);

}  // namespace klang::fit
