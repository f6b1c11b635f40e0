#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "reports/kit/raster.hpp"

namespace klang::reports::detail {

struct ModeImage {
  RgbaImage image;
  bool tangential = false;  ///< the surface hardly moves along its normal: colour is the size of the motion
};

/// Reads the .vtu once and draws the modes in turn; calls done(position in mode_indices, image). Needs a
/// working DISPLAY: call it in a process that may die.
void draw_modes(const std::filesystem::path& modes_file, const std::vector<int>& mode_indices,
                const std::function<void(std::size_t, const std::optional<ModeImage>&)>& done);

}  // namespace klang::reports::detail
