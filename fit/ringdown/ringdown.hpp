#pragma once
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/signal.hpp"
#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

enum class RingdownStatus { kNotRun, kOk, kNothingFound, kUnexplained };

/// Below this share of the energy in band, in each of the first 30, 100, 300 ms after the strikes and in the whole, partials
/// are no account of a recording: it is refused (noise, speech, music and applause stay below it, real rings do not).
inline constexpr double kLeastExplained = 0.2;
/// Below this share of the whole the result warns, first of all, that much is not explained.
inline constexpr double kMostlyExplained = 0.9;

struct RingdownOptions {
  Band band;  ///< high_hz is cut to 0.48 of the sample rate
  int max_partials = 400;
  double min_snr_db = 10.0;         ///< a partial's peak above the noise in its own resolution cell
  bool accept_unexplained = false;  ///< go on, with a warning, where the partials explain less than kLeastExplained
  void validate() const;            ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Lowest frequency", between(0.0, 1e9)}, self.band.low_hz);
    visit({"band.high_hz", "Highest frequency", inside(0.0, 1e9)}, self.band.high_hz);
    visit({"max_partials", "Keep the strongest N", between(1.0, 2000.0)}, self.max_partials);
    visit({"min_snr_db", "A partial stands this far above the noise", between(0.0, 120.0)}, self.min_snr_db);
    visit({"accept_unexplained", "Go on where the partials explain less than 20 % of what is heard (else exit 3)"},
          self.accept_unexplained);
  }
};

struct RingdownResult {
  RingdownStatus status = RingdownStatus::kNotRun;
  std::string message;    ///< why nothing was found
  PartialTable partials;  ///< amplitude and phase at amplitude_strike; standard deviations of all that is given
  std::vector<Partial> steady_tones;  ///< what sounds and does not decay: no partials of the body
  std::vector<double> strikes_s;      ///< times of the strikes, from the file's start
  /// Index of the strike whose amplitudes the table has, where there are several: the first with half the energy of the loudest. A
  /// partial that is not struck there (30 dB down) has those of the strike that excites it most.
  std::optional<int> amplitude_strike;
  std::vector<std::vector<double>> strike_amplitudes;  ///< [strike][partial], where there are several strikes
  std::vector<std::vector<double>> strike_phases_rad;  ///< as strike_amplitudes
  double sample_rate_hz = 0.0;
  std::optional<double> explained_energy;  ///< 0..1, of the energy in band of the free ringing after the strikes
  std::optional<double> noise_rms;         ///< rms of what the partials leave there, full scale = 1, in band
  std::optional<int> n_coder_images;       ///< left out; empty: not known as a coded recording
  std::vector<std::string> warnings;       ///< "clipped: 312 samples left out", "mains hum at 50 Hz ignored"
  std::map<std::string, double> wall_time_s;
  bool usable() const { return status == RingdownStatus::kOk; }
};

/// A recording of one strike by more microphones than this is a mistake in the file more often than not.
inline constexpr int kMaxChannels = 32;

/// Partials of a recording with their standard deviations (docs/ringdown.md). Channels are used jointly
/// (frequencies and decays shared, amplitude of the loudest channel reported).
/// @throws InputError: silence, more than kMaxChannels channels, empty signal, fewer than 16 samples, a sample that is not finite, options out of
/// range.
RingdownResult identify_ringdown(const audio::Signal& recording, const RingdownOptions& options = {},
                                 Monitor& monitor = silent_monitor());

/// The same with the table's amplitudes and phases of the first strike, struck there or not.
RingdownResult at_first_strike(RingdownResult result);

/// The identified partials as sound, at the recording's rate and length (mono): silence before the first
/// strike, and from each strike on its own amplitudes.
audio::Signal resynthesise(const RingdownResult& ringdown, Eigen::Index n_frames);

}  // namespace klang::fit
