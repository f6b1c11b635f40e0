#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "fit/specimen/verdict.hpp"

namespace klang::fit {

enum class ReasonKind {
  kMaterialRange,
  kGuess,
  kUntested,
  kScatter,
  kRival,
  kUnmatched,
  kRoom,
  kLeftOut,
  kUnheard,
  kDimension,
  kTakes,
  kSupport,
  kUnits,
};
constexpr auto words_of(ReasonKind) {
  using enum ReasonKind;
  return std::array{Word{kMaterialRange, "material_range"},
                    Word{kGuess, "guess"},
                    Word{kUntested, "untested"},
                    Word{kScatter, "scatter"},
                    Word{kRival, "rival"},
                    Word{kUnmatched, "unmatched"},
                    Word{kRoom, "room"},
                    Word{kLeftOut, "left_out"},
                    Word{kUnheard, "unheard"},
                    Word{kDimension, "dimension"},
                    Word{kTakes, "takes"},
                    Word{kSupport, "support"},
                    Word{kUnits, "units"}};
}

/// One piece of evidence, with its numbers.
struct Reason {
  ReasonKind kind = ReasonKind::kUntested;
  Verdict weight = Verdict::kDoubtful;  ///< trusted: said, but no doubt
  std::string specimen;                 ///< empty: of the whole fit
  std::string subject;                  ///< the parameter, dimension or place that it speaks of
  std::string text;                     ///< one sentence
  std::optional<double> value, expected_low, expected_high;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"kind", "of evidence"}, self.kind);
    visit({"weight", "what it makes of the result by itself; trusted: said, but no doubt"}, self.weight);
    visit(null_if_empty({"specimen", "its name; null: the whole fit"}), self.specimen);
    visit(null_if_empty({"subject", "parameter, dimension or support that it speaks of"}), self.subject);
    visit({"text", "one sentence"}, self.text);
    visit({"value", "found"}, self.value);
    visit({"expected_low", "what it should not be below"}, self.expected_low);
    visit({"expected_high", "what it should not be above"}, self.expected_high);
  }
};

/// The verdict on a fit: the gravest weight among its reasons.
struct Judgement {
  Verdict verdict = Verdict::kNotJudged;
  std::vector<Reason> reasons;  ///< gravest first

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"verdict", "on every number of the fit"}, self.verdict);
    visit({"reasons", "evidence, gravest first"}, self.reasons);
  }
};

}  // namespace klang::fit
