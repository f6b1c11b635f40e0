#pragma once
#include <cstddef>
#include <utility>

#include "core/foundation/base/check.hpp"

namespace klang {

/// values[index] for any integer index, checked always: an index out of range is a bug that must not read on in silence.
/// @param values  a vector of the standard library or of Eigen
template <class Values, class Index>
decltype(auto) item(Values&& values, Index index) {
  KLANG_CHECK(
      std::in_range<std::size_t>(index) && static_cast<std::size_t>(index) < static_cast<std::size_t>(values.size()),
      "index out of range");
  if constexpr (requires { values.cols(); }) {
    return std::forward<Values>(values)[static_cast<std::ptrdiff_t>(index)];
  } else {
    return std::forward<Values>(values)[static_cast<std::size_t>(index)];
  }
}

}  // namespace klang
