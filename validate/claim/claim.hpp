#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/fields.hpp"

namespace klang::validate {

/// One statement that was put to the test. Accepted only through deviation <= tolerance, so that a NaN does not pass.
struct Claim {
  std::string name;   ///< "ball-p2.order": unique within a study, no spaces
  std::string words;  ///< the statement as a sentence
  double measured = 0.0;
  std::optional<double> reference;       ///< what it should be; empty: an error that should be 0
  double tolerance = 0.0;                ///< largest |measured - reference|, in the same unit
  std::optional<double> observed_order;  ///< where the claim is about convergence
  bool passed = false;
  std::string not_judged = {};  ///< why nothing could be said; empty: it was judged. Never passed then.

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "unique within the result, no spaces"}, self.name);
    visit({"words", "the statement as a sentence"}, self.words);
    visit({"measured", "what was found"}, self.measured);
    visit({"reference", "what it should be; null: an error that should be 0"}, self.reference);
    visit({"tolerance", "largest accepted |measured - reference|"}, self.tolerance);
    visit({"observed_order", "where the claim is about convergence"}, self.observed_order);
    visit({"passed", "whether it holds"}, self.passed);
    visit(null_if_empty({"not_judged", "why nothing could be said; null: it was judged"}), self.not_judged);
  }
};

/// passed = |measured - reference| <= tolerance, with reference 0 where there is none.
Claim judged(Claim claim);

/// One JUnit test suite with a test case per claim, skipped where it was not judged; no time stamps, so that the same claims
/// give the same bytes.
std::string junit_xml(std::string_view suite, const std::vector<Claim>& claims);

}  // namespace klang::validate
