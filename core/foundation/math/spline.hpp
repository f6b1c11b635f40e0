#pragma once
#include <vector>

#include "core/foundation/math/taylor.hpp"

namespace klang {

/// Cubic spline through values at ascending times, twice continuously differentiable. The slopes at the ends are those
/// of the parabola or cubic through the first and last points (order 4 for four points or more). Outside the times: the
/// end values.
class CubicSpline {
 public:
  CubicSpline() = default;
  /// @param times_s  ascending, one or more, as many as values
  CubicSpline(std::vector<double> times_s, std::vector<double> values);
  /// Value and derivatives; derivatives are 0 outside the times.
  Taylor at(double time_s) const;
  double first_s() const { return times_.front(); }
  double last_s() const { return times_.back(); }

 private:
  std::vector<double> times_, values_, slopes_;
};

/// Noise of measured or computed samples taken out: at each time the local straight line under Gaussian weights, -3 dB
/// at the cut-off. Does not bend straight motion, also at the ends; leaves samples that lie further apart than the
/// filter is long.
/// @param cutoff_hz  above 0; infinite: nothing is done
std::vector<double> low_passed(const std::vector<double>& times_s, const std::vector<double>& values, double cutoff_hz);

}  // namespace klang
