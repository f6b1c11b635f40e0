#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/audio/sound_level.hpp"

namespace klang::audio {

struct SpectralDistanceOptions {
  Band band;                 ///< high_hz is cut to 0.45 of the lower sample rate; 0 < low_hz < high_hz
  double window_s = 0.0464;  ///< Hann window; hop = a quarter of it, 0.005 to 1
  double floor_db = -60.0;   ///< below the reference's loudest cell: nothing lower is told apart, -120 to -10
  int n_mel = 64;            ///< mel bands, 8 to 256
  bool align_level = false;  ///< scale the sound to the reference's energy in the band first
  void validate() const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Lowest frequency", inside(0.0, 1e9)}, self.band.low_hz);
    visit({"band.high_hz", "Highest frequency", inside(0.0, 1e9)}, self.band.high_hz);
    visit({"window_s", "Length of the Hann window", between(0.005, 1.0)}, self.window_s);
    visit({"floor_db", "Level against the reference's loudest cell below which nothing is told apart",
           between(-120.0, -10.0)},
          self.floor_db);
    visit({"n_mel", "Mel bands", between(8.0, 256.0)}, self.n_mel);
    visit({"align_level", "Scale the sound to the reference's energy in the band first"}, self.align_level);
  }
};

struct BandDifference {
  ThirdOctave band;
  double reference_level_db = 0.0;  ///< over the reference's own length
  std::optional<double>
      difference_db;  ///< of the energies, sound minus reference; empty where both lie under the floor
};

/// How far a sound lies from a reference. 0 for equal sounds; larger distances are worse.
struct SpectralDistance {
  double log_spectral_db = 0.0;         ///< mean over frames of the rms over frequency of the level difference
  double mel_db = 0.0;                  ///< the same in mel bands
  double third_octave_db = 0.0;         ///< rms of the differences in third-octave bands of the whole sound
  double loudness_difference_db = 0.0;  ///< A-weighted energy, sound minus reference, dB(A); not a loudness in sones
  double level_difference_db = 0.0;     ///< unweighted energy in the band, sound minus reference, before any alignment
  std::vector<BandDifference> third_octaves;
  Band band;         ///< that was compared
  int n_frames = 0;  ///< that hold anything above the floor
};

/// Short-time power of a sound: what log_spectral_db and mel_db are made of.
struct FramePowers {
  Eigen::MatrixXf bins, mel;  ///< bins of the band x frames; n_mel x frames
};
/// Energies of the whole sound: what the other measures are made of.
struct BandEnergies {
  Band band;
  double in_band = 0.0, a_weighted = 0.0, duration_s = 0.0;
  std::vector<double> third_octaves;  ///< of the bands that lie wholly within band
};
/// For many comparisons with one reference: all sounds of one sample rate and length.
FramePowers frame_powers(const Signal& signal, const Band& band, const SpectralDistanceOptions& options = {});
BandEnergies band_energies(const Signal& signal, const Band& band);
/// Fill log_spectral_db, mel_db and n_frames; and the rest. The sound is that of the arguments times gain (an amplitude).
void compare_frames(const FramePowers& reference, const FramePowers& sound, double gain,
                    const SpectralDistanceOptions& options, SpectralDistance& result);
void compare_energies(const BandEnergies& reference, const BandEnergies& sound, double gain,
                      const SpectralDistanceOptions& options, SpectralDistance& result);

/// Distance of a sound from a reference, both starting at the same instant (the shorter is continued by silence, the one
/// with the higher rate is resampled to the lower).
///   L(t, k) = 10 log10 max(|X(t, k)|^2, P_floor),  P_floor = 10^(floor_db / 10) max_{t,k in band} |X_reference|^2
///   log_spectral_db = mean_t sqrt(mean_k (L_sound - L_reference)^2)
/// over bins k of the band and the frames t where either sound has a bin above the floor. mel_db: the same with powers summed by
/// n_mel triangles, evenly spaced over the band on the scale 2595 log10(1 + f / 700 Hz), and the floor below the loudest mel cell.
/// A gain of g dB gives |g| in all measures while nothing falls under the floor. Channels: mean power.
/// @throws InputError: options out of range; a signal without samples, with a sample that is not finite, or silent in the band;
///         no common band.
SpectralDistance spectral_distance(const Signal& reference, const Signal& sound,
                                   const SpectralDistanceOptions& options = {});

}  // namespace klang::audio
