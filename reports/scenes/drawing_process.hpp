#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "reports/kit/raster.hpp"

namespace klang::reports::detail {

/// A drawn image and what else the caller wants to know about it.
struct Drawing {
  RgbaImage image;
  bool flag = false;
  double low = 0, high = 0;
};

struct DrawnPicture {
  std::string png;  ///< empty where it could not be made
  int width = 0, height = 0;
  bool flag = false;
  double low = 0, high = 0;
};

struct DrawnPictures {
  std::vector<DrawnPicture> pictures;  ///< one per request
  std::string warning;                 ///< one line, empty when all is well
};

/// Draws the requests in any order, handing each to done(request, drawing).
using Drawer = std::function<void(const std::function<void(std::size_t request, const std::optional<Drawing>&)>& done)>;

/// Runs the drawer in a process of its own, so that whatever OpenGL or a damaged file does there (VTK aborts without a
/// display) leaves the caller alive. Starts an Xvfb; without one uses DISPLAY.
/// @param what    for messages and progress: "mode pictures"
/// @param source  what they are drawn from: "mode shapes"
DrawnPictures draw_in_own_process(std::size_t n_requests, const Drawer& drawer, const std::string& what,
                                  const std::string& source, Monitor& monitor);

}  // namespace klang::reports::detail
