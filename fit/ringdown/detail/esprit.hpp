#pragma once
#include <Eigen/Core>
#include <vector>

#include "fit/ringdown/detail/sub_band_fit.hpp"

namespace klang::fit::detail {

/// Signal subspace of a sub-band, from which poles of any order can be read: starting values for refine().
/// The bins are tapered at the band's edges and brought back to the time domain (a demodulated, decimated
/// signal of n_bins samples over the window), whose Hankel matrix is decomposed once. Source: Roy and Kailath
/// 1989, IEEE Trans. ASSP 37, 984-995 (total least squares form).
class EspritSubspace {
 public:
  explicit EspritSubspace(const SubBand& band);
  Eigen::Index max_order() const { return max_order_; }
  /// order poles, unsorted; empty when the order is too high for the data.
  std::vector<Pole> poles(Eigen::Index order) const;

 private:
  Eigen::MatrixXcd vectors_;  ///< columns by falling singular value
  Eigen::Index max_order_ = 0;
  double step_s_ = 0.0;
  double low_hz_ = 0.0;
};

}  // namespace klang::fit::detail
