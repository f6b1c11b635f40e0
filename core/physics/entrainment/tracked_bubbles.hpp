#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/physics/entrainment/bubble_path.hpp"

namespace klang::entrainment {

/// trackedBubInfo, the text in which trackers of bubbles (FluidSound, WaveBlender, BubbleGym) hand on their finds:
///   Bub ID RADIUS
///     Start: N|M|S TIME PARENTS...        entrained, merged from, split from
///     TIME FREQUENCY X Y Z [PRESSURE [DEPTH]]
///     End: M|S|C TIME CHILDREN...         merged into, split into, collapsed or at the end of what was tracked
/// A bubble is born at Start: and ends at End:, with the place and pitch of its first and last sample where these lie within.
/// y is up there: its (x, y, z) is our (x, z, -y). Names that end in .xz are compressed (liblzma).
struct TrackedBubbles {
  std::vector<BubblePath> paths;  ///< as they stand in the file; phi = -DEPTH, NaN where there is none
  std::size_t n_without_frequency =
      0;                       ///< samples left out: a frequency that is missing, 0 or not a number is not guessed
  std::size_t n_left_out = 0;  ///< bubbles of which no sample was left
  std::size_t n_outside =
      0;  ///< bubbles that have a sample before Start: or after End:; these begin and end with their samples
};
/// @throws InputError with file and line
TrackedBubbles read_tracked_bubbles(const std::filesystem::path& path);
TrackedBubbles parse_tracked_bubbles(const std::string& text, const std::string& name);

/// The same, numbers in their shortest exact form, so that reading and writing again gives the same bytes. Pressure stands as 0 where a
/// depth follows. What ended at the surface, an outlet or with the frames is C.
std::string tracked_bubbles_text(const std::vector<BubblePath>& paths);
void write_tracked_bubbles(const std::filesystem::path& path, const std::vector<BubblePath>& paths);

}  // namespace klang::entrainment
