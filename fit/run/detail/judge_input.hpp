#pragma once
#include "fit/judge/judge.hpp"
#include "fit/run/detail/mode_matches.hpp"

namespace klang::fit::detail {

/// Stage 6: what the judge needs to know of a fit.
/// @param result  with material, parameters and specimens filled in
JudgeInput judge_input(const FitProblem& problem, const MaterialFit& fit, const MeasuredData& data,
                       const ModeMatches& matches, const FitOptions& options, const FitResult& result);

}  // namespace klang::fit::detail
