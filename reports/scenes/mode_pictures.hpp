#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"

namespace klang::reports::detail {

struct ModePictureRequest {
  std::filesystem::path modes_file;  ///< .vtu with point vectors "mode_0000", ...
  int mode_index = 0;
};

struct RenderedPicture {
  std::string png;  ///< empty where it could not be made
  int width = 0, height = 0;
  bool tangential = false;  ///< coloured by the size of the motion, which lies within the surface
};

struct RenderResult {
  std::vector<RenderedPicture> pictures;  ///< as the requests
  std::string warning;                    ///< one line, empty when all is well
};

/// Draws the warped, coloured surface of each mode in a process of its own, so that whatever OpenGL or a
/// damaged file does there (VTK aborts without a display) leaves the caller alive. Starts an Xvfb; without
/// one uses DISPLAY.
RenderResult render_modes(const std::vector<ModePictureRequest>& requests, Monitor& monitor);

}  // namespace klang::reports::detail
