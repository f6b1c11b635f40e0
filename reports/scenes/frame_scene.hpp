#pragma once
#include <filesystem>
#include <vector>

#include "reports/scenes/drawing_process.hpp"

namespace klang::reports::detail {

/// A frame of a scene's motion (.vtp with the cell array "body") and where its floor is.
struct FramePictureRequest {
  std::filesystem::path file;
  double floor_m = 0.0;
};

/// VTK pictures of frames, all from the same side: a colour per body, lines on the floor, shadows straight below. Each looks at the
/// bodies where they are; of many pieces those stay outside that have flown far and are a twentieth together. A picture's `high` is the distance of the lines [m].
DrawnPictures render_frames(const std::vector<FramePictureRequest>& requests, Monitor& monitor);

}  // namespace klang::reports::detail
