#include "validate/studies/study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/errors.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

std::string brief(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string order_name(const Series& series) { return series.kind == Convergence::kGeometric ? "rate" : "order"; }

bool order_passes(const Series& series) {
  if (!series.order.observed_order) return false;
  const double off = *series.order.observed_order - series.expected_order;
  return (series.higher_is_fine ? -off : std::abs(off)) <= series.order_tolerance;
}

/// The error that the verdict looks at: that of the finest level, or for round-off the largest.
double judged_error(const Series& series) {
  if (series.levels.empty()) return std::nan("");
  if (series.kind != Convergence::kRoundOff) return series.levels.back().error;
  double largest = 0.0;
  for (const Level& level : series.levels) {
    if (!std::isnan(largest) && !(level.error <= largest)) largest = level.error;  // a NaN comes in and stays
  }
  return largest;
}

bool all_at_floor(const Series& series) {
  return series.levels.size() >= 2 && std::all_of(series.order.excluded.begin(), series.order.excluded.end(),
                                                  [](const std::string& why) { return why == "floor"; });
}

void add_gci(Series& series) {
  std::vector<const Level*> used;
  for (std::size_t i = 0; i < series.levels.size(); ++i) {
    if (series.order.excluded[i].empty() && series.levels[i].value) used.push_back(&series.levels[i]);
  }
  if (used.size() < 3 || series.kind != Convergence::kAlgebraic) return;
  std::array<double, 3> h{}, value{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Level& level = *used[used.size() - 1 - k];
    h[k] = level.h_m ? *level.h_m : 1.0 / *level.n;
    value[k] = *level.value;
  }
  series.gci = grid_convergence(h, value);
}

}  // namespace

void judge(Series& series) {
  std::vector<double> step, error;
  for (const Level& level : series.levels) {
    step.push_back(series.kind == Convergence::kAlgebraic && !level.h_m ? 1.0 / *level.n : level.step());
    error.push_back(level.error);
  }
  series.order = estimate_order(step, error, series.kind, series.error_floor);
  series.gci.reset();
  add_gci(series);
  const double reached = judged_error(series);
  const bool small = reached <= series.error_tolerance;
  const std::string error_words =
      "error " + brief("%.2g", reached) + (small ? " ≤ " : " > ") + brief("%.2g", series.error_tolerance);
  if (series.kind == Convergence::kRoundOff) {
    series.passed = small;
    series.verdict = "largest " + error_words;
    return;
  }
  if (all_at_floor(series)) {
    series.passed = small;
    series.verdict = error_words + "; every level is at the floor, no order can be seen";
    return;
  }
  if (!std::isfinite(series.expected_order)) {
    series.passed = small;
    series.verdict = "finest " + error_words + "; no order is expected";
    return;
  }
  const bool ordered = order_passes(series);
  series.passed = small && ordered;
  const std::string expected = brief("%.3g", series.expected_order) + " ± " + brief("%.2g", series.order_tolerance) +
                               (series.higher_is_fine ? " or higher" : "");
  series.verdict =
      (series.order.observed_order ? order_name(series) + " " + brief("%.3f", *series.order.observed_order) +
                                         (ordered ? " within " : " outside ") + expected
                                   : "no " + order_name(series) + " could be fitted (" + expected + " expected)") +
      "; finest " + error_words;
}

bool Study::passed() const {
  return status == StudyStatus::kDone && !series.empty() &&
         std::all_of(series.begin(), series.end(), [](const Series& s) { return s.passed || !s.counts; }) &&
         std::all_of(claims.begin(), claims.end(), [](const Claim& c) { return c.passed; });
}

void StudyOptions::validate() const {
  if (levels != 0 && (levels < 3 || levels > 20))
    throw_violations("study", {{"levels", "", std::to_string(levels), "3 to 20, or 0 for all"}});
}

bool wanted(const StudyOptions& options, const std::string& id) { return id.find(options.only) != std::string::npos; }

std::size_t level_count(const StudyOptions& options, std::size_t n) {
  return options.levels > 0 ? std::min(n, static_cast<std::size_t>(options.levels)) : n;
}

std::vector<Claim> all_claims(const Study& study) {
  std::vector<Claim> claims;
  for (const Series& series : study.series) {
    if (!series.counts) continue;
    if (series.kind != Convergence::kRoundOff && std::isfinite(series.expected_order) && !all_at_floor(series)) {
      Claim order{series.id + "." + order_name(series),
                  series.title + ": errors fall at the expected " + order_name(series),
                  series.order.observed_order.value_or(std::nan("")),
                  series.expected_order,
                  series.order_tolerance,
                  series.order.observed_order,
                  order_passes(series)};
      claims.push_back(std::move(order));
    }
    claims.push_back(judged({series.id + ".error",
                             series.title + ": " + series.error_words,
                             judged_error(series),
                             {},
                             series.error_tolerance,
                             series.order.observed_order,
                             false}));
  }
  claims.insert(claims.end(), study.claims.begin(), study.claims.end());
  return claims;
}

const std::vector<std::string>& study_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const KnownStudy& study : known_studies()) list.push_back(study.name);
    return list;
  }();
  return names;
}

Study run_study(const std::string& name, const StudyOptions& options, Monitor& monitor) {
  options.validate();
  for (const KnownStudy& known : known_studies()) {
    if (known.name != name) continue;
    Study study = known.run(options, monitor);
    study.name = name;
    if (study.series.empty()) throw InputError("converge " + name, "has no series whose name contains", options.only);
    for (Series& series : study.series) judge(series);
    study.status = StudyStatus::kDone;
    return study;
  }
  std::string names;
  for (const std::string& known : study_names()) names += (names.empty() ? "" : ", ") + known;
  throw InputError("converge", "unknown study", name, names);
}

}  // namespace klang::validate
