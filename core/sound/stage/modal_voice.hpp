#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "core/physics/events/impulse.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/stage/oscillator_bank.hpp"
#include "core/sound/stage/rendering.hpp"

namespace klang::stage {

/// Impulse of each mode (n_modes) by an impulse at a place of the body's frame: u_i(point) . impulse.
using ModalPush = std::function<Eigen::VectorXd(const Eigen::Vector3d& point_m, const Eigen::Vector3d& impulse_n_s)>;

/// A model's modes, pushed at the node of its surface that is nearest to the place (the lowest number among equals).
/// The model must outlive the function.
ModalPush push_at_nearest_node(const modal::ModalModel& model);

/// The modes of a body that rings when it is pushed.
struct RingingBody {
  Eigen::VectorXd angular_frequency_rad_s;  ///< undamped
  Eigen::VectorXd decay_per_s;
  Eigen::MatrixXd gain;  ///< n_modes x 1, for every channel alike, or n_modes x n_channels: sound per modal coordinate
  ModalPush push;
  Heard heard = Heard::kRinging;  ///< kMotion: also the bending under slow blows, as a pickup has it
  /// Angular frequency with damping; 0 for an over-damped mode, which does not ring.
  double damped_rad_s(Eigen::Index mode) const;
};

/// Some modes of a body that are pushed.
struct PushedModes {
  std::vector<Eigen::Index> numbers;                     ///< rows of a ModalPush
  Eigen::VectorXd angular_frequency_rad_s, decay_per_s;  ///< of these modes, undamped, > 0
  double sample_rate_hz = 48000.0;                       ///< of the rendering
};

/// Modal impulses by the impulses of a log on a body: of its pulses, gaussian or Hertz', in the log's order, then of its held ones (held_force.hpp).
/// @param pulses  of rows of the log whose force goes another way than the row says; none: each as it says
std::vector<ModalImpulse> modal_impulses(const events::EventLog& log, int body, const ModalPush& push,
                                         const PushedModes& modes, const ImpactPulses* pulses = nullptr);

/// Sum of gain_i z_i(t) with z_i'' + 2 b_i z_i' + w_i^2 z_i = u_i . f(t) (S02 eq. 18 with factor 1: errata 2). Each
/// impulse goes as its pulse says, held ones a force (held_force.hpp). Modes at or above audio::highest_rendered_hz are left out by
/// the frequency that is heard, |Im p| / 2 pi in Hz (errata 3): over-damped modes do not ring and stay. Where the
/// listener is does not matter.
class ModalVoice : public Voice {
 public:
  /// @param body    whose impulses it plays: a row of the log's bodies
  /// @param pulses  modal_impulses(); must outlive the voice
  ModalVoice(int body, RingingBody ringing, const ImpactPulses* pulses = nullptr);
  void add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) override;

 private:
  int body_;
  RingingBody ringing_;
  const ImpactPulses* pulses_;
};

/// Hears the displacement of a place of the body along a direction.
struct Pickup {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< the nearest node of the surface
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
};

struct SynthesisOptions {
  double sample_rate_hz = 48000.0;  ///< 1000 to 768000
  double duration_s = 3.0;
  std::optional<Pickup> pickup;  ///< none: weighted by heard_coupling
};

/// Sound of strikes on a modal body with the given decay of each mode: render() with one ModalVoice.
audio::Signal synthesise(const modal::ModalModel& model, const Eigen::VectorXd& decay_per_s,
                         const std::vector<events::Strike>& strikes, const SynthesisOptions& options);

/// A log of one body and strikes on it.
events::EventLog log_of(std::vector<events::Strike> strikes);

}  // namespace klang::stage
