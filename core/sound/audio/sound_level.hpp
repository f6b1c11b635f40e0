#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::audio {

/// A-weighting, dB, 0 at 1 kHz:
///   R(f) = f4^2 f^4 / ((f^2 + f1^2) sqrt((f^2 + f2^2)(f^2 + f3^2)) (f^2 + f4^2)),  A = 20 log10(R(f) / R(1000 Hz)),
///   f1 = 20.598997, f2 = 107.65265, f3 = 737.86223, f4 = 12194.217 Hz.
/// @param frequency_hz  > 0; at 0 it is minus infinity
/// Source: IEC 61672-1:2013, annex E.
double a_weighting_db(double frequency_hz);

/// Third-octave band x of IEC 61260-1:2014, base 10: centre = 1000 G^(x/3) Hz, edges = centre G^(-1/6), centre G^(1/6),
/// G = 10^(3/10). x = 0 is 1 kHz, x = -17 is 19.95 Hz ("20 Hz").
struct ThirdOctave {
  int index = 0;  ///< x
  double centre_hz() const;
  double low_hz() const;
  double high_hz() const;
};

/// The bands that lie wholly within band, ascending; none where it is narrower than one.
/// @throws InputError unless 0 < low_hz < high_hz, both finite
std::vector<ThirdOctave> third_octaves(const Band& band);

/// Energy of a sound over frequency: sum of x^2 / sample rate, mean over channels, [full scale^2 s], from one transform
/// of the whole sound. Edges are those of the ideal filter (a bin belongs to the band that holds it), not the skirts of
/// the standard's filters. Silence before and after changes nothing.
class EnergySpectrum {
 public:
  /// @throws InputError: no samples, a sample that is not finite, a rate that is not positive.
  explicit EnergySpectrum(const Signal& signal);

  double within(double low_hz, double high_hz) const;  ///< low_hz <= f < high_hz
  double within(const ThirdOctave& band) const { return within(band.low_hz(), band.high_hz()); }
  /// A-weighted energy, low_hz <= f < high_hz.
  double a_weighted(double low_hz, double high_hz) const;
  double total() const;  ///< at all frequencies; with 0 Hz and half the sample rate
  double highest_hz() const { return bin_hz_ * static_cast<double>(energy_.size() - 1); }  ///< half the sample rate
  double duration_s() const { return duration_s_; }

 private:
  Eigen::Index first_bin(double frequency_hz) const;  ///< the lowest at or above
  Eigen::VectorXd energy_;                            ///< of each bin
  double bin_hz_ = 0.0, duration_s_ = 0.0;
};

/// Level of an energy that was spread over a duration: 10 log10(2 energy / duration), dB; a sine of amplitude 1 is 0 dB.
/// Minus infinity for silence.
double level_db(double energy, double duration_s);

/// What brings a sound's peak [Pa] to a level in a file, dB re full scale: 10^(level/20) / max(peak, 20 uPa sqrt(2)) [1/Pa].
/// A sound below 0 dB re 20 uPa, which nobody hears, is not raised above what it is: round-off would be played as loud as a blow.
double file_gain(double peak_pressure_pa, double level_db_re_full_scale);
/// Whether file_gain leaves it below the level, and what to tell the reader then.
bool is_inaudible(double peak_pressure_pa);
std::string inaudible_note(double peak_pressure_pa);

/// Levels of third-octave bands over the whole sound; minus infinity where there is nothing.
std::vector<double> third_octave_levels_db(const Signal& signal, const std::vector<ThirdOctave>& bands);

/// Mean A-weighted level over the whole sound, dB(A) re a 1-kHz sine of amplitude 1, 10 Hz to half the sample rate.
double a_weighted_level_db(const Signal& signal);

}  // namespace klang::audio
