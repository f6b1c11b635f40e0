#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/audio/sound_level.hpp"
#include "fit/ringdown/partial_table.hpp"

namespace klang::validate {

/// Levels over time from the onset in bands of a twelfth octave (four to a third octave of IEC 61260). Power of Hann
/// windows that begin at onset + k hop; a sine of amplitude 1 has 0 dB in its band. The same times and bands whatever the
/// sample rate.
struct Fingerprint {
  double window_s = 0.04, hop_s = 0.01;
  int first_third = -13;  ///< index of the lowest third octave (50 Hz)
  Eigen::MatrixXf power;  ///< n_bands (4 for each third octave) x n_frames
  Eigen::VectorXf noise;  ///< n_bands: power a frame of what the partials leave, their ringing done
  Eigen::Index n_thirds() const { return power.rows() / 4; }
  audio::ThirdOctave third(Eigen::Index i) const { return {first_third + static_cast<int>(i)}; }
  double centre_hz(Eigen::Index band) const;  ///< of a twelfth octave
};

struct DescriptionOptions {
  Band band{50.0, 18000.0};     ///< high_hz is cut to 0.45 of the sample rate, and to what a coder left
  double max_duration_s = 4.0;  ///< of the fingerprint
  double min_snr_db = 10.0;     ///< of RingdownOptions
  void validate() const;        ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Lowest frequency of a partial", between(20.0, 1e5)}, self.band.low_hz);
    visit({"band.high_hz", "Highest frequency of a partial", inside(0.0, 1e6)}, self.band.high_hz);
    visit({"max_duration_s", "Levels are kept for so long after the onset", between(0.1, 20.0)}, self.max_duration_s);
    visit({"min_snr_db", "A partial stands this far above the noise", between(0.0, 120.0)}, self.min_snr_db);
  }
};

/// What is known of one sound: its partials with standard deviations, its noise, its levels. Of the first strike; of several
/// channels the one with the most energy.
struct SoundDescription {
  std::string origin;
  double sample_rate_hz = 0.0;
  double duration_s = 0.0;  ///< from the onset to the end or to the next strike
  double onset_s = 0.0;
  double contact_s = 0.0;  ///< from the onset until the body rings freely: partials are heard from then on
  Band band;               ///< in which partials were looked for
  fit::PartialTable partials;
  Fingerprint fingerprint;
  double ring_10db_s = 0.0;  ///< in which the energy that is left in all partials falls by 10 dB
  std::vector<std::string> warnings;

  /// Noise at a frequency, one-sided power density [full scale^2 / Hz]; 0 for none.
  double noise_density(double frequency_hz) const;
};

/// One-sided power density of a fingerprint's noise at a frequency, median over the third octave around it.
double noise_density(const Fingerprint& fingerprint, double frequency_hz);

/// Analyses a sound (fit::identify_ringdown and short-time levels).
/// @throws InputError: silence, no partial above the noise ("an empty spectrum"), options out of range, and what
///         identify_ringdown refuses
SoundDescription describe(const audio::Signal& sound, const DescriptionOptions& options = {},
                          Monitor& monitor = silent_monitor());

/// The partials' sound, struck at a time: sum A gain e^(-d t) sin(2 pi f t), up to 0.45 of the sample rate, in one channel.
audio::Signal rung(const std::vector<fit::Partial>& partials, double gain, double onset_s, Eigen::Index n_frames,
                   double sample_rate_hz);

/// Time in which sum A^2/(4 d) e^(-2 d t) over partials with amplitude and decay falls by 10 dB [s]; 0 without any.
double ring_10db_s(const std::vector<fit::Partial>& partials);

}  // namespace klang::validate
