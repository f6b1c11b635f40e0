#pragma once
#include <optional>
#include <vector>

#include "core/physics/bubble/time_series.hpp"
#include "core/physics/entrainment/bubble_path.hpp"
#include "core/physics/liquid/frames.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"

namespace klang::liquid_scene {

/// A bubble as it is heard: a sphere that rings at the pitch of its path.
struct HeardBubble {
  std::int64_t id = 0;
  double radius_m = 0.0;                ///< of the free bubble of the path's first pitch
  double birth_s = 0.0, faded_s = 0.0;  ///< amplitude at 1/1000
};
/// None: no bubble has this pitch.
std::optional<HeardBubble> heard(const entrainment::BubblePath& path, const stage::BubbleScene& sound);

/// Pitch and place along a path, straight between its samples, held outside.
double pitch_at(const entrainment::BubblePath& path, double time_s);
Eigen::Vector3d place_at(const entrainment::BubblePath& path, double time_s);

/// The largest body of liquid of a surface with the hollows and solids in it; hollows below 27 cells and other bodies (drops in flight) are left out.
bubble::BoundaryMesh main_body(const liquid::LiquidSurface& surface, double cell_m);

struct LiquidTransfer {
  std::vector<std::vector<bubble::TransferSeries::Row>> rows;  ///< of each path; empty: it is not heard
  std::int64_t n_solves = 0;
  std::optional<double> error_estimate;  ///< relative, median of samples of the solves
  std::size_t n_half_space = 0;          ///< bubbles that were never in the main body: by half_space_transfer
  std::size_t n_bad_frames = 0;          ///< left out: their surface is no closed boundary
  std::string bad_frame;                 ///< why, of the first
  std::vector<double> modes_hz;          ///< of the tank, in the first frame that was solved, up to 20 kHz
};

/// Transfer of every bubble to the listener's centre over time, only where it sounds. reciprocal: the ear's field in the air at bins
/// of frequency (bins_per_octave, from 20 Hz) and anew when it has changed, in the liquid on the frame's cells at each bubble's momentary
/// pitch; where solids or slanting walls stand in the liquid, by waves about its centre at the bins' frequencies. forward: each
/// bubble and frame by itself, at its momentary pitch; half_space: closed form, needs no frames.
LiquidTransfer find_transfer(const liquid::LiquidFrames* frames, const std::vector<entrainment::BubblePath>& paths,
                             const LiquidScene& scene, std::uint64_t seed, Monitor& monitor);

}  // namespace klang::liquid_scene
