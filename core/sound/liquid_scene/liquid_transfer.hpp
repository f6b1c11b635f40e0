#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "core/physics/entrainment/bubble_path.hpp"
#include "core/physics/liquid/frames.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"
#include "core/sound/liquid_scene/transfer_checkpoint.hpp"

namespace klang::liquid_scene {

/// A bubble as it is heard: a sphere that rings at the pitch of its path.
struct HeardBubble {
  std::int64_t id = 0;
  double radius_m = 0.0;                               ///< of the free bubble of the path's first pitch
  double birth_s = 0.0, quiet_s = 0.0, faded_s = 0.0;  ///< amplitude at 1/100: no more transfer is asked for; at 1/1000
};
/// None: no bubble has this pitch, or it was born in the air (phi >= 0; not a number: not known).
std::optional<HeardBubble> heard(const entrainment::BubblePath& path, const stage::BubbleScene& sound);

/// Pitch and place along a path, straight between its samples, held outside.
double pitch_at(const entrainment::BubblePath& path, double time_s);
Eigen::Vector3d place_at(const entrainment::BubblePath& path, double time_s);

/// The largest body of liquid of a surface with the hollows and solids in it; hollows below 27 cells and other bodies (drops in flight) are left out.
bubble::BoundaryMesh main_body(const liquid::LiquidSurface& surface, double cell_m);

/// How a transfer is interrupted and gone on with, between frames.
struct TransferKeep {
  std::optional<TransferCheckpoint> from;  ///< where an earlier run was; of the same paths, frames and scene
  std::function<bool()> due = [] { return false; };
  std::function<void(TransferCheckpoint)> keep;  ///< called where due; times are the caller's
};

/// Transfer of every bubble to the listener's centre over time, until its amplitude is a hundredth; it is held from there on. reciprocal: the ear's field in the air at bins
/// of frequency (bins_per_octave, from 20 Hz) and anew when it has changed, in the liquid on the frame's cells at each bubble's momentary
/// pitch; where its walls are slanting, by waves about its centre at the bins' frequencies. forward: each
/// bubble and frame by itself, at its momentary pitch; half_space: closed form, needs no frames.
LiquidTransfer find_transfer(const liquid::LiquidFrames* frames, const std::vector<entrainment::BubblePath>& paths,
                             const LiquidScene& scene, std::uint64_t seed, Monitor& monitor, TransferKeep keep = {});

}  // namespace klang::liquid_scene
