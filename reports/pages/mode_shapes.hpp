#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reports/kit/report_folder.hpp"

namespace klang::reports::detail {

/// A picture of a mode shape, as a file beside the page and inside it.
struct ModePicture {
  int mode_index = 0;
  double frequency_hz = 0;
  std::string twins;     ///< " and its twin 1", or empty
  std::string measured;  ///< HTML: "; measured 587.9 Hz" for each partial that matches it
  std::string png;
  int width = 0, height = 0;
  bool tangential = false;  ///< coloured by the size of the motion
};

/// A body's modes worth a picture.
struct BodyModes {
  std::string modes_file;               ///< beside the result; empty: no picture
  std::string stem;                     ///< of the pictures: "mode-D3"
  std::string kind;                     ///< of the shape: bodies of one kind look alike
  std::vector<ModePicture> candidates;  ///< by rising frequency, of twins the first (without_twins)
};

/// By rising frequency: of modes closer than 0.03 % the first stays and names the others.
std::vector<ModePicture> without_twins(const std::vector<ModePicture>& modes);

/// Draws the most telling modes of the bodies, options().max_mode_pictures at most, and adds them to the folder: one of each
/// body; then, where all are of one kind and would look alike, the first one's others; then one more of each in turn.
/// @return pictures of each body
std::vector<std::vector<ModePicture>> mode_pictures(const std::vector<BodyModes>& bodies, ReportFolder& folder);

/// The pictures of a body with their captions; empty without one.
std::string shapes_html(const std::vector<ModePicture>& pictures);

}  // namespace klang::reports::detail
