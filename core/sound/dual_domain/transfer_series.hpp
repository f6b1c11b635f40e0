#pragma once
#include <Eigen/Core>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "core/sound/dual_domain/dual_domain.hpp"

namespace klang::bubble {

/// Where a bubble is, at rising times; straight lines between.
struct BubblePath {
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
};

/// Transfer of one moving bubble in a changing liquid (HF sections 5.4, 5.7).
struct TransferSeriesOptions {
  DualDomainOptions solver;
  int fluid_sources = 60, air_sources = 100;
  std::uint64_t seed = 1;
  double frequency_hz = 0.0;
  double radius_m = 0.0;
  /// Amplitude decay of the bubble, beta: steps grow as frame step * e^(beta t), the series ends where the amplitude has fallen
  /// to 1/1000. 0: every frame.
  double decay_per_s = 0.0;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"solver", "How each frame is solved"}, self.solver);
    visit({"fluid_sources", "Quadrupole sources of pass 1 (liquid)", between(1.0, 400.0)}, self.fluid_sources);
    visit({"air_sources", "Quadrupole sources of pass 2 (air)", between(1.0, 1000.0)}, self.air_sources);
    visit({"frequency_hz", "Frequency of the bubble", between(1.0, 1e5)}, self.frequency_hz);
    visit({"radius_m", "Radius of the bubble", between(1e-6, 0.1)}, self.radius_m);
    visit({"decay_per_s", "Decay of the bubble, for growing steps and the end at 1/1000; 0: every frame",
           between(0.0, 1e6)},
          self.decay_per_s);
  }
};

struct TransferAtTime {
  double time_s;
  std::complex<double> pressure;  ///< [Pa per m]
  double fit_error_fluid, fit_error_air;
  bool frozen;  ///< the bubble has left the liquid: the last value
};

struct TransferSeriesResult {
  enum class Status { kNotRun, kDone, kFailed };
  Status status = Status::kNotRun;
  std::string message;
  std::vector<TransferAtTime> steps;
  int n_solves = 0;
  int n_fluid_sources = 0, n_air_sources = 0;  ///< that the coarsest frame carried
  std::uint32_t n_replaced_sources = 0;
};

/// @param frame_time_s  rising; boundary(i) gives the liquid at frame_time_s[i], asked once each, in order
/// Source points are drawn in the first frame of the bubble's life and keep their places (drawn again where the liquid leaves them).
/// The bubble lives from the path's first time on; once it is outside the liquid, or its path has ended, the transfer stays frozen.
/// @throws InputError: the path starts outside the frames or outside the liquid
TransferSeriesResult transfer_series(const std::vector<double>& frame_time_s,
                                     const std::function<LiquidBoundary(std::size_t)>& boundary, const BubblePath& path,
                                     const Eigen::Vector3d& listener_m, const TransferSeriesOptions& options,
                                     Monitor& monitor = silent_monitor());

/// time_s,frequency_hz,re,im a line, as klang bubble synth reads it.
std::string transfer_series_csv(const TransferSeriesResult& result, double frequency_hz);

}  // namespace klang::bubble
