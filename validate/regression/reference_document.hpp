#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "validate/regression/reference_spectrum.hpp"

/// A reference spectrum as its file holds it, the result of `klang regress make`.
namespace klang::validate {

struct ReferencePartialRecord {
  double frequency_hz = 0.0, frequency_std_hz = 0.0, frequency_scatter_cents = 0.0;
  std::optional<double> decay_per_s, decay_std_per_s;
  double decay_scatter = 0.0;
  std::optional<double> amplitude, amplitude_std;
  int n_takes = 1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"frequency_hz", "mean over the takes", between(1e-3, 1e7)}), self.frequency_hz);
    visit(needed({"frequency_std_hz", "standard deviation of the mean by the analyses alone", between(0.0, 1e7)}),
          self.frequency_std_hz);
    visit(needed({"frequency_scatter_cents", "between takes, beyond the analyses' own", between(0.0, 1e4)}),
          self.frequency_scatter_cents);
    visit({"decay_per_s", "of the amplitude; null: too short or too long to tell", between(1e-9, 1e9)},
          self.decay_per_s);
    visit({"decay_std_per_s", "standard deviation of the mean by the analyses alone", between(0.0, 1e9)},
          self.decay_std_per_s);
    visit(needed({"decay_scatter", "between takes, beyond the analyses' own, relative", between(0.0, 1e3)}),
          self.decay_scatter);
    visit(needed({"amplitude", "at the first take's level", between(0.0, 1e12)}), self.amplitude);
    visit({"amplitude_std", "standard deviation of the mean by the analyses alone", between(0.0, 1e12)},
          self.amplitude_std);
    visit(needed({"n_takes", "in which it was found", between(1, 1'000'000)}), self.n_takes);
  }
};

struct ThirdOctaveRecord {
  std::optional<double> centre_hz, level_db;
  double scatter_db = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"centre_hz", "of the band"}, self.centre_hz);
    visit({"level_db", "mean over the sound, a sine of amplitude 1 is 0 dB"}, self.level_db);
    visit(needed({"scatter_db", "between takes after alignment of the level", between(0.0, 1e3)}), self.scatter_db);
  }
};

struct FingerprintRecord {
  double window_s = 0.0, hop_s = 0.0;
  int first_third_octave = 0;
  std::vector<double> noise_db;
  std::vector<std::vector<double>> levels_db;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"window_s", "of each frame", between(0.001, 1.0)}), self.window_s);
    visit(needed({"hop_s", "from frame to frame", between(0.0005, 1.0)}), self.hop_s);
    visit(needed({"first_third_octave", "index of the lowest band, 1000 Hz is 0", between(-30, 30)}),
          self.first_third_octave);
    visit(needed({"noise_db", "of each band before the sound", between(-300.0, 300.0)}), self.noise_db);
    visit(
        needed({"levels_db", "of each band (four per third octave) in each frame, to 0.1 dB", between(-300.0, 300.0)}),
        self.levels_db);
  }
};

/// What of a reference stands in its file beside the header.
struct ReferenceRecord {
  std::string origin;
  int n_takes = 0;
  double scatter_dof = 0.0;
  std::optional<double> decay_scatter_dof, level_scatter_dof, common_scatter_cents;
  double sample_rate_hz = 0.0, duration_s = 0.0, contact_s = 0.0;
  std::vector<double> band_hz;
  double ring_10db_s = 0.0;
  std::vector<ReferencePartialRecord> partials;
  std::vector<double> occasional_hz;
  std::vector<ThirdOctaveRecord> third_octaves;
  double spectrum_scatter_db = 0.0;
  FingerprintRecord fingerprint;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"origin", "of the takes, comma separated"}), self.origin);
    visit(needed({"n_takes", "of the same object", between(1, 1'000'000)}), self.n_takes);
    visit(needed({"scatter_dof", "degrees of freedom behind the scatter of frequencies", between(0.0, 1e9)}),
          self.scatter_dof);
    visit({"decay_scatter_dof", "behind the scatter of decays", between(0.0, 1e9)}, self.decay_scatter_dof);
    visit({"level_scatter_dof", "behind the scatter of levels", between(0.0, 1e9)}, self.level_scatter_dof);
    visit({"common_scatter_cents", "shift of a take's partials together, beyond their own scatter", between(0.0, 1e4)},
          self.common_scatter_cents);
    visit(needed({"sample_rate_hz", "lowest of the takes", between(1.0, 1e8)}), self.sample_rate_hz);
    visit(needed({"duration_s", "shortest of the takes", between(1e-6, 1e6)}), self.duration_s);
    visit(needed({"contact_s", "of the strike, longest of the takes", between(0.0, 10.0)}), self.contact_s);
    visit(needed({"band_hz", "in which partials are looked for", between(0.0, 1e8)}), self.band_hz);
    visit(needed({"ring_10db_s", "in which the partials' energy falls by 10 dB", between(0.0, 1e9)}), self.ring_10db_s);
    visit(needed({"partials", "found in more than half of the takes, ascending"}), self.partials);
    visit(needed({"occasional_hz", "found in some takes only: neither missed nor superfluous", between(0.0, 1e8)}),
          self.occasional_hz);
    visit(needed({"third_octaves", "of the fingerprint"}), self.third_octaves);
    visit(needed({"spectrum_scatter_db", "rms difference of a take's cells from the mean", between(0.0, 1e3)}),
          self.spectrum_scatter_db);
    visit(needed({"fingerprint", "mean power at the first take's level"}), self.fingerprint);
  }
};

struct ReferenceDocument {
  ResultHeader header;
  ReferenceRecord reference;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    ReferenceRecord::describe(self.reference, visit);
  }
};

ReferenceRecord record_of(const ReferenceSpectrum& reference);

}  // namespace klang::validate
