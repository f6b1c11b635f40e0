#pragma once
#include <Eigen/Core>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "core/physics/bubble/bubble_ring.hpp"
#include "core/physics/bubble/time_series.hpp"
#include "core/sound/stage/rendering.hpp"

namespace klang::stage {

enum class SceneTransfer {
  kHalfSpace,  ///< closed form for a bubble below a wide plane surface: see half_space_transfer
  kUnit        ///< |P| = 1 for every bubble, also where it has a transfer of its own: for comparison
};

/// In what bubbles ring, and by which formulas.
struct BubbleSettings {
  std::string name = "bubbles";  ///< for messages
  bubble::BubbleMedium medium;
  bubble::BubbleTheory theory = bubble::BubbleTheory::kLeighton;
  bubble::PitchModel pitch;
  bool printed_excitation = false;  ///< as the paper prints it
  bool soft_attack = true;
  SceneTransfer transfer = SceneTransfer::kHalfSpace;
  double air_density_kg_m3 = 1.2041, air_sound_speed_m_s = 343.0;
};

/// Pressure in the air for unit vibration amplitude of a bubble below a wide plane surface: the one-way (dual-domain)
/// solution in closed form. The source under the pressure-release plane moves the plane; the plane radiates as a piston
/// in a wall:
///   P = 2 rho_a r^2 lambda^2 / R * exp(-depth sqrt(k_a^2 sin^2 theta - k_f^2)), far from the bubble (k_a R > 1)
/// with lambda the complex rate of the oscillation (about i omega), theta the angle from the vertical. e^{-i k_a R} is
/// left out: sound takes its time by the listener's propagation_delay.
std::complex<double> half_space_transfer(const BubbleSettings& settings, double radius_m,
                                         const Eigen::Vector3d& bubble_m, const Eigen::Vector3d& listener_m,
                                         std::complex<double> rate);

/// What a log does not say of a bubble: its path as a formula, and its own transfer.
struct BubbleSource {
  std::shared_ptr<const bubble::BubbleMotion> motion;
  std::shared_ptr<const bubble::TransferSeries> transfer;  ///< none: that of the settings
};

struct SoundedBubble {
  double frequency_start_hz = 0.0, frequency_end_hz = 0.0;  ///< heard, at birth and at 1/1000 of the amplitude
  double decay_start_per_s = 0.0;
  double amplitude_m = 0.0;
  double peak = 0.0;  ///< largest |gain Z| over the life and the channels [Pa], or [m] with unit transfer
};

/// Sum over the bubbles of a log of |P| Re Z (one ear, eq. 11) or Re(H_ear P Z) (two ears, eq. 35; without a head P at
/// each ear), each ear with its own arrival time. A bubble is heard from where it and the listener were at its birth as
/// far as time goes, and from where they are as far as level and phase go (which gives the Doppler shift with
/// propagation_delay). Bubbles whose pitch reaches audio::highest_rendered_hz are left out.
class BubbleVoice : public Voice {
 public:
  /// @param sources  one for each bubble of the log; empty: bubbles move along the log's paths, splined, or rest where
  ///         they were born
  explicit BubbleVoice(BubbleSettings settings, std::vector<BubbleSource> sources = {});
  void add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) override;
  /// Of the last add_to(), in the log's order.
  const std::vector<SoundedBubble>& bubbles() const { return bubbles_; }
  std::size_t n_too_high() const { return n_too_high_; }

 private:
  BubbleSettings settings_;
  std::vector<BubbleSource> sources_;
  std::vector<SoundedBubble> bubbles_;
  std::size_t n_too_high_ = 0;
};

}  // namespace klang::stage
