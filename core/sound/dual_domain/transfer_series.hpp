#pragma once
#include <Eigen/Core>
#include <complex>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/sound/dual_domain/dual_domain.hpp"
#include "core/sound/dual_domain/reciprocal.hpp"

namespace klang::bubble {

/// Where a bubble is, at rising times; straight lines between.
struct BubblePath {
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
};

enum class TransferMethod {
  kForward,    ///< the bubble's field in the liquid, then the air by sources: solve_dual_domain
  kReciprocal  ///< the ear's field in the air by boundary elements, then in the liquid: reciprocal_transfer
};
constexpr auto words_of(TransferMethod) {
  return std::array{Word{TransferMethod::kForward, "forward"}, Word{TransferMethod::kReciprocal, "reciprocal"}};
}

/// Transfer of one moving bubble in a changing liquid (HF sections 5.4, 5.7).
struct TransferSeriesOptions {
  DualDomainOptions solver;
  TransferMethod method = TransferMethod::kForward;
  int air_vertices = 1000;  ///< of the boundary elements, also for the error of the forward method
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
    visit({"method", "forward: bubble to ear; reciprocal: ear to bubble, one solve for all bubbles and far more exact"},
          self.method);
    visit({"air_vertices", "Vertices of the air's boundary elements at most (method reciprocal, error_estimate)",
           between(100.0, 20000.0)},
          self.air_vertices);
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
  double fit_error_fluid;
  std::optional<double> fit_error_air;  ///< of the forward method
  bool frozen;                          ///< the bubble has left the liquid: the last value
};

struct TransferSeriesResult {
  enum class Status { kNotRun, kDone, kFailed };
  Status status = Status::kNotRun;
  std::string message;
  std::vector<TransferAtTime> steps;
  int n_solves = 0;
  int n_fluid_sources = 0, n_air_sources = 0;  ///< that the coarsest frame carried
  std::uint32_t n_replaced_sources = 0;
  std::optional<double> error_estimate;  ///< relative, at the first time; none: not found (paper's formulas)
};

/// Relative error of a pressure that was found by any method: its distance to the corrected reciprocal one and that one's own estimate.
double error_estimate(std::complex<double> pressure, const ReciprocalTransfer& reference);

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
