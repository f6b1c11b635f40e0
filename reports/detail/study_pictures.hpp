#pragma once
#include <filesystem>
#include <vector>

#include "reports/detail/drawing_process.hpp"
#include "reports/detail/result_data.hpp"

namespace klang::reports::detail {

struct FieldPictureRequest {
  std::filesystem::path file;  ///< .vtp
  FieldKind kind = FieldKind::kSurface;
};

/// VTK pictures of error maps and balloons; low and high are the ends of each colour scale.
DrawnPictures render_fields(const std::vector<FieldPictureRequest>& requests, Monitor& monitor);

}  // namespace klang::reports::detail
