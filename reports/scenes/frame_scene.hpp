#pragma once
#include <array>
#include <filesystem>
#include <vector>

#include "reports/scenes/drawing_process.hpp"

namespace klang::reports::detail {

/// A frame of a scene's motion (.vtp with the cell array "body") and the box that is looked at.
struct FramePictureRequest {
  std::filesystem::path file;
  std::array<double, 3> low_m{}, high_m{};
};

/// VTK pictures of frames, all from the same side: a colour per body.
DrawnPictures render_frames(const std::vector<FramePictureRequest>& requests, Monitor& monitor);

}  // namespace klang::reports::detail
