#pragma once
#include <Eigen/Core>
#include <array>

#include "core/foundation/config/fields.hpp"

namespace klang::events {

/// Why a body was pushed.
enum class ImpulseKind {
  kImpact,   ///< two bodies touch anew, or somebody strikes
  kLasting,  ///< a step of a contact that lasts (resting, sliding, rolling)
  kFracture  ///< a crack opens
};
constexpr auto words_of(ImpulseKind) {
  return std::array{Word{ImpulseKind::kImpact, "impact"}, Word{ImpulseKind::kLasting, "lasting"},
                    Word{ImpulseKind::kFracture, "fracture"}};
}

/// How the force of an impulse J goes over time; its area is J.
///   gaussian  F(t) = J / (s sqrt(2 pi)) exp(-(t - time_s)^2 / (2 s^2)),  s = duration_s
///   hertz     F(t) ~ d(t)^(3/2) with d'' ~ -d^(3/2), d = 0 at time_s and again at time_s + duration_s: two elastic
///             bodies with round surfaces (Hertz 1881) touch for duration_s; the peak is 1.8395 J / duration_s
///   held      F(t) = J / duration_s from time_s to time_s + duration_s: a step of a contact that lasts. Held impulses of a body
///             that follow one another are one force, for voices the polygon through the middles of the steps
/// Each is a Dirac pulse at time_s where duration_s is 0.
enum class PulseShape { kGaussian, kHertz, kHeld };
constexpr auto words_of(PulseShape) {
  return std::array{Word{PulseShape::kGaussian, "gaussian"}, Word{PulseShape::kHertz, "hertz"},
                    Word{PulseShape::kHeld, "held"}};
}

inline constexpr Range kTimesS = between(-1e6, 1e6);
inline constexpr Range kPlacesM = between(-1e6, 1e6);
inline constexpr Range kBodyNumbers = between(0, 999999);

/// A push on a body at a place, both in the body's own frame: that of its mesh, its modes and its transfer. A body's
/// frame moves with it (Motion), so that whoever strikes a body need not know where in the world it is, nor which mesh
/// it has.
struct Impulse {
  double time_s = 0.0;
  double duration_s = 0.0;
  PulseShape shape = PulseShape::kHertz;
  ImpulseKind kind = ImpulseKind::kImpact;
  int body = 0;
  int other = -1;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "centre of a gaussian pulse, begin of a hertz or held pulse", kTimesS, true}, self.time_s);
    visit({"duration_s",
           "standard deviation of a gaussian pulse, contact time of a hertz or held pulse; 0: a Dirac pulse",
           between(0.0, 10.0)},
          self.duration_s);
    visit({"shape", "of the force over time: gaussian, hertz or held"}, self.shape);
    visit({"kind", "impact, lasting (a step of a lasting contact) or fracture"}, self.kind);
    visit({"body", "that is pushed: a row of bodies", kBodyNumbers, true}, self.body);
    visit({"other", "that pushes: a row of bodies, or -1: the world", between(-1, 999999)}, self.other);
    visit({"point_m", "place in the body's frame", kPlacesM, true}, self.point_m);
    visit({"impulse_n_s", "impulse on the body in the body's frame", between(-1e12, 1e12), true}, self.impulse_n_s);
  }
};

/// The one strike of the house: an impulse that somebody asks for, most often with a gaussian pulse.
using Strike = Impulse;

struct GaussianPulse {
  double centre_s = 0.0;
  double standard_deviation_s = 0.0;
};

/// The gaussian pulse of the same area, centre and variance; a gaussian impulse is itself, to the bit. A hertz pulse of
/// contact time T has its centre at T/2 and the standard deviation 0.194075 T; up to 0.5 / T the two spectra differ by
/// less than 0.4 %. A held pulse of length T: T/2 and T / sqrt(12).
GaussianPulse gaussian_pulse(const Impulse& impulse);

}  // namespace klang::events
