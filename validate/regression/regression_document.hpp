#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "validate/regression/regression.hpp"

/// regression.json of `klang regress check`.
namespace klang::validate {

/// A partial of one side, without its phases.
struct ComparedPartial : fit::Partial {
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    describe_ring(self, visit);
  }
};

struct PartialRecord {
  std::optional<ComparedPartial> reference, sound;
  std::optional<double> cents, cents_tolerance, decay_change, decay_tolerance;
  std::string note;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"reference", "null: superfluous in the sound"}, self.reference);
    visit({"sound", "null: missing there"}, self.sound);
    visit({"cents", "sound over reference"}, self.cents);
    visit({"cents_tolerance", "accepted"}, self.cents_tolerance);
    visit({"decay_change", "sound / reference - 1"}, self.decay_change);
    visit({"decay_tolerance", "accepted"}, self.decay_tolerance);
    visit({"note", "why it was not judged; empty where it was"}, self.note);
  }
};

struct LevelsRecord {
  std::vector<double> times_s, bands_hz;
  std::vector<std::vector<double>> reference_db, sound_db;  ///< [band][time]

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"times_s", "from the onset on"}, self.times_s);
    visit({"bands_hz", "centres, a twelfth of an octave each"}, self.bands_hz);
    visit({"reference_db", "[band][time], not below the floor of each band"}, self.reference_db);
    visit({"sound_db", "the same, at the reference's level"}, self.sound_db);
  }
};

struct RegressionFiles {
  std::optional<std::string> sound, reference;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"sound", "what was held against the reference"}, self.sound);
    visit({"reference", "the reference's partials, rung at the sound's onset and level"}, self.reference);
  }
};

struct RegressionDocument {
  ResultHeader header;
  std::string name;
  bool passed = false;
  int n_failed = 0, n_not_judged = 0;
  std::optional<double> factor, gain_db, common_s, ring_10db_s, reference_ring_10db_s, log_spectral_distance_db;
  std::string reference_origin;
  std::optional<int> reference_takes;
  std::vector<Claim> claims;
  std::vector<PartialRecord> partials;
  std::vector<ThirdComparison> third_octaves;
  LevelsRecord spectrogram;
  std::optional<RegressionFiles> files;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "sound against reference"}, self.name);
    visit({"passed", "no judged claim failed, and one of the partials' was judged"}, self.passed);
    visit({"n_failed", "claims"}, self.n_failed);
    visit({"n_not_judged", "claims"}, self.n_not_judged);
    visit({"factor", "tolerances are so many standard deviations"}, self.factor);
    visit({"gain_db", "of the sound over the reference, taken off before levels are compared"}, self.gain_db);
    visit({"common_s", "from the onsets on, that both have"}, self.common_s);
    visit({"ring_10db_s", "in which the sound's energy falls by 10 dB"}, self.ring_10db_s);
    visit({"reference_ring_10db_s", "the reference's"}, self.reference_ring_10db_s);
    visit({"log_spectral_distance_db", "rms over the cells above both noises"}, self.log_spectral_distance_db);
    visit({"reference_origin", "what the reference was made from"}, self.reference_origin);
    visit({"reference_takes", "of how many recordings"}, self.reference_takes);
    visit({"claims", "of partials, levels and spectrum"}, self.claims);
    visit({"partials", "of the reference, of the sound, or of both"}, self.partials);
    visit({"third_octaves", "mean levels over the common time"}, self.third_octaves);
    visit({"spectrogram", "levels over time and frequency"}, self.spectrogram);
    visit(absent_if_empty({"files", "with -o: beside the result"}), self.files);
  }
  /// @throws InputError naming a list that does not go with its neighbour
  void check(const std::string& place) const;
};
/// header.status becomes passed, not_passed or nothing_judged, header.message the one reason of many failures, if there is one.
RegressionDocument regression_document(ResultHeader header, const RegressionResult& result,
                                       const ReferenceSpectrum& reference);

}  // namespace klang::validate
