#include <cmath>

#include "validate/studies/registry.hpp"

namespace klang::validate {

/// The midpoint rule on the integral of e^x from 0 to 1: order 2.
Study midpoint_study(const StudyOptions& options, Monitor&) {
  Study study;
  study.title = "Midpoint rule";
  study.question = "Does the error of the midpoint rule fall with the square of the step?";
  Series s;
  s.id = "exponential";
  s.title = "e^x from 0 to 1";
  s.reference = "e - 1";
  s.step_words = "steps";
  s.error_words = "relative error";
  s.expected_order = 2.0;
  s.error_tolerance = 1e-3;
  for (std::size_t i = 0; i < level_count(options, 4); ++i) {
    Level level;
    const int n = 8 << i;
    level.n = n;
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += std::exp((k + 0.5) / n) / n;
    level.error = std::abs(sum / (std::exp(1.0) - 1) - 1);
    s.levels.push_back(level);
  }
  study.series.push_back(s);
  return study;
}

}  // namespace klang::validate
