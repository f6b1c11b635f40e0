#pragma once
#include <vector>

#include "fit/run/detail/measured_data.hpp"
#include "fit/run/fit.hpp"

namespace klang::fit::detail {

/// What the model says the first recording of a specimen sounds like: measured amplitudes and phases on model frequencies and
/// decays; partials without a mode are left out. Empty without a usable recording.
/// @param mode_of_partial  of the specimen's partials (all recordings together), -1: none
audio::Signal fitted_sound(const SpecimenData& data, const SpecimenResult& specimen,
                           const std::vector<int>& mode_of_partial);

}  // namespace klang::fit::detail
