#pragma once
#include <array>
#include <filesystem>
#include <vector>

#include "reports/scenes/drawing_process.hpp"

namespace klang::reports::detail {

/// A bubble in a picture: to scale, coloured by where its pitch lies between 0 (low) and 1 (high).
struct DrawnBubble {
  std::array<double, 3> position_m{};
  double radius_m = 0.0, colour = 0.0;
};

/// A frame of a liquid: .vtp with the cell array "region"; the free surface is shown clear, solids opaque, walls not at all.
struct LiquidPictureRequest {
  std::filesystem::path file;
  std::array<double, 3> box_m{};  ///< [0, box]
  std::vector<DrawnBubble> bubbles;
};

DrawnPictures render_liquid(const std::vector<LiquidPictureRequest>& requests, Monitor& monitor);

}  // namespace klang::reports::detail
