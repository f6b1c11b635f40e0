#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/bubble/bubble_medium.hpp"
#include "core/sound/audio/signal.hpp"
#include "fit/bubble/chirp_fit.hpp"

namespace klang::fit::bubble {

/// Limit of the work of a search, in samples at which a chirp is evaluated; 17 million took a second on a busy core.
inline constexpr double kWorkAtOnce = 1.2e9, kWorkPerSecond = 3e8;

struct BubbleSearchOptions {
  Band band{200.0, 20000.0};  ///< high_hz is cut to 0.45 of the sample rate
  double min_snr_db = 17.0;
  int max_bubbles = 500;
  double max_work = 1.0;  ///< times kWorkAtOnce + kWorkPerSecond * duration
  klang::bubble::BubbleMedium medium;
  klang::bubble::BubbleTheory theory = klang::bubble::BubbleTheory::kLeighton;
  double amplitude_exponent = 1.5;  ///< ChirpLaw
  bool soft_attack = true;          ///< each ring takes the soft or the hard attack, whichever fits; false: hard only
  void validate() const;            ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Lowest frequency", between(100.0, 2e5)}, self.band.low_hz);
    visit({"band.high_hz", "Highest frequency", above(0.0)}, self.band.high_hz);
    visit({"min_snr_db", "Energy of a ring over the noise's spectral density", between(10.0, 120.0)}, self.min_snr_db);
    visit({"max_bubbles", "Strongest N", between(1.0, 10000.0)}, self.max_bubbles);
    visit({"max_work", "The search ends after so many times its usual limit of work (docs/bubbles.md)",
           between(0.01, 1000.0)},
          self.max_work);
    visit({"medium", "Liquid and gas"}, self.medium);
    visit({"amplitude_exponent", "n of |p| ~ omega^n as the pitch rises", between(-5.0, 5.0)}, self.amplitude_exponent);
    visit({"soft_attack", "Each ring takes the soft or the hard attack, whichever fits"}, self.soft_attack);
  }
};

enum class BubbleVerdict {
  kBubble,        ///< rings down as theory has it
  kDriven,        ///< pitch rises, but the amplitude does not fall as it should: fed, or radiating better as it rises
  kRingsTooLong,  ///< steady pitch, and less damping than a bubble of this pitch can have: some other thing
  kUnclear,       ///< pitch, its rate or the damping are not determined
  kDampedTooStrongly  ///< ten times the damping of a bubble of this pitch: a click or a patch of noise
};
const char* words(BubbleVerdict verdict);

struct FoundBubble {
  Chirp chirp;
  ChirpLaw law;
  std::optional<Eigen::MatrixXd>
      covariance;  ///< 7 x 7, as Chirp::vector(), noise as found in the ring's own band; empty: the last fit failed
  double snr_db = 0.0;    ///< energy over the noise's spectral density
  double end_s = 0.0;     ///< last time at which it tells its pitch: 26 dB down, or below the noise in its own band
  double radius_m = 0.0;  ///< of the free bubble of its pitch at the onset
  std::optional<double> radius_std_m;
  double theory_decay_per_s = 0.0;  ///< of a bubble of this pitch
  BubbleVerdict verdict = BubbleVerdict::kBubble;
  bool is_bubble() const { return verdict == BubbleVerdict::kBubble || verdict == BubbleVerdict::kDriven; }
};

enum class BubbleSearchStatus { kNotRun, kDone, kNothingFound };

struct BubbleSearchResult {
  BubbleSearchStatus status = BubbleSearchStatus::kNotRun;
  std::string message;
  bool stopped_early = false;      ///< the limit of work was reached: what is weaker was not searched for
  std::vector<FoundBubble> found;  ///< in order of onset, whatever their verdict
  NoiseSpectrum noise;
  audio::Signal mono;                           ///< what was searched
  std::optional<double> explained_energy;       ///< 0..1, of the energy in the band
  std::optional<double> explained_above_noise;  ///< 0..1, of what it has above stationary noise
};

/// Bubbles in a recording: the loudest decaying chirp is fitted and taken away until none stands above the noise; chirps
/// that overlap are fitted together. Docs: docs/bubbles.md.
/// @throws Interrupted when the monitor asks for it
/// @throws InputError: options out of range, silence, less than 256 samples, samples that are not finite
BubbleSearchResult find_bubbles(const audio::Signal& recording, const BubbleSearchOptions& options = {},
                                Monitor& monitor = silent_monitor());

/// Bubbles that overlap, with the window they are fitted in; every other sound found is taken out of it.
struct RingGroup {
  std::vector<std::size_t> members;  ///< numbers in BubbleSearchResult::found
  std::shared_ptr<const ChirpWindow> window;
};
std::vector<RingGroup> ring_groups(const BubbleSearchResult& result, const BubbleSearchOptions& options,
                                   Monitor& monitor = silent_monitor());

/// Spectral density of the noise: the lower quartile over short frames, smoothed over a sixth of an octave.
NoiseSpectrum noise_spectrum(const Eigen::VectorXd& samples, double sample_rate_hz);

/// Radius of the bubble that rings at this damped frequency in free liquid. @throws InputError out of the range of radii
double radius_of_frequency_m(double damped_frequency_hz, const klang::bubble::BubbleMedium& medium,
                             klang::bubble::BubbleTheory theory);

/// The chirps' sound, at the samples of a signal.
Eigen::VectorXd render(const std::vector<FoundBubble>& bubbles, Eigen::Index n_samples, double sample_rate_hz);

}  // namespace klang::fit::bubble
