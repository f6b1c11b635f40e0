#pragma once
#include <cstddef>
#include <vector>

#include "core/sound/stage/detail/oscillator_response.hpp"
#include "core/sound/stage/impact_pulses.hpp"

namespace klang::stage::detail {

/// A Gaussian force pulse of unit area and standard deviation s, cut at +-8.5 s (what is cut off: 2e-17 of
/// the area), as weights on Gauss points inside each sample step. The integral of the force against the exact
/// impulse response is then right to round-off in every damping regime (10 points on panels no longer than s
/// nor a sample step).
class ContactPulse {
 public:
  ContactPulse(double time_s, double standard_deviation_s, double sample_rate_hz);
  /// A force that is straight between its steps instead: six Gauss points in each sample step, with weights such that all
  /// polynomials up to degree 5 over it are right, which leaves 1e-6 of the response of a mode at Nyquist's frequency.
  ContactPulse(const ForceHistory& history, double sample_rate_hz);

  long first_sample() const { return first_sample_; }  ///< the body is at rest there (may be negative)
  long last_sample() const { return first_sample_ + static_cast<long>(steps_.size()); }  ///< the force is over there

  struct State {
    long double z = 0, zd = 0;
  };
  /// State at last_sample(); when z is given, z[n - first_sample()] is the displacement at each sample n on
  /// the way.
  State drive(const OscillatorResponse& response, double impulse, std::vector<double>* z) const;

  /// How much of the force is slow for an under-damped mode: 1 - |F(omega)|^2 / F(0)^2, F its spectrum, by the motion that it leaves;
  /// 0 for others.
  double slow_share(const OscillatorResponse& response, const State& at_last_sample, double impulse) const;

  /// The bending under the slow part of the force, impulse (f * g)(t) / omega^2 with g a normal density of standard deviation
  /// 1 / omega, at samples; bending[0] is at first_sample() - reach, 4 standard deviations.
  /// @return reach, samples
  long add_bending(const OscillatorResponse& response, double impulse, std::vector<double>& bending) const;

 private:
  struct Step {
    std::size_t rule;             ///< whose abscissae it uses
    std::vector<double> weights;  ///< integral of the force around each abscissa
  };
  long double step_s_;
  long first_sample_ = 0;
  std::vector<std::vector<double>> rules_;  ///< times from the Gauss points to the end of the step [s]
  void find_moments();

  std::vector<Step> steps_;
  std::vector<double> step_area_, step_time_s_;  ///< of the force in each step, and its centre after first_sample()
  double area_ = 0.0, centre_s_ = 0.0;
};

}  // namespace klang::stage::detail
