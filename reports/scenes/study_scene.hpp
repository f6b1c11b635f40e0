#pragma once
#include <filesystem>
#include <optional>

#include "reports/kit/raster.hpp"
#include "reports/scenes/field_files.hpp"

namespace klang::reports::detail {

struct FieldImage {
  RgbaImage image;
  double low = 0, high = 1;  ///< what the ends of the palette stand for
};

/// Draws a surface or balloon file (.vtp). Needs a working DISPLAY: call it in a process that may die.
std::optional<FieldImage> draw_field(const std::filesystem::path& file, FieldKind kind);

}  // namespace klang::reports::detail
