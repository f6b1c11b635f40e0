#pragma once
#include <cstddef>

namespace klang::fracture::detail {

/// A number of a node or element as an index.
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace klang::fracture::detail
