#pragma once
#include <complex>
#include <string>
#include <vector>

#include "core/sound/audio/signal.hpp"
#include "core/sound/stage/listener.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/stage/rendering.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "core/sound/transfer/transfer_opencl.hpp"

namespace klang::stage {

struct RadiatingVoiceOptions {
  double update_rate_hz = 200.0;  ///< of |p_i| and p_i along the path (SB section 4), 10 to 10000
  bool unit_transfer = false;     ///< every |p_i| = 1: sum_i q_i(t), for comparison (SB eq. 8)
  opencl::DeviceChoice device = {};
  const ImpactPulses* pulses = nullptr;  ///< modal_impulses(); must outlive the voice
};

/// Pressure at the ears of a modal body that is pushed [Pa] (with unit_transfer in sqrt(kg) m), q_i the modal
/// coordinates and V_i = dq_i/dt as analytic signals:
///   one ear:   sum_i |p_i(x(t))| omega_i q_i(t)                              (SB eq. 8; p_i is per unit velocity here)
///              modes of one pitch (pairs of round bodies) keep their phases against each other, without which two that
///              cancel nowhere would: Re( p_i(x(t)) e^{i k_i r(t)} u* omega_i Q_i(t) ), dQ_i/dt = V_i, u one phase for all of
///              them (the printed form loses such a pair for one blow in four; docs/errata.md)
///   two ears:  sum_i Re( p_i(x_ear(t)) e^{i k_i r_head(t)} V_i(t) ),         phase between the ears, no Doppler shift
///   delay:     sum_i Re( p_i(x_ear(t)) e^{i k_i r_ear(t)} V_i(t - r_ear(t) / c) ), one ear: |p_i| omega_i q_i(t - r / c)
/// Of q_i under a blow what is slow against the mode's period makes no sound (Heard::kRinging).
/// with r from the centre of the mode. A head takes p_i at its centre, times its shadow, with its delays for those of
/// the ears. Where the body has poses, places are taken in its frame at the time of hearing: what it moves while sound
/// is on its way is left out. p_i is evaluated at update_rate_hz and interpolated (Catmull-Rom, without its carrier
/// e^{-ikr}); V_i between samples is exact for a free oscillation. Over-damped modes and modes at or above
/// audio::highest_rendered_hz are silent. A body that breaks fades within half a millisecond.
class RadiatingVoice : public Voice {
 public:
  struct Report {
    int n_modes_heard = 0;
    int n_modes_without_transfer = 0;  ///< modes of the model that the transfer model does not have: silent
    int n_modes_too_high = 0;          ///< at or above audio::highest_rendered_hz: dropped
    std::string device_name, message;  ///< AnyTransferEvaluator
  };

  /// model and transfer must outlive the voice.
  /// @param body         whose impulses and poses it plays: a row of the log's bodies
  /// @param decay_per_s  of every mode of model
  /// @throws InputError when the transfer is not of this model or an option is out of range. add_to() also throws when
  ///         a listener comes
  ///         closer to a centre than the body's farthest point (the series does not hold there), or has no place
  RadiatingVoice(int body, const modal::ModalModel& model, const acoustics::TransferModel& transfer,
                 Eigen::VectorXd decay_per_s, const RadiatingVoiceOptions& options = {});
  void add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) override;
  const Report& report() const { return report_; }  ///< of the last add_to()

 private:
  struct Work;
  struct Stretch {
    Eigen::Index begin, end;  // frames
    std::size_t first_mode, last_mode;
  };
  void choose_modes(Work& work, double sample_rate_hz);
  void fill_gains(Work& work, const Listener& listener);
  void align_one_ear(Work& work) const;
  std::complex<double> head_gain(const Work& work, const Listener& listener, int ear, std::size_t mode,
                                 double time_s) const;
  void add_stretch(const Work& work, const Listener& listener, double sample_rate_hz, Stretch stretch,
                   Eigen::MatrixXd& sound) const;

  int body_;
  const modal::ModalModel& model_;
  const acoustics::TransferModel& transfer_;
  Eigen::VectorXd decay_per_s_;
  RadiatingVoiceOptions options_;
  Report report_;
};

struct TransferSynthesisOptions {
  double sample_rate_hz = 48000.0;  ///< 1000 to 768000
  double duration_s = 3.0;          ///< 0 to 600
  RadiatingVoiceOptions voice = {};
};

struct TransferSynthesisResult {
  enum class Status { kNotRun, kDone };
  Status status = Status::kNotRun;
  audio::Signal sound_pa;  ///< 1 channel, or left and right
  RadiatingVoice::Report heard;
};

/// Sound of strikes on a modal body at a listener: render() with one RadiatingVoice.
TransferSynthesisResult synthesise_at_ears(const modal::ModalModel& model, const acoustics::TransferModel& transfer,
                                           const Eigen::VectorXd& decay_per_s,
                                           const std::vector<events::Strike>& strikes, const Listener& listener,
                                           const TransferSynthesisOptions& options = {});

/// distance_m from the centre of the mode that radiates most power, where its far field is strongest; along z where no
/// mode radiates.
Eigen::Vector3d default_listener_m(const acoustics::TransferModel& model, double distance_m);

}  // namespace klang::stage
