#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "fit/bubble/pitch_fit.hpp"
#include "fit/bubble/recording_verdict.hpp"

/// bubbles.json of `klang bubble fit`.
namespace klang::fit::bubble {

struct TrackRecord {
  std::vector<double> time_s, frequency_hz;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "from the recording's start"}, self.time_s);
    visit({"frequency_hz", "at each of them"}, self.frequency_hz);
  }
};

struct BubbleRecord {
  double onset_s = 0.0, end_s = 0.0, frequency_start_hz = 0.0, frequency_end_hz = 0.0, decay_per_s = 0.0,
         radius_m = 0.0;
  std::optional<double> onset_std_s, rest_s, frequency_start_std_hz, chirp_rate_per_s, chirp_rate_std_per_s,
      chirp_growth_per_s, chirp_growth_std_per_s, decay_std_per_s, theory_decay_per_s, radius_std_m, amplitude, snr_db;
  std::string attack, verdict;
  TrackRecord track;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"onset_s", "from the recording's start"}), self.onset_s);
    visit({"onset_std_s", "its standard deviation"}, self.onset_std_s);
    visit(needed({"end_s", "last time at which it tells its pitch"}), self.end_s);
    visit({"rest_s", "time at which its pitch stops rising"}, self.rest_s);
    visit(needed({"frequency_start_hz", "at the onset"}), self.frequency_start_hz);
    visit({"frequency_start_std_hz", "its standard deviation"}, self.frequency_start_std_hz);
    visit(needed({"frequency_end_hz", "at the end"}), self.frequency_end_hz);
    visit({"chirp_rate_per_s", "relative rise of the pitch"}, self.chirp_rate_per_s);
    visit({"chirp_rate_std_per_s", "its standard deviation"}, self.chirp_rate_std_per_s);
    visit({"chirp_growth_per_s", "by which that rise grows"}, self.chirp_growth_per_s);
    visit({"chirp_growth_std_per_s", "its standard deviation"}, self.chirp_growth_std_per_s);
    visit(needed({"decay_per_s", "of the amplitude"}), self.decay_per_s);
    visit({"decay_std_per_s", "its standard deviation"}, self.decay_std_per_s);
    visit({"theory_decay_per_s", "of a free bubble of this pitch"}, self.theory_decay_per_s);
    visit(needed({"radius_m", "of the free bubble of its pitch at the onset"}), self.radius_m);
    visit({"radius_std_m", "its standard deviation"}, self.radius_std_m);
    visit({"amplitude", "at the onset, full scale = 1"}, self.amplitude);
    visit({"snr_db", "energy over the noise's spectral density"}, self.snr_db);
    visit({"attack", "soft or quick"}, self.attack);
    visit({"verdict", "bubble, or what speaks against it"}, self.verdict);
    visit({"track", "its pitch while it is heard"}, self.track);
  }
};

/// A constant, or with `combination` a combination of them.
struct PitchRecord {
  std::string name, combination;
  std::optional<double> value, std;
  bool identifiable = false;
  std::optional<std::array<double, 2>> ci95;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(absent_if_empty({"name", "of the constant"}), self.name);
    visit(absent_if_empty({"combination", "instead of a name: a formula"}), self.combination);
    visit({"value", "found, or as given"}, self.value);
    visit({"std", "its standard deviation"}, self.std);
    visit({"identifiable", "the sound determines it"}, self.identifiable);
    visit({"ci95", "its 95 % interval"}, self.ci95);
  }
};

struct PitchFitRecord {
  PitchStatus status = PitchStatus::kFailed;
  std::string message;
  int n_bubbles = 0;
  std::vector<PitchRecord> parameters, identifiable;
  std::vector<double> chi_square_per_datum;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"status", "of the fit"}, self.status);
    visit({"message", "what is to be known"}, self.message);
    visit({"n_bubbles", "that carry the joint fit"}, self.n_bubbles);
    visit({"parameters", "constants of the pitch model"}, self.parameters);
    visit({"identifiable", "combinations that the data determine, whatever the rest"}, self.identifiable);
    visit({"chi_square_per_datum", "by group of bubbles that overlap"}, self.chi_square_per_datum);
  }
};

struct TheoryRecord {
  std::vector<double> frequency_hz, decay_per_s;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frequency_hz", "pitch of a free bubble"}, self.frequency_hz);
    visit({"decay_per_s", "by radiation, viscosity and heat"}, self.decay_per_s);
  }
};

struct BubbleFiles {
  std::optional<std::string> recording, resynthesis;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"recording", "what was searched"}, self.recording);
    visit({"resynthesis", "the fitted chirps"}, self.resynthesis);
  }
};

struct BubblesDocument {
  ResultHeader header;
  std::string name;
  std::optional<double> duration_s, sample_rate_hz;
  std::optional<int> n_channels;
  std::optional<double> explained_energy;
  std::optional<RecordingEvidence> evidence;
  std::vector<BubbleRecord> bubbles, rejected;
  TheoryRecord theory;
  PitchFitRecord pitch;
  std::optional<BubbleFiles> files;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the recording"}, self.name);
    visit({"duration_s", "of the recording"}, self.duration_s);
    visit({"sample_rate_hz", "of the recording"}, self.sample_rate_hz);
    visit({"n_channels", "of the recording"}, self.n_channels);
    visit({"explained_energy", "in band, 0 to 1"}, self.explained_energy);
    visit({"evidence", "that it is a recording of bubbles, shares of energy from 0 to 1"}, self.evidence);
    visit({"bubbles", "in order of onset"}, self.bubbles);
    visit({"rejected", "rings that are no bubbles"}, self.rejected);
    visit({"theory", "what every measured decay is held against"}, self.theory);
    visit({"pitch", "constants of the pitch model"}, self.pitch);
    visit(absent_if_empty({"files", "with -o: beside the result"}), self.files);
  }
  /// @throws InputError naming a list that does not go with its neighbour
  void check(const std::string& place) const;
};

/// Without what only the recording knows: name, duration, sample rate, channels, files. header.status becomes ok,
/// nothing_found or not_bubbles (with the reason as its message).
BubblesDocument bubbles_document(ResultHeader header, const BubbleSearchResult& found, const PitchFitResult& pitch,
                                 const BubbleSearchOptions& search);

}  // namespace klang::fit::bubble
