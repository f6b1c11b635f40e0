#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/base/output_file.hpp"
#include "core/sound/instrument/modal_bank.hpp"

/// Banks for other programs.
namespace klang::instrument {

/// A Faust program (faust.grame.fr) of one input and one output: every partial is a rotation z <- r exp(i theta) z + x, so that a
/// unit impulse gives the bank at any sample rate. Needs no library. In double precision (faust -double) it is exact to 1e-12.
std::string faust_text(const ModalBank& bank);

/// A Pure Data patch (puredata.info): at each bang one cpole~ for each partial is set to its start and rings; coefficients by Pd's
/// sample rate.
std::string pure_data_text(const ModalBank& bank);

/// A Scala scale (.scl): of one bank its partials over the lowest one, of several their pitches over the lowest bank's; weak partials are
/// left out. Degrees closer than 0.001 cents count once; where there is one note only, the scale is the octave.
std::string scala_text(const std::vector<ModalBank>& banks, const std::string& name);

/// A row for each partial: specimen, frequency_hz, decay_per_s, amplitude, phase_rad.
std::string bank_csv(const std::vector<ModalBank>& banks);

inline constexpr double kSampleEndDb = -60.0, kLongestSampleS = 120.0;

/// An SFZ 1 instrument NAME.sfz with a sample and a region for each bank: keys 0 to 127 without a gap, each to the bank whose pitch
/// (pitch_hz) is nearest; that partial is in tune (pitch_keycenter, transpose, tune) within half a cent; samples (24 bit WAV; one gain
/// for all, the loudest peaks at kPeak) last until the sum of the envelopes is kSampleEndDb below the sample's own peak, or kLongestSampleS.
/// @return a sentence for each sample that ends before it has died away
/// @throws InputError: more than 128 banks, nothing that is heard
std::vector<std::string> write_sfz(const OutputDirectory& folder, const std::vector<ModalBank>& banks,
                                   const std::string& name, double a4_hz, double sample_rate_hz);

}  // namespace klang::instrument
