#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// match.json of `klang scene match`.
namespace klang::apps {

struct MatchedBubbles {
  std::int64_t n_bubbles = 0;
  double duration_s = 0.0, births_per_s = 0.0, radius_mean_m = 0.0, radius_median_m = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_bubbles", "bubbles"}, self.n_bubbles);
    visit({"duration_s", "in which they are born"}, self.duration_s);
    visit({"births_per_s", "n_bubbles over that"}, self.births_per_s);
    visit({"radius_mean_m", "mean radius"}, self.radius_mean_m);
    visit({"radius_median_m", "half are smaller"}, self.radius_median_m);
  }
};

struct MatchedQuantile {
  double share = 0.0, recorded_m = 0.0, made_m = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"share", "of the bubbles that are smaller"}, self.share);
    visit({"recorded_m", "than this radius, in the recording"}, self.recorded_m);
    visit({"made_m", "in the scene"}, self.made_m);
  }
};

struct MatchedBand {
  double frequency_hz = 0.0;
  std::optional<double> recorded_db, made_db;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frequency_hz", "middle of the third octave"}, self.frequency_hz);
    visit(null_if_empty({"recorded_db", "of the recording, re all of its bands; null: silent"}), self.recorded_db);
    visit(null_if_empty({"made_db", "of the scene, re all of its bands; null: silent"}), self.made_db);
  }
};

struct MatchDocument {
  ResultHeader header;
  std::string name, scene = "scene.toml", drops = "drops.json";
  double attempts_per_m2_s = 0.0;
  int n_rounds = 0;
  MatchedBubbles recorded, made;
  std::vector<MatchedQuantile> radii;
  std::vector<MatchedBand> third_octaves;
  std::optional<double> spectrum_difference_db;
  std::vector<std::string> matched, predicted, unknown;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the scene"}, self.name);
    visit({"scene", "the matched scene, beside match.json"}, self.scene);
    visit({"drops", "what was found in the recording, beside match.json (docs: bubbles)"}, self.drops);
    visit({"attempts_per_m2_s", "the rate that was set"}, self.attempts_per_m2_s);
    visit({"n_rounds", "rates that were tried"}, self.n_rounds);
    visit({"recorded", "bubbles of the recording"}, self.recorded);
    visit({"made", "bubbles of the scene"}, self.made);
    visit({"radii", "quantiles beside each other"}, self.radii);
    visit({"third_octaves", "spectra beside each other; empty: no sound was made"}, self.third_octaves);
    visit(null_if_empty({"spectrum_difference_db",
                         "rms over bands within 40 dB of the recording's loudest; null: no sound was made"}),
          self.spectrum_difference_db);
    visit({"matched", "what was set to agree: no evidence"}, self.matched);
    visit({"predicted", "what the scene says by itself: to be compared"}, self.predicted);
    visit({"unknown", "what neither says"}, self.unknown);
  }
};

}  // namespace klang::apps
