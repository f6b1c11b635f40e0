#pragma once
#include <optional>
#include <string>

#include "core/foundation/config/fields.hpp"

namespace klang::reports::detail {

/// A shape of a result in words.
struct ShapeWords {
  std::string words;  ///< "tube, length 505 mm, outer radius 12.5 mm, wall 1 mm"
  std::string kind;   ///< "tube", or empty
};

/// From an object (its numbers, also those of an inner "dims") or a plain text.
ShapeWords shape_words(const JsonText& shape);

/// A line under the sound of a body; empty without a fact.
struct BodyFacts {
  std::optional<double> mass_kg, explained_energy;
  std::size_t n_strikes = 0;
  std::optional<int> n_nodes, n_elements;
  std::optional<bool> none_missing;
};
std::string facts_html(const BodyFacts& facts);

}  // namespace klang::reports::detail
