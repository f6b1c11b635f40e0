#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "validate/claim/claim.hpp"
#include "validate/regression/reference_spectrum.hpp"
#include "validate/regression/sound_description.hpp"

namespace klang::validate {

struct RegressionOptions {
  double false_alarm_rate = 5e-4;          ///< over all claims of the comparison
  double shift_false_alarm_rate = 2.5e-3;  ///< of the common shift, where takes scatter: at 5e-4 it hides 4 cents
  double catch_cents = 3.0;                ///< a judged partial shows a shift of this much in 99 of 100
  double catch_shift_cents = 5.0;          ///< and all partials together this much, where takes scatter
  double catch_decay = 0.10;               ///< and a relative change of its decay of this much
  double floor_cents = 0.5;                ///< least tolerances, whatever the noise: what no exponential describes
  double floor_decay = 0.02;
  double floor_level_db = 1.0;
  double floor_spectrum_db = 1.0;
  double range_db = 40.0;
  bool levels = true;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"false_alarm_rate", "Of a whole comparison", between(1e-9, 0.5)}, self.false_alarm_rate);
    visit({"shift_false_alarm_rate", "Of the common shift of all partials, with several takes", between(1e-9, 0.5)},
          self.shift_false_alarm_rate);
    visit({"catch_cents", "Not judged: partials too weak to show a shift of this much", between(0.01, 1000.0)},
          self.catch_cents);
    visit({"catch_shift_cents", "Not judged: takes that scatter too much to show a common shift of this much",
           between(0.01, 1000.0)},
          self.catch_shift_cents);
    visit({"catch_decay", "Not judged: decays too uncertain to show this relative change", between(0.001, 10.0)},
          self.catch_decay);
    visit({"floor_cents", "Least tolerance of a frequency", between(0.0, 1000.0)}, self.floor_cents);
    visit({"floor_decay", "Least relative tolerance of a decay", between(0.0, 10.0)}, self.floor_decay);
    visit({"floor_level_db", "Least tolerance of a third-octave level", between(0.0, 60.0)}, self.floor_level_db);
    visit({"floor_spectrum_db", "Least tolerance of the log-spectral distance", between(0.0, 60.0)},
          self.floor_spectrum_db);
    visit({"range_db", "Weaker partials may be missing or superfluous", between(10.0, 100.0)}, self.range_db);
    visit({"levels", "Judge levels and log-spectral distance, too; otherwise they are reported only"}, self.levels);
  }
};

/// A partial of the reference, of the sound, or of both.
struct PartialComparison {
  std::optional<fit::Partial> reference, sound;
  std::optional<double> cents, cents_tolerance;
  std::optional<double> decay_change, decay_tolerance;  ///< relative: sound / reference - 1
  std::string note;                                     ///< why it was not judged
};

struct ThirdComparison {
  double centre_hz = 0.0;
  double reference_db = 0.0,
         sound_db = 0.0;  ///< mean level over the common time, noise taken off, sound at the reference's level
  std::optional<double> difference_db, tolerance_db;  ///< empty where one of them is too near the noise

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"centre_hz", "of the third octave"}), self.centre_hz);
    visit({"reference_db", "its mean level, the noise taken off"}, self.reference_db);
    visit({"sound_db", "the same, at the reference's level"}, self.sound_db);
    visit({"difference_db", "null where one of them is too near the noise"}, self.difference_db);
    visit({"tolerance_db", "accepted"}, self.tolerance_db);
  }
};

enum class RegressionStatus { kNotRun, kJudged, kNothingJudged };

struct RegressionResult {
  RegressionStatus status = RegressionStatus::kNotRun;
  std::vector<Claim> claims;
  std::string reason;        ///< one sentence for many failed claims; may be empty
  double factor = 0.0;       ///< k: tolerances are k standard deviations
  double gain_db = 0.0;      ///< of the sound over the reference; taken off before levels are compared
  double common_s = 0.0;     ///< from the onsets on
  double ring_10db_s = 0.0;  ///< of the sound
  std::optional<double>
      log_spectral_distance_db;  ///< rms over the cells that stand above both noises; empty without any
  std::vector<PartialComparison> partials;
  std::vector<ThirdComparison> thirds;
  std::vector<double> times_s, bands_hz;   ///< of the levels below
  Eigen::MatrixXf reference_db, sound_db;  ///< n_bands x n_times, aligned, not below the floor of each band
  int n_failed() const;
  int n_not_judged() const;
  bool passed() const { return status == RegressionStatus::kJudged && n_failed() == 0; }
};

/// Holds a sound against a reference. Onsets are put together, levels are aligned by the partials' amplitudes, bands and times
/// are those that both have. A claim
///   |difference| <= sqrt(floor^2 + k^2 (std_reference^2 + std_sound^2) + k_t^2 scatter^2 (1 + 1/n))
/// with both analyses' standard deviations and the prediction interval of one more take after n; k from the normal, k_t from
/// Student's distribution such that all claims together give false_alarm_rate (Sidak). Claims: frequency and decay of each
/// partial, with several takes of all partials together (with a rate of its own: the mean over the partials shows
/// a shift that scatter hides in each), no partial missing or superfluous, third-octave levels, log-spectral distance. Where no
/// partial's claim could be judged and none failed, the claim "anything-judged" fails. Not judged rather than passed: a partial whose
/// tolerance is so wide that a change of catch_cents (catch_decay) would slip through in more than 1 of 100; a partial
/// that the other recording's noise would hide; partials that run together in one of the two; a band near the noise.
/// @throws InputError: options out of range, an empty spectrum, a fingerprint of other windows or bands
RegressionResult compare(const ReferenceSpectrum& reference, const SoundDescription& sound,
                         const RegressionOptions& options = {});

}  // namespace klang::validate
