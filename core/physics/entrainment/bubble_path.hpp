#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/bubble/bubble_medium.hpp"
#include "core/physics/bubble/rise_formulas.hpp"
#include "core/physics/liquid/frames.hpp"

namespace klang::entrainment {

/// How hard it is for a bubble to move through the liquid.
enum class Drag {
  kContaminated,  ///< Tomiyama 1998, slightly contaminated: tap water
  kClean,         ///< Tomiyama 1998, pure water
  kDirty,         ///< Tomiyama 1998, fully contaminated
  kPaper          ///< C_d = 0.2 on the area 4 pi r^2 (Zheng and James 2009, eq. 5)
};
constexpr auto words_of(Drag) {
  return std::array{Word{Drag::kContaminated, "contaminated"}, Word{Drag::kClean, "clean"}, Word{Drag::kDirty, "dirty"},
                    Word{Drag::kPaper, "paper"}};
}

struct RiseSettings {
  Drag drag = Drag::kContaminated;
  bubble::BubbleMedium medium;
  double gravity_m_s2 = bubble::kGravityMS2;
};

/// Drag coefficient on pi r^2 at a speed through the liquid. Tomiyama, Kataoka, Zun and Sakaguchi 1998 (JSME Int. J. B 41, 472), with
/// Re = 2 r v rho / mu, Eo = 4 g (rho - rho_g) r^2 / sigma:
///   max{ min[ a/Re (1 + 0.15 Re^0.687), b/Re ], 8/3 Eo / (Eo + 4) },  a, b = 16, 48 (clean), 24, 72 (slightly contaminated),
///   24 and no limit (dirty)
double drag_coefficient(const RiseSettings& settings, double radius_m, double speed_m_s);
/// The speed at which drag and buoyancy balance.
double terminal_speed_m_s(const RiseSettings& settings, double radius_m);

enum class EndKind {
  kSurface,  ///< phi > -r
  kOutlet,
  kEnd,    ///< of the frames
  kMerge,  ///< it became part of another
  kSplit
};
constexpr auto words_of(EndKind) {
  return std::array{Word{EndKind::kSurface, "surface"}, Word{EndKind::kOutlet, "outlet"}, Word{EndKind::kEnd, "end"},
                    Word{EndKind::kMerge, "merge"}, Word{EndKind::kSplit, "split"}};
}
enum class StartKind { kEntrained, kMerged, kSplit };
constexpr auto words_of(StartKind) {
  return std::array{Word{StartKind::kEntrained, "entrained"}, Word{StartKind::kMerged, "merged"},
                    Word{StartKind::kSplit, "split"}};
}

/// A bubble from birth to end.
struct BubblePath {
  std::int64_t id = 0;
  double radius_m = 0.0;
  StartKind start = StartKind::kEntrained;
  EndKind end = EndKind::kEnd;
  std::vector<std::int64_t> parents, children;
  /// Birth and end where they are outside of the samples, in between which all that was told of the bubble lies.
  std::optional<double> told_birth_s, told_end_s;
  /// The samples: one or more, times rising; of our own runs the first at birth and the last at the end.
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
  std::vector<double> phi_m;         ///< signed distance to the surface, below 0 in the liquid
  std::vector<double> frequency_hz;  ///< as many, or empty: by the pitch law from phi
  double birth_s() const { return told_birth_s.value_or(time_s.front()); }
  double end_s() const { return told_end_s.value_or(time_s.back()); }
};

struct Birth {
  double radius_m = 0.0, time_s = 0.0;
  Eigen::Vector3d position_m, velocity_m_s;
};

/// Moves a bubble through the frames (one-way), until it reaches the surface, an outlet or the last frame:
///   (rho_g + rho/2) dv/dt = (rho_g - rho) g + 3/2 rho Du/Dt - 3/8 C_d rho |v - u| (v - u) / r
/// gas and half the displaced liquid as inertia (erratum 28), pressure gradient and added mass of the flow, drag implicit
/// (small bubbles relax in microseconds: erratum 80). Neutral in free fall; u = 0 where frames have no velocity.
/// Steps of at most half a millisecond, the same for every bubble of a run.
BubblePath bubble_path(const liquid::LiquidFrames& frames, const Birth& birth, const RiseSettings& settings);

/// The paths of births, in their order, numbered from 1; frame by frame, so that frames are asked for in rising order.
std::vector<BubblePath> paths_of(const liquid::LiquidFrames& frames, const std::vector<Birth>& births,
                                 const RiseSettings& settings, Monitor& monitor = silent_monitor());

}  // namespace klang::entrainment
