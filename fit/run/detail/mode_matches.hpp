#pragma once
#include <vector>

#include "fit/run/detail/material_fit.hpp"

namespace klang::fit::detail {

struct ModeMatches {
  std::vector<std::vector<int>> mode_of_partial;  ///< of each specimen: 0-based elastic mode; -1: none
  std::vector<PartialMatch> matches;              ///< decays of the model are not filled in yet
  std::vector<std::string> warnings;
};

/// Stage 4: the mode of each partial, and how far measured and model frequency are apart. A specimen that is only
/// predicted gets the standard deviation of each prediction too.
/// @param specimens  with partials and predicted frequencies
ModeMatches match_modes(const MaterialFit& fit, const std::vector<SpecimenResult>& specimens);

}  // namespace klang::fit::detail
