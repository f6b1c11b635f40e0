#pragma once
#include <filesystem>
#include <vector>

#include "reports/scenes/drawing_process.hpp"
#include "reports/scenes/field_files.hpp"

namespace klang::reports::detail {

struct FieldPictureRequest {
  std::filesystem::path file;  ///< .vtp
  FieldKind kind = FieldKind::kSurface;
};

/// VTK pictures of error maps and balloons; low and high are the ends of each colour scale.
DrawnPictures render_fields(const std::vector<FieldPictureRequest>& requests, Monitor& monitor);

}  // namespace klang::reports::detail
