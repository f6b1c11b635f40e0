#pragma once
#include <Eigen/Core>

#include "core/sound/transfer/transfer_layout.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::acoustics {

/// p_i(x) of all modes at many listeners, on the CPU: directions and harmonics once for each centre and listener, Hankel
/// functions upward in n, eight modes to a vector, four listeners to a load, parallel over listeners and groups of modes
/// (SB section 4). The same bits whatever the number of threads, and whether listeners come one by one or together.
class TransferEvaluator {
 public:
  explicit TransferEvaluator(const TransferModel& model);
  int n_modes() const { return layout_.n_modes; }

  /// pressures (n_modes x n_listeners, resized only where the size differs), Pa for unit modal velocity. May be called from
  /// several threads at once; does not allocate once each thread has seen the highest order.
  /// @throws InputError when a listener is at a centre or not finite
  void evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m, Eigen::MatrixXcd& pressures_pa) const;

  /// Floating-point operations that one listener needs (additions and multiplications of the sums, without empty lanes).
  double operations_per_listener() const;

 private:
  TransferLayout layout_;
  SphericalHarmonics harmonics_;
};

}  // namespace klang::acoustics
