#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"
#include "core/sound/waves/medium.hpp"

namespace klang::validate {

/// A unit source s = -e^{-ikR} / (4 pi R) inside a ball of liquid in air. Series over n in P_n(cos gamma), with
///   s = ik/(4 pi) sum (2n+1) j_n(k b) h_n^(2)(k r) P_n,  r > b  (errata 38).
struct LiquidBall {
  double radius_m = 0.05;
  double frequency_hz = 1000.0;
  double source_m = 0.0;  ///< distance b of the source from the centre, on the z axis, 0 <= b < radius
  acoustics::Medium liquid{1000.0, 1497.0};
  acoustics::Medium air;
};
enum class Coupling {
  kTwoWay,  ///< pressure and normal velocity agree on both sides
  kOneWay   ///< the liquid sees P = 0, the air the liquid's normal velocity: what the dual-domain solver approximates
};
/// Pressure in the air at x, |x| >= radius [per unit source].
std::complex<double> ball_pressure(const LiquidBall& ball, Coupling coupling, const Eigen::Vector3d& x_m);

/// The two-way field of a bubble in any liquid, by turns: boundary elements give the air's pressure on the surface that moves as the
/// liquid does, the liquid is solved again with that pressure on its free surface, until the pressure changes by less than
/// tolerance. Each turn wins three digits and more: air is light. The air's part stands on its own (another method than pass 2);
/// the liquid's is pass 1 with many waves.
struct TwoWayResult {
  bool converged = false;
  std::vector<std::complex<double>> pressure;          ///< at the points, two-way
  std::vector<std::complex<double>> one_way_pressure;  ///< at the points, first turn
  std::vector<double> change;                          ///< of each turn, relative, largest over the points
  bubble::DualDomainResult liquid;                     ///< of the last turn
  int n_elements = 0;
};
struct TwoWayOptions {
  int n_fluid_sources = 8;
  bubble::DualDomainOptions pass = {};
  double tolerance = 1e-9;  ///< relative change of the pressure by a turn
  int max_turns = 8;
};
TwoWayResult two_way_pressure(const bubble::LiquidBoundary& boundary, double frequency_hz,
                              const Eigen::Vector3d& bubble_m, const std::vector<Eigen::Vector3d>& points_m,
                              const TwoWayOptions& options, Monitor& monitor = silent_monitor());

}  // namespace klang::validate
