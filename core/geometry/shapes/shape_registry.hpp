#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/shapes/shape_kind.hpp"

namespace klang::mesh {

/// Every kind of shape, in the order that lists show.
const std::vector<const ShapeKind*>& registered_shapes();

/// @throws InputError for an unknown kind (lists the known ones)
const ShapeKind& find_shape(std::string_view kind);

/// The table of kinds, dimensions, ranges and meanings in Markdown: docs/shapes.md.
std::string shapes_table();

}  // namespace klang::mesh
