#pragma once
#include <array>

#include "core/foundation/config/fields.hpp"

namespace klang::fit {

/// How far a number may be believed, by all that the data say beside the fit itself.
enum class Verdict { kNotJudged, kTrusted, kDoubtful, kContradicted };
constexpr auto words_of(Verdict) {
  return std::array{Word{Verdict::kNotJudged, "not_judged"}, Word{Verdict::kTrusted, "trusted"},
                    Word{Verdict::kDoubtful, "doubtful"}, Word{Verdict::kContradicted, "contradicted"}};
}

}  // namespace klang::fit
