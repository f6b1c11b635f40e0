#pragma once
#include <array>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "fit/proxy/proxy_fit.hpp"

/// fit.json of `klang proxy fit`.
namespace klang::fit {

struct EllipsoidRecord {
  std::array<double, 3> axes{};
  double scale_m = 0.0, rayleigh_mass_per_s = 0.0, rayleigh_stiffness_s = 0.0, gain = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"axes", "semi-axes a, b, c over their length"}), self.axes);
    visit(needed({"scale_m", "length of (a, b, c)"}), self.scale_m);
    visit(needed({"rayleigh_mass_per_s", "damping by mass"}), self.rayleigh_mass_per_s);
    visit(needed({"rayleigh_stiffness_s", "damping by stiffness"}), self.rayleigh_stiffness_s);
    visit(needed({"gain", "of its sound"}), self.gain);
  }
};

struct ParameterRecord {
  std::string name;
  double start = 0.0, value = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the parameter"}, self.name);
    visit({"start", "of the first proxy"}, self.start);
    visit({"value", "of the fitted one"}, self.value);
  }
};

/// A partial of the body and those of the same rank of both proxies.
struct ProxyPartialRecord {
  VoicePartial target, before, after;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"target_hz", "of the body"}), self.target.frequency_hz);
    visit(needed({"target_decay_per_s", "of the body"}), self.target.decay_per_s);
    visit(needed({"target_amplitude", "of the body, at the strike"}), self.target.amplitude);
    visit(needed({"before_hz", "of the first proxy"}), self.before.frequency_hz);
    visit(needed({"before_decay_per_s", "of the first proxy"}), self.before.decay_per_s);
    visit(needed({"before_amplitude", "of the first proxy"}), self.before.amplitude);
    visit(needed({"after_hz", "of the fitted proxy"}), self.after.frequency_hz);
    visit(needed({"after_decay_per_s", "of the fitted proxy"}), self.after.decay_per_s);
    visit(needed({"after_amplitude", "of the fitted proxy"}), self.after.amplitude);
  }
};

/// How many of the proxies that were heard were worse than the first one, by measure.
struct WorseRecord {
  std::optional<int> log_spectral_distance_db, mel_distance_db, third_octave_db, loudness_difference_db,
      decay_rms_percent;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"log_spectral_distance_db", "worse in it"}, self.log_spectral_distance_db);
    visit({"mel_distance_db", "worse in it"}, self.mel_distance_db);
    visit({"third_octave_db", "worse in it"}, self.third_octave_db);
    visit({"loudness_difference_db", "worse in it"}, self.loudness_difference_db);
    visit({"decay_rms_percent", "worse in it"}, self.decay_rms_percent);
  }
};

struct ProxyFitDocument {
  ResultHeader header;
  std::string target_kind;
  bool radiation = false;
  std::string sound, loudness;
  ProxyErrors before, after;
  bool improved = false;
  EllipsoidRecord start, fitted;
  std::vector<ParameterRecord> parameters;
  int n_fitted = 0;
  std::vector<ProxyPartialRecord> partials;
  std::optional<double> least_partial_rms_cents;
  std::optional<int> n_candidates, n_refused;
  WorseRecord n_worse;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"target_kind", "model or recording"}, self.target_kind);
    visit({"radiation", "the target radiates"}, self.radiation);
    visit({"sound", "what the amplitudes are"}, self.sound);
    visit({"loudness", "which"}, self.loudness);
    visit({"before", "measures of the first proxy"}, self.before);
    visit({"after", "measures of the fitted one"}, self.after);
    visit({"improved", "false: the first one is kept"}, self.improved);
    visit({"start", "the first proxy"}, self.start);
    visit({"fitted", "the fitted one"}, self.fitted);
    visit({"parameters", "of both"}, self.parameters);
    visit({"n_fitted", "first partials that are fitted and compared"}, self.n_fitted);
    visit({"partials", "rank by rank"}, self.partials);
    visit({"least_partial_rms_cents", "found without regard to the other measures"}, self.least_partial_rms_cents);
    visit({"n_candidates", "proxies that were heard"}, self.n_candidates);
    visit({"n_refused", "worse in some measure"}, self.n_refused);
    visit({"n_worse", "of those heard to the end"}, self.n_worse);
  }
};

/// Without what only the target knows: its kind, radiation, sound.
ProxyFitDocument proxy_fit_document(ResultHeader header, const ProxyFitResult& result);

}  // namespace klang::fit
