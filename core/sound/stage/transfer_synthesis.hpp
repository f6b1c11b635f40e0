#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/sound/audio/signal.hpp"
#include "core/sound/stage/listener_path.hpp"
#include "core/sound/stage/oscillator_bank.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "core/sound/transfer/transfer_opencl.hpp"

namespace klang::acoustics {

struct TransferSynthesisOptions {
  double sample_rate_hz = 48000.0;  ///< 1000 to 768000
  double duration_s = 3.0;          ///< 0 to 600
  double update_rate_hz = 200.0;    ///< of |p_i| and p_i along the path (SB section 4), 10 to 10000
  /// Sound takes distance / c to arrive, exactly, so that a moving listener hears the Doppler shift. Without it sound is
  /// heard when it is made.
  bool delay = false;
  bool unit_transfer = false;  ///< every |p_i| = 1: sum_i q_i(t), for comparison (SB eq. 8)
  TransferDeviceOptions device = {};
  void validate() const;  ///< InputError
};

struct TransferSynthesisResult {
  enum class Status { kNotRun, kDone };
  Status status = Status::kNotRun;
  audio::Signal sound_pa;  ///< 1 channel, or left and right; in Pa (with unit_transfer in sqrt(kg) m)
  int n_modes_heard = 0;
  int n_modes_without_transfer = 0;  ///< modes of the model that the transfer model does not have: silent
  int n_modes_too_high = 0;          ///< at or above 0.499 of the sample rate: dropped
  std::string device_name, message;  ///< AnyTransferEvaluator
};

/// Pressure at the ears of strikes on a modal body, q_i the modal coordinates and V_i = dq_i/dt as analytic signals:
///   one ear:   sum_i |p_i(x(t))| omega_i q_i(t)                              (SB eq. 8; p_i is per unit velocity here)
///   two ears:  sum_i Re( p_i(x_ear(t)) e^{i k_i r_head(t)} V_i(t) ),         phase between the ears, no Doppler shift
///   delay:     sum_i Re( p_i(x_ear(t)) e^{i k_i r_ear(t)} V_i(t - r_ear(t) / c) ), and |p_i| omega_i q_i(t - r / c) for one
/// with r from the centre of the mode. p_i is evaluated at update_rate_hz and interpolated (Catmull-Rom, without its carrier
/// e^{-ikr}); V_i between samples is exact for a free oscillation.
/// The same bits on any number of threads.
/// @param decay_per_s  of every mode of model
/// @throws InputError when the transfer is not of this model, a listener comes closer to a centre than the body's farthest
///         point (the series does not hold there), or an option is out of range
TransferSynthesisResult synthesise_at_ears(const modal::ModalModel& model, const TransferModel& transfer,
                                           const Eigen::VectorXd& decay_per_s,
                                           const std::vector<modal::Strike>& strikes, const ListenerPath& path,
                                           const TransferSynthesisOptions& options = {});

}  // namespace klang::acoustics
