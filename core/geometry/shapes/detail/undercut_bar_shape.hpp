#pragma once
#include "core/geometry/shapes/shape_kind.hpp"

namespace klang::mesh::detail {

const ShapeKind& undercut_bar_shape();

}  // namespace klang::mesh::detail
