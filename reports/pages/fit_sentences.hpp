#pragma once
#include <string>
#include <vector>

#include "fit/run/fit_document.hpp"

namespace klang::reports::detail {

/// How far matches are off, of the specimens that were fitted or of those that were predicted.
struct MatchSummary {
  std::size_t n_partials = 0, n_matched = 0;
  double rms_cents = 0.0;
  const fit::MatchRecord* worst = nullptr;  ///< nullptr without a match
};
MatchSummary match_summary(const fit::FitDocument& data, bool predicted);

/// Sentences that say what came out; HTML.
std::vector<std::string> fit_sentences(const fit::FitDocument& data);

}  // namespace klang::reports::detail
