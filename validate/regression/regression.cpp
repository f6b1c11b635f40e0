#include "validate/regression/regression.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "validate/regression/detail/common_reason.hpp"
#include "validate/regression/detail/partial_pairs.hpp"
#include "validate/regression/detail/quantiles.hpp"
#include "validate/regression/detail/scales.hpp"

namespace klang::validate {
namespace {

constexpr double kCaught = 2.3263478740408408;  // 99 % of a normal distribution lies below
constexpr double kDbPerNeper = 8.685889638065037;
// A partial is found without fail where its amplitude stands this far above its own deviation (fit/ringdown asks for 14 dB).
constexpr double kHeardDb = 26.0;
constexpr double kClearSuperfluousDb = 20.0;  // what the sound's own analysis must say of it
// 1/s over Hz (a quality of 20), and decay times that contact lasts: beyond, a partial belongs to the blow.
constexpr double kBurstDecay = kPi / 20.0, kBurstContact = 1.5;
constexpr double kClearBand = 20.0;  // band power over noise, 13 dB
constexpr double kLeastFall =
    0.5;  // decay times duration, 4 dB: below, what is not exponential decides about the decay
constexpr float kClearCell = 16.0f;  // cell power over noise, 12 dB
constexpr float kCellRange = 1e-5f;  // cells down to 50 dB below the loudest

double relative_std(const std::optional<double>& std, const std::optional<double>& value) {
  return value && *value > 0.0 ? std.value_or(0.0) / *value : 0.0;
}

std::string hz(double frequency_hz) { return to_text(std::round(frequency_hz * 100.0) / 100.0) + " Hz"; }

class Comparison {
 public:
  Comparison(const ReferenceSpectrum& reference, const SoundDescription& sound, const RegressionOptions& options)
      : reference_(reference),
        sound_(sound),
        options_(options),
        expected_(reference.table()),
        found_(sound.partials.partials) {}

  RegressionResult run() {
    const detail::Pairing pairing = detail::pairing(expected_, found_);
    result_.gain_db = pairing.gain.db;
    gain_std_db_ = pairing.gain.std_db;
    result_.ring_10db_s = sound_.ring_10db_s;
    expected_pair_.assign(expected_.size(), {});
    found_pair_.assign(found_.size(), {});
    for (const auto& [i, j] : pairing.pairs) {
      expected_pair_[i] = j;
      found_pair_[j] = i;
    }
    for (const fit::Partial& p : expected_) loudest_ = std::max(loudest_, p.amplitude.value_or(0.0));
    common_times();
    const auto n_claims = static_cast<double>(2 * pairing.pairs.size() + (expected_.size() - pairing.pairs.size()) +
                                              (found_.size() - pairing.pairs.size()) + 1) +
                          (options_.levels ? static_cast<double>(n_thirds_ + 1) : 0.0);
    const bool several = reference_.n_takes > 1 && reference_.scatter_dof > 0.0;
    const double each = -std::expm1(std::log1p(-options_.false_alarm_rate) / n_claims);
    result_.factor = detail::normal_two_sided(each);
    scatter_factor_ = scatter_factor(each, reference_.scatter_dof);
    decay_scatter_factor_ = scatter_factor(each, reference_.decay_scatter_dof);
    level_scatter_factor_ = scatter_factor(each, reference_.level_scatter_dof);
    one_more_ = several ? std::sqrt(1.0 + 1.0 / reference_.n_takes) : 1.0;
    partials();
    if (several) together(options_.shift_false_alarm_rate);
    const bool judged = std::any_of(result_.claims.begin(), result_.claims.end(),
                                    [](const Claim& claim) { return claim.not_judged.empty(); });
    thirds();
    spectrum();
    result_.status = judged || result_.n_failed() > 0 ? RegressionStatus::kJudged : RegressionStatus::kNothingJudged;
    if (!judged && result_.n_failed() == 0)
      result_.claims.push_back(validate::judged(Claim{"anything-judged",
                                                      "Partials that could not be judged, where not one could",
                                                      static_cast<double>(result_.claims.size()),
                                                      0.0,
                                                      0.0,
                                                      {},
                                                      false,
                                                      {}}));
    if (result_.n_failed() > 0) result_.reason = detail::common_reason(expected_, found_, pairing.pairs.size());
    return std::move(result_);
  }

 private:
  void common_times() {
    const Fingerprint &a = reference_.fingerprint, &b = sound_.fingerprint;
    n_frames_ = std::min(a.power.cols(), b.power.cols());
    n_thirds_ = std::min(a.n_thirds(), b.n_thirds());
    result_.common_s = static_cast<double>(n_frames_ - 1) * a.hop_s + a.window_s;
  }

  double scatter_factor(double probability, double dof) const {
    return dof > 0.0 ? detail::student_two_sided(probability, dof) : detail::normal_two_sided(probability);
  }

  /// sqrt(floor^2 + (k std)^2 + (k_t scatter)^2 (1 + 1/n)): what no exponential describes comes on top of the noise.
  double tolerance(double floor, double std, double scatter, double factor) const {
    return std::hypot(floor, result_.factor * std, factor * one_more_ * scatter);
  }

  /// What the analyses leave open of a mean over the takes, whose deviation holds scatter / sqrt(n) too.
  double own_std(double std, double scatter) const {
    return std::sqrt(std::max(0.0, std * std - scatter * scatter / reference_.n_takes));
  }

  /// Whether two partials of one sound cannot be told apart safely: within some line widths and two cells of the shorter sound.
  bool together(const fit::Partial& a, const fit::Partial& b, double widths = 2.0) const {
    const double decay = std::max({a.decay_per_s.value_or(0.0), b.decay_per_s.value_or(0.0), 0.0});
    const double width_hz = widths * decay / kPi + 2.0 / std::min(reference_.duration_s, sound_.duration_s);
    return std::abs(a.frequency_hz - b.frequency_hz) < width_hz;
  }

  /// A loner of either list that runs together with the pair (i, j) and is not 40 dB below it.
  bool disturbed(std::size_t i, std::size_t j) const {
    for (std::size_t u = 0; u < expected_.size(); ++u) {
      if (!expected_pair_[u] && together(expected_[u], expected_[i]) &&
          expected_[u].amplitude.value_or(0.0) > 0.01 * expected_[i].amplitude.value_or(0.0)) {
        return true;
      }
    }
    for (std::size_t u = 0; u < found_.size(); ++u) {
      if (!found_pair_[u] && together(found_[u], found_[j]) &&
          found_[u].amplitude.value_or(0.0) > 0.01 * found_[j].amplitude.value_or(0.0)) {
        return true;
      }
    }
    return false;
  }

  /// Near enough that noise may decide whether it is found at all.
  bool runs_into_another(const std::vector<fit::Partial>& others, const fit::Partial& p) const {
    return std::any_of(others.begin(), others.end(),
                       [&](const fit::Partial& q) { return &q != &p && together(p, q, 3.0); });
  }

  /// A neighbour with a third of the amplitude or more takes part in it.
  bool runs_into_louder(const std::vector<fit::Partial>& others, const fit::Partial& p) const {
    return std::any_of(others.begin(), others.end(), [&](const fit::Partial& q) {
      return &q != &p && together(p, q) && 3.0 * q.amplitude.value_or(0.0) > p.amplitude.value_or(0.0);
    });
  }

  /// Amplitude over its deviation that a partial would have in noise of a density, dB: A / sqrt(4 decay N) for a partial whose
  /// decay is estimated with it (Cramer-Rao), no longer than the sound and only after contact.
  static double heard_db(double amplitude, double decay_per_s, double density, double duration_s, double contact_s) {
    const double decay = std::max(decay_per_s, 1.0 / duration_s);
    amplitude *= std::exp(-std::max(decay_per_s, 0.0) * contact_s);
    return 20.0 * std::log10(amplitude / std::sqrt(std::max(4.0 * decay * density, 1e-60)));
  }

  /// A burst that is over with the blow, or after some periods: how the hammer met the body, not how the body rings.
  bool of_the_blow(const fit::Partial& p) const {
    const double decay = p.decay_per_s.value_or(0.0);
    return decay > kBurstDecay * p.frequency_hz ||
           decay * std::max(reference_.contact_s, sound_.contact_s) > kBurstContact;
  }

  void partials() {
    std::size_t number = 0;
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      const std::string name = "partial-" + std::to_string(++number);
      if (expected_pair_[i]) {
        pair(name, i, *expected_pair_[i]);
      } else {
        missing(name, i);
      }
    }
    for (std::size_t j = 0; j < found_.size(); ++j) {
      if (!found_pair_[j]) superfluous(j);
    }
    std::stable_sort(result_.partials.begin(), result_.partials.end(),
                     [](const PartialComparison& a, const PartialComparison& b) {
                       const auto frequency = [](const PartialComparison& p) {
                         return (p.reference ? p.reference : p.sound)->frequency_hz;
                       };
                       return frequency(a) < frequency(b);
                     });
  }

  void pair(const std::string& name, std::size_t i, std::size_t j) {
    const fit::Partial &p = expected_[i], &q = found_[j];
    const ReferencePartial& known = reference_.partials[i];
    const std::string where = "Partial at " + hz(p.frequency_hz);
    PartialComparison row{p, q, {}, {}, {}, {}, {}};
    if (disturbed(i, j)) {
      row.note = "runs together with a neighbour that only one of the two analyses tells apart";
    } else if (reference_.n_takes == 1 && (runs_into_louder(expected_, p) || runs_into_louder(found_, q))) {
      // Real ringing is not quite a sum of exponentials: noise decides how neighbours share what is left over. Takes show by how much.
      row.note = "runs together with a neighbour; several takes would tell how much that matters";
    }

    const double std_cents =
        std::hypot(own_std(detail::kCentsPerNeper * relative_std(p.frequency_std_hz, p.frequency_hz),
                           known.frequency_scatter_cents),
                   detail::kCentsPerNeper * relative_std(q.frequency_std_hz, q.frequency_hz));
    row.cents = cents(q.frequency_hz, p.frequency_hz);
    row.cents_tolerance = tolerance(options_.floor_cents, std_cents, known.frequency_scatter_cents, scatter_factor_);
    add(name + ".frequency", where + " keeps its frequency [cents]",
        {*row.cents, *row.cents_tolerance, std_cents, one_more_ * known.frequency_scatter_cents, options_.catch_cents,
         "cents"},
        row.note);
    if (row.note.empty()) shift_.add(*row.cents, std_cents, one_more_ * known.frequency_scatter_cents);

    if (p.decay_per_s && q.decay_per_s && *p.decay_per_s > 0.0) {
      const double std_decay = std::hypot(own_std(relative_std(p.decay_std_per_s, p.decay_per_s), known.decay_scatter),
                                          q.decay_std_per_s.value_or(0.0) / *p.decay_per_s);
      row.decay_change = *q.decay_per_s / *p.decay_per_s - 1.0;
      row.decay_tolerance = tolerance(options_.floor_decay, std_decay, known.decay_scatter, decay_scatter_factor_);
      const bool falls =
          std::max(*p.decay_per_s, *q.decay_per_s) * std::min(reference_.duration_s, sound_.duration_s) >= kLeastFall;
      // Deviations of this size are not those of a straight line: no tolerance follows from them.
      const bool known_at_all = *row.decay_tolerance <= 1.0;
      add(name + ".decay", where + " keeps its decay [%]",
          {100.0 * *row.decay_change, 100.0 * *row.decay_tolerance, 100.0 * std_decay,
           100.0 * one_more_ * known.decay_scatter, 100.0 * options_.catch_decay, "%"},
          !row.note.empty() ? row.note
          : !falls          ? "rings far beyond the end of the sound"
          : !known_at_all   ? "its decay is known to no better than its own size"
                            : "");
    }
    result_.partials.push_back(std::move(row));
  }

  /// Mean over partials, weighted by what is known of each, with both parts of its deviation.
  struct Mean {
    double weights = 0.0, sum = 0.0, noise_sq = 0.0, scatter_sq = 0.0;
    int n = 0;
    void add(double value, double std, double scatter) {
      const double weight = 1.0 / std::max(std * std + scatter * scatter, 1e-12);
      weights += weight;
      sum += weight * value;
      noise_sq += weight * weight * std * std;
      scatter_sq += weight * weight * scatter * scatter;
      ++n;
    }
  };

  /// All partials' common shift: takes that move as a whole are held by their own scatter, on as many degrees as there are takes.
  void together(double probability) {
    if (shift_.n < 2) return;
    const double noise = std::sqrt(shift_.noise_sq) / shift_.weights;
    const bool common = reference_.common_scatter_cents > 0.0;
    const double scatter =
        common ? one_more_ * reference_.common_scatter_cents : std::sqrt(shift_.scatter_sq) / shift_.weights;
    const double factor = scatter_factor(probability, common ? reference_.n_takes - 1.0 : reference_.scatter_dof);
    const double allowed =
        std::hypot(options_.floor_cents, detail::normal_two_sided(probability) * noise, factor * scatter);
    add("all-partials.frequency", "All partials together keep their pitch [cents]",
        {shift_.sum / shift_.weights, allowed, noise, scatter, options_.catch_shift_cents, "cents"}, "");
  }

  /// A claim about a difference; not judged where it holds and a change worth catching would hold too.
  struct Difference {
    double value = 0.0, allowed = 0.0, std = 0.0, scatter = 0.0;
    double worth = 0.0;  ///< catching
    const char* unit = "";
  };
  void add(const std::string& name, const std::string& words, const Difference& of, const std::string& reason) {
    const auto& [difference, allowed, std, scatter, worth, unit] = of;
    Claim claim{name, words, difference, 0.0, allowed, {}, false, reason};
    const double sensitivity = allowed + kCaught * std::hypot(std, scatter);
    if (reason.empty() && std::abs(difference) <= allowed && !(sensitivity <= worth)) {
      const double shown = std::ceil(sensitivity * 100.0) / 100.0;
      claim.not_judged = std::string(scatter > std ? "takes scatter too much" : "too weak in the noise") +
                         ": a change of up to " + to_text(shown) + " " + unit + " could hide";
    }
    result_.claims.push_back(judged(std::move(claim)));
  }

  void missing(const std::string& name, std::size_t i) {
    const fit::Partial& p = expected_[i];
    PartialComparison row{p, {}, {}, {}, {}, {}, {}};
    // As weak as one take in a hundred would have it: strikes differ.
    const double n = reference_.n_takes;
    const double spread = n > 1.0 ? std::sqrt(n + 1.0) * relative_std(p.amplitude_std, p.amplitude) : 0.0;
    const double amplitude =
        p.amplitude.value_or(0.0) * std::pow(10.0, result_.gain_db / 20.0) * std::exp(-kCaught * spread);
    const double heard = heard_db(amplitude, p.decay_per_s.value_or(0.0), sound_.noise_density(p.frequency_hz),
                                  sound_.duration_s, sound_.contact_s);
    if (p.frequency_hz < sound_.band.low_hz || p.frequency_hz > sound_.band.high_hz) {
      row.note = "outside the band that was analysed";
    } else if (!(heard >= kHeardDb)) {
      row.note = "the sound's noise would hide it";
    } else if (!(p.amplitude.value_or(0.0) >= loudest_ * std::pow(10.0, -options_.range_db / 20.0))) {
      row.note = "far below the loudest partial";
    } else if (runs_into_another(expected_, p)) {
      row.note = "runs together with a neighbour";
    } else if (reference_.partials[i].n_takes < reference_.n_takes) {
      row.note = "not in every take of the reference";
    } else if (of_the_blow(p)) {
      row.note = "over before the body rings: the blow's";
    }
    presence(name + ".there", "Partials missing at " + hz(p.frequency_hz), row.note);
    result_.partials.push_back(std::move(row));
  }

  void superfluous(std::size_t j) {
    const fit::Partial& q = found_[j];
    PartialComparison row{{}, q, {}, {}, {}, {}, {}};
    const double amplitude = q.amplitude.value_or(0.0) * std::pow(10.0, -result_.gain_db / 20.0);
    const double own_db = -20.0 * std::log10(std::max(relative_std(q.amplitude_std, q.amplitude), 1e-12));
    const double heard = heard_db(amplitude, q.decay_per_s.value_or(0.0),
                                  validate::noise_density(reference_.fingerprint, q.frequency_hz),
                                  reference_.duration_s, reference_.contact_s);
    const bool occasional = std::any_of(reference_.occasional_hz.begin(), reference_.occasional_hz.end(),
                                        [&](double f) { return std::abs(cents(q.frequency_hz, f)) <= 50.0; });
    if (q.frequency_hz < reference_.band.low_hz || q.frequency_hz > reference_.band.high_hz) {
      row.note = "outside the band of the reference";
    } else if (!(heard >= kHeardDb)) {
      row.note = "the reference's noise would hide it";
    } else if (!(own_db >= kClearSuperfluousDb)) {
      row.note = "too weak in the noise";
    } else if (!(amplitude >= loudest_ * std::pow(10.0, -options_.range_db / 20.0))) {
      row.note = "far below the loudest partial";
    } else if (occasional) {
      row.note = "in some takes of the reference";
    } else if (runs_into_another(found_, q)) {
      row.note = "runs together with a neighbour";
    } else if (of_the_blow(q)) {
      row.note = "over before the body rings: the blow's";
    }
    const std::string number = std::to_string(++n_superfluous_);
    presence("superfluous-" + number, "Partials at " + hz(q.frequency_hz) + " that the reference has not", row.note);
    result_.partials.push_back(std::move(row));
  }

  /// A partial that is in one of the two only: failed, unless there is a reason.
  void presence(const std::string& name, const std::string& words, const std::string& reason) {
    result_.claims.push_back(judged(Claim{name, words, 1.0, 0.0, 0.5, {}, false, reason}));
  }

  void thirds() {
    const Fingerprint &a = reference_.fingerprint, &b = sound_.fingerprint;
    const double gain = std::pow(10.0, 0.1 * result_.gain_db);
    const auto n = static_cast<double>(n_frames_);
    std::vector<double> expected, found, expected_noise, found_noise;
    double loudest = 0.0;
    for (Eigen::Index i = 0; i < n_thirds_; ++i) {
      expected_noise.push_back(static_cast<double>(a.noise.segment(4 * i, 4).sum()));
      found_noise.push_back(static_cast<double>(b.noise.segment(4 * i, 4).sum()) / gain);
      expected.push_back(static_cast<double>(a.power.block(4 * i, 0, 4, n_frames_).sum()) / n - expected_noise.back());
      found.push_back(static_cast<double>(b.power.block(4 * i, 0, 4, n_frames_).sum()) / (n * gain) -
                      found_noise.back());
      loudest = std::max({loudest, expected.back(), found.back()});
    }
    for (Eigen::Index i = 0; i < n_thirds_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const audio::ThirdOctave band = a.third(i);
      const double cells = std::max(1.0, (band.high_hz() - band.low_hz()) * result_.common_s);
      const double tiny = 1e-20;
      // What is below its own noise counts as that noise: the other's surplus is what is judged.
      const double p = std::max(expected[k], expected_noise[k] + tiny), q = std::max(found[k], found_noise[k] + tiny);
      ThirdComparison row{band.centre_hz(), 10.0 * std::log10(p), 10.0 * std::log10(q), {}, {}};
      const double strongest = std::max(p, q);
      const std::string name = "third-octave-" + std::to_string(std::lround(band.centre_hz()));
      if (strongest > detail::kLevelRange * loudest &&
          strongest > kClearBand * std::max(expected_noise[k], found_noise[k])) {
        const auto variance = [&](double power, double noise) {
          return (noise * noise + 2.0 * power * noise) / (cells * power * power);
        };
        const double std_db = std::hypot(
            0.5 * kDbPerNeper * std::sqrt(variance(p, expected_noise[k]) + variance(q, found_noise[k])), gain_std_db_);
        row.difference_db = row.sound_db - row.reference_db;
        row.tolerance_db =
            tolerance(options_.floor_level_db, std_db, reference_.third_scatter_db[k], level_scatter_factor_);
        if (options_.levels) {
          result_.claims.push_back(judged(Claim{name,
                                                "Third octave at " + hz(band.centre_hz()) + " keeps its level [dB]",
                                                *row.difference_db,
                                                0.0,
                                                *row.tolerance_db,
                                                {},
                                                false,
                                                {}}));
        }
      }
      result_.thirds.push_back(row);
    }
  }

  /// A take's distance from a mean that it is not part of, over that from the mean of n takes with it: sqrt((n + 1) / (n - 1)).
  double mean_of_takes() const {
    const double n = reference_.n_takes;
    return n > 1.0 ? std::sqrt((n + 1.0) / (n - 1.0)) : 1.0;
  }

  void spectrum() {
    const Fingerprint &a = reference_.fingerprint, &b = sound_.fingerprint;
    const Eigen::Index n_bands = 4 * n_thirds_;
    const auto gain = static_cast<float>(std::pow(10.0, 0.1 * result_.gain_db));
    const float loudest = std::max(a.power.topLeftCorner(n_bands, n_frames_).maxCoeff(),
                                   b.power.topLeftCorner(n_bands, n_frames_).maxCoeff() / gain);
    result_.reference_db.resize(n_bands, n_frames_);
    result_.sound_db.resize(n_bands, n_frames_);
    double sum = 0.0, expected = 0.0, count = 0.0;
    for (Eigen::Index i = 0; i < n_bands; ++i) {
      result_.bands_hz.push_back(a.centre_hz(i));
      const float noise = std::max(a.noise[i], b.noise[i] / gain);
      const float floor = std::max(kCellRange * loudest, kClearCell * noise);
      for (Eigen::Index t = 0; t < n_frames_; ++t) {
        const float p = std::max(a.power(i, t), floor), q = std::max(b.power(i, t) / gain, floor);
        result_.reference_db(i, t) = 10.0f * std::log10(p);
        result_.sound_db(i, t) = 10.0f * std::log10(q);
        if (!(std::max(p, q) > floor)) continue;
        const double difference = static_cast<double>(result_.sound_db(i, t) - result_.reference_db(i, t));
        sum += difference * difference;
        expected +=
            0.25 * kDbPerNeper * kDbPerNeper * 2.0 * static_cast<double>(a.noise[i] / p + b.noise[i] / gain / q);
        ++count;
      }
    }
    for (Eigen::Index t = 0; t < n_frames_; ++t) {
      result_.times_s.push_back(static_cast<double>(t) * a.hop_s + 0.5 * a.window_s);
    }
    if (count > 0.0) result_.log_spectral_distance_db = std::sqrt(sum / count);
    if (!options_.levels) return;
    Claim claim{"log-spectral-distance",
                "Levels over time and frequency stay [dB rms]",
                result_.log_spectral_distance_db.value_or(0.0),
                0.0,
                0.0,
                {},
                false,
                {}};
    // Of the cells' own noise the mean is known; neighbouring cells go together, so that it is taken twice.
    claim.tolerance =
        std::sqrt(options_.floor_spectrum_db * options_.floor_spectrum_db + 2.0 * expected / std::max(count, 1.0)) +
        2.0 * reference_.spectrum_scatter_db * mean_of_takes();
    if (!result_.log_spectral_distance_db) claim.not_judged = "nothing stands above the noise";
    result_.claims.push_back(judged(std::move(claim)));
  }

  const ReferenceSpectrum& reference_;
  const SoundDescription& sound_;
  const RegressionOptions& options_;
  std::vector<fit::Partial> expected_;
  const std::vector<fit::Partial>& found_;
  std::vector<std::optional<std::size_t>> expected_pair_, found_pair_;
  double loudest_ = 0.0, gain_std_db_ = 0.0, one_more_ = 1.0;
  double scatter_factor_ = 0.0, decay_scatter_factor_ = 0.0, level_scatter_factor_ = 0.0;
  Mean shift_;
  Eigen::Index n_frames_ = 0, n_thirds_ = 0;
  int n_superfluous_ = 0;
  RegressionResult result_;
};

}  // namespace

void RegressionOptions::validate() const { validate_fields("regression", *this); }

int RegressionResult::n_failed() const {
  return static_cast<int>(
      std::count_if(claims.begin(), claims.end(), [](const Claim& c) { return !c.passed && c.not_judged.empty(); }));
}

int RegressionResult::n_not_judged() const {
  return static_cast<int>(
      std::count_if(claims.begin(), claims.end(), [](const Claim& c) { return !c.not_judged.empty(); }));
}

RegressionResult compare(const ReferenceSpectrum& reference, const SoundDescription& sound,
                         const RegressionOptions& options) {
  options.validate();
  if (reference.partials.empty()) throw InputError(reference.origin, "has an empty spectrum");
  if (sound.partials.partials.empty()) throw InputError(sound.origin, "has an empty spectrum");
  const Fingerprint &a = reference.fingerprint, &b = sound.fingerprint;
  if (a.window_s != b.window_s || a.hop_s != b.hop_s || a.first_third != b.first_third) {
    throw InputError(
        reference.origin, "its fingerprint has other windows or bands",
        to_text(a.window_s) + " s every " + to_text(a.hop_s) + " s",
        to_text(b.window_s) + " s every " + to_text(b.hop_s) + " s from third octave " + std::to_string(b.first_third));
  }
  return Comparison(reference, sound, options).run();
}

}  // namespace klang::validate
