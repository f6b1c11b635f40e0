#pragma once
#include <Eigen/Core>
#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/foundation/math/spline.hpp"
#include "core/foundation/math/taylor.hpp"
#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::bubble {

/// Where a bubble is after its birth. phi: signed distance of its centre to the surface, negative in the liquid.
/// The undisturbed surface is the plane z = 0, z up.
class BubbleMotion {
 public:
  virtual ~BubbleMotion() = default;
  virtual Taylor phi_m(double age_s) const = 0;
  virtual Eigen::Vector3d position_m(double age_s) const = 0;
  /// Ages at which phi is not smooth, ascending.
  virtual std::vector<double> breaks_s() const = 0;
  /// Time in which phi may change its course; infinite for analytic motion.
  virtual double time_scale_s() const { return std::numeric_limits<double>::infinity(); }
};

enum class RiseKind { kFixed, kConstantSpeed, kTerminal };
constexpr auto words_of(RiseKind) {
  return std::array{Word{RiseKind::kFixed, "fixed"}, Word{RiseKind::kConstantSpeed, "constant"},
                    Word{RiseKind::kTerminal, "terminal"}};
}

struct RiseOptions {
  RiseKind kind = RiseKind::kFixed;
  double speed_m_s = 0.0;          ///< upwards: the constant speed, or that at birth; -100 to 100
  double drag_coefficient = 0.2;   ///< on 4 pi r^2; 1e-3 to 100
  double stop_depth_radii = 1.05;  ///< the bubble rests when its centre is this many radii below the surface; 1 to 100
  void validate() const;           ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"kind", "How a bubble rises"}, self.kind);
    visit({"speed_m_s", "Upward speed: the constant one, or that at birth", between(-100.0, 100.0)}, self.speed_m_s);
    visit({"drag_coefficient", "Of a fixed drag law, on 4 pi r^2", between(1e-3, 100.0)}, self.drag_coefficient);
    visit({"stop_depth_radii", "Depth of the centre, in radii, at which a bubble rests", between(1.0, 100.0)},
          self.stop_depth_radii);
  }
};

/// A bubble that rises straight up, by the closed forms of rise_formulas.hpp, and rests below the surface.
/// @param position_m  of its centre at birth, z < 0
/// @throws InputError: a bubble on the surface or above it
std::shared_ptr<const BubbleMotion> analytic_rise(const Eigen::Vector3d& position_m, double radius_m,
                                                  const RiseOptions& options = {}, const BubbleMedium& medium = {});

/// A path by samples, splined; rests after its last sample.
struct SampledMotion {
  std::vector<double> times_s;               ///< ages, ascending; the first at 0 or before
  std::vector<Eigen::Vector3d> positions_m;  ///< as many, or one for all times
  std::vector<double> phi_m;                 ///< as many, or empty: z of the position
  double cutoff_hz = 200.0;                  ///< low-pass of phi against noise of a computed surface; infinite: none
};
std::shared_ptr<const BubbleMotion> sampled_motion(SampledMotion samples);

}  // namespace klang::bubble
