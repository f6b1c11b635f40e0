#pragma once
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/run/detail/mode_matches.hpp"

namespace klang::fit::detail {

struct ModeDamping {
  DampingResult damping;
  std::vector<FitParameter> law_parameters;  ///< those asked for, in that order
  /// Of each specimen's predicted modes: the measured partials' with what they radiate, the others' by material and mounts.
  std::vector<std::vector<double>> predicted_decay_per_s;
  std::vector<std::string> warnings;
  double radiation_wall_time_s = 0.0;  ///< where it was asked for
};

/// Stage 5: what takes energy out of the modes: mounts, radiation where it is asked for, and the material's damping law by
/// the decays that were measured of fitted specimens.
/// @param matches  gets the decays by mounts, radiation and the model
ModeDamping fit_mode_damping(const FitProblem& problem, const std::vector<SpecimenResult>& specimens,
                             ModeMatches& matches, Monitor& monitor);

}  // namespace klang::fit::detail
