#pragma once
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh {

/// The keys of a shape's table: kind, the dimensions of every kind, profile_csv.
std::vector<TomlField> shape_fields(std::string_view table);

/// A shape's table { kind, its dimensions }. profile_csv is relative to the folder. @throws InputError
ShapeSpec read_shape(const TomlTable& table, const std::filesystem::path& folder);

}  // namespace klang::mesh
