#pragma once
#include <cstdio>
#include <string>
#include <vector>

#include "fit/judge/judge.hpp"

namespace klang::fit::detail {

inline std::string shown(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// What the found material says, held against the preset's range or the guess.
void judge_material(const JudgeInput& input, std::vector<Reason>& reasons);
/// What was heard and not explained, what should have been heard, how takes agree.
void judge_partials(const JudgeInput& input, std::vector<Reason>& reasons);
/// Whether residuals, rivals and numbers of data leave room for belief.
void judge_agreement(const JudgeInput& input, std::vector<Reason>& reasons);

}  // namespace klang::fit::detail
