#include "fit/bubble/bubble_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/audio/fft.hpp"
#include "core/base/errors.hpp"
#include "core/base/parallel.hpp"
#include "core/bubble/bubble_formulas.hpp"
#include "fit/bubble/damped_filter.hpp"

namespace klang::fit::bubble {
namespace {

using klang::bubble::BubbleMedium;
using klang::bubble::BubbleTheory;

constexpr double kChi2OfScore = 2.0;       // a ring's chi square is twice its best matched-filter score
constexpr Eigen::Index kWhiteningReach = 1024;
constexpr std::size_t kMostTogether = 6;   // rings fitted in one least-squares problem
constexpr double kHeardLevel = 0.05;       // of the amplitude at the onset: the end of what tells the pitch
constexpr double kHeardSpan = 7.0;         // decay times until a ring is over (-61 dB)
// A weak ring on top of a strong one is what the strong one's model leaves, not a bubble.
constexpr double kFragmentEnergy = 0.03, kFragmentOctaves = 0.5;
// And so is what it leaves at any pitch while it begins.
constexpr double kOnsetFragmentEnergy = 0.003, kOnsetS = 0.003, kFarFragmentEnergy = 3e-4;
constexpr double kHopelessDecay = 40.0;     // of theory's, up or down: no ring
// Standard deviations beyond which a ring is too short or too noisy to be called anything: as wide as the prior.
constexpr double kUnclearRatePerS = 40.0, kUnclearDecay = 0.4, kUnclearPitch = 0.03;
constexpr double kAttackShare = 0.5;       // while neighbours are not yet found, their sound must not pass for an attack
constexpr double kScrapEnergy = 0.1;       // of a ring's, beginning with it: may be what its attack leaves
constexpr double kAttackGain = 10.0;       // chi square that another kind of attack must win
constexpr double kLeastShare = 0.35;       // of what stands above the noise around it: less is a patch of a splash
constexpr double kLeastStartShare = 0.1;   // the same before any fitting
constexpr double kLeastTryShare = 0.2;     // and after a few steps
constexpr std::array<std::pair<double, double>, 8> kStartPitches = {
    {{0.0, 0.0}, {10.0, 20.0}, {16.0, 35.0}, {25.0, 20.0}, {25.0, 40.0}, {50.0, 20.0}, {50.0, 60.0}, {-15.0, 0.0}}};  // rate, growth [1/s]
constexpr int kMostFailures = 20;          // candidates in a row that were none: the rest are weaker still
constexpr double kQuickAttack = 2.0;       // rate of the quick attack over the frequency: a twelfth of a cycle
constexpr double kOnsetCycles = 0.1;       // how well a quick attack's form tells the onset
constexpr double kOnsetDecays = 0.1;       // and a soft one's, in decay times: it may have been quick and faint
constexpr double kRestGain = 25.0;          // chi square that a rest must win, with its time one more free number
constexpr double kRestShare = 0.2;          // and of what is left above the noise
constexpr std::size_t kRestStarts = 5;
constexpr double kLatestRest = 3.0;         // decay times: later nothing is heard of it
constexpr double kLeastDecayRatio = 0.6, kMostDecayRatio = 10.0, kLeastRise = 0.05;

double decay_of(const BubbleMedium& medium, BubbleTheory theory, double radius_m, double omega) {
  return klang::bubble::bubble_damping(medium, theory, radius_m, omega).decay_per_s;
}

/// Samples of a ring: from its onset until it is over.
struct Span {
  Eigen::Index first = 0, last = 0;
};

class Search {
 public:
  Search(const audio::Signal& recording, const BubbleSearchOptions& options, Monitor& monitor)
      : options_(options), monitor_(monitor), rate_(recording.sample_rate_hz) {
    result_.mono.sample_rate_hz = rate_;
    result_.mono.origin = recording.origin;
    result_.mono.samples = recording.samples.rowwise().mean();
    high_hz_ = std::min(options.band.high_hz, 0.45 * rate_);
    if (!(high_hz_ > options.band.low_hz)) throw InputError(recording.origin, "band lies above 0.45 of the sample rate");
  }

  BubbleSearchResult run();
  std::vector<RingGroup> windows(const BubbleSearchResult& result);

 private:
  ChirpLaw law_at(double frequency_hz, const ChirpLaw& like) const;
  Span span_of(const Chirp& chirp) const;
  std::pair<double, double> band_of(const FoundBubble& bubble) const;
  ChirpWindow window_of(const std::vector<const FoundBubble*>& group) const;
  void add(const FoundBubble& bubble, double sign);
  std::optional<FoundBubble> fitted_near(const DampedFilterBank::Peak& peak, const DampedFilterBank::Atom& atom) const;
  double choose_attack(const ChirpWindow& own, FoundBubble& bubble, double chi_square, double share) const;
  double choose_rest(const ChirpWindow& own, FoundBubble& bubble, double chi_square) const;
  void choose_attacks();
  void choose_rests();
  bool overlap(const FoundBubble& a, const FoundBubble& b) const;
  void refit(const std::vector<std::size_t>& group, bool last);
  std::vector<std::vector<std::size_t>> groups() const;
  void make_filters();
  void whiten(const Eigen::VectorXd& change, Eigen::Index first, Eigen::Index n);
  double energy_of(const FoundBubble& bubble) const;
  void mask(const FoundBubble& bubble);
  void prune();
  void judge(FoundBubble& bubble) const;

  BubbleSearchOptions options_;
  Monitor& monitor_;
  double rate_, high_hz_ = 0.0;
  BubbleSearchResult result_;
  Eigen::VectorXd residual_;
  Eigen::VectorXf whitened_;
  std::unique_ptr<DampedFilterBank> filters_;
};

/// Law of a ring of this pitch that begins, and comes to rest, as another does.
ChirpLaw Search::law_at(double frequency_hz, const ChirpLaw& like) const {
  static const auto pitch = std::make_shared<const ExponentialPitch>();
  ChirpLaw law = like;
  law.pitch = pitch;
  law.amplitude_exponent = options_.amplitude_exponent;
  const double radius_m = radius_of_frequency_m(frequency_hz, options_.medium, options_.theory), omega = 2.0 * kPi * frequency_hz;
  law.decay_exponent = std::log(decay_of(options_.medium, options_.theory, radius_m, 1.05 * omega) /
                                decay_of(options_.medium, options_.theory, radius_m, omega / 1.05)) / (2.0 * std::log(1.05));
  return law;
}

Span Search::span_of(const Chirp& chirp) const {
  const double beta = std::exp(chirp.log_decay);
  const auto n = residual_.size();
  Span span;
  span.first = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::ceil(chirp.onset_s * rate_)), 0, n - 1);
  span.last = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::ceil((chirp.onset_s + kHeardSpan / beta) * rate_)), span.first + 1, n);
  return span;
}

std::pair<double, double> Search::band_of(const FoundBubble& bubble) const {
  const double beta = std::exp(bubble.chirp.log_decay), f = std::exp(bubble.chirp.log_frequency);
  const double ratio = std::exp(bubble.law.pitch_at(2.5 / beta, bubble.chirp.pitch).log_ratio), side = 3.0 * beta / (2.0 * kPi);
  return {std::max(options_.band.low_hz, 0.75 * std::min(f, f * ratio) - side),
          std::min(high_hz_, 1.35 * std::max(f, f * ratio) + side)};
}

ChirpWindow Search::window_of(const std::vector<const FoundBubble*>& group) const {
  Eigen::Index first = residual_.size(), last = 0;
  double low = 1e9, high = 0.0;
  for (const FoundBubble* bubble : group) {
    const Span span = span_of(bubble->chirp);
    const double beta = std::exp(bubble->chirp.log_decay);
    first = std::min(first, span.first - static_cast<Eigen::Index>((0.003 + 1.0 / beta) * rate_));
    last = std::max(last, span.last);
    const auto band = band_of(*bubble);
    low = std::min(low, band.first);
    high = std::max(high, band.second);
  }
  first = std::max<Eigen::Index>(0, first);
  last = std::min(std::max(last, first + 128), residual_.size());
  // The group's own sound is put back.
  Eigen::VectorXd samples = residual_.segment(first, last - first);
  for (const FoundBubble* bubble : group) {
    const Span span = span_of(bubble->chirp);
    Eigen::VectorXd value(std::min(span.last, last) - span.first);
    evaluate_chirp(bubble->law, bubble->chirp, static_cast<double>(span.first) / rate_, rate_, value);
    samples.segment(span.first - first, value.size()) += value;
  }
  return ChirpWindow(samples, rate_, first, residual_.size(), low, high, result_.noise);
}

void Search::whiten(const Eigen::VectorXd& change, Eigen::Index first, Eigen::Index n) {
  const Eigen::Index low = std::max<Eigen::Index>(0, first - kWhiteningReach), high = std::min(whitened_.size(), first + n + kWhiteningReach);
  const Eigen::Index n_fft = audio::good_fft_size(high - low + kWhiteningReach);
  const Eigen::Index even = n_fft % 2 ? audio::good_fft_size(n_fft + 1) : n_fft;
  Eigen::VectorXd padded = Eigen::VectorXd::Zero(even);
  padded.segment(first - low, n) = change;
  Eigen::VectorXcd spectrum = audio::real_spectrum(padded, even);
  for (Eigen::Index k = 0; k < spectrum.size(); ++k) {
    const double f = rate_ * static_cast<double>(k) / static_cast<double>(even);
    // Steep edges would ring before a strong onset.
    const double edge = std::clamp(std::min((f / options_.band.low_hz - 1.0) / 0.25, (1.0 - f / high_hz_) / 0.1), 0.0, 1.0);
    spectrum[k] *= edge > 0.0 ? edge * edge * (3.0 - 2.0 * edge) / std::sqrt(result_.noise.at(f)) : 0.0;
  }
  const Eigen::VectorXd white = audio::real_from_spectrum(spectrum, even);
  whitened_.segment(low, high - low) += white.head(high - low).cast<float>();
}

void Search::add(const FoundBubble& bubble, double sign) {
  const Span span = span_of(bubble.chirp);
  Eigen::VectorXd value(span.last - span.first);
  evaluate_chirp(bubble.law, bubble.chirp, static_cast<double>(span.first) / rate_, rate_, value);
  value *= sign;
  residual_.segment(span.first, value.size()) += value;
  whiten(value, span.first, value.size());
  filters_->update(whitened_, span.first - kWhiteningReach, span.last + kWhiteningReach);
}

void Search::make_filters() {
  std::vector<DampedFilterBank::Atom> atoms;
  for (double f = 1.05 * options_.band.low_hz; f < 0.97 * high_hz_;) {
    const double beta = decay_of(options_.medium, options_.theory, radius_of_frequency_m(f, options_.medium, options_.theory), 2.0 * kPi * f);
    atoms.push_back({f, beta});
    f += beta / kPi;  // neighbours are off by no more than the decay: at most 1 dB is lost
  }
  filters_ = std::make_unique<DampedFilterBank>(std::move(atoms), rate_, residual_.size());
}

/// @param share  of what the fit leaves above the noise that the other attack must explain
double Search::choose_attack(const ChirpWindow& own, FoundBubble& bubble, double chi_square, double share) const {
  const auto n_data = static_cast<double>(own.n_real_data());
  if (!options_.soft_attack || (share > 0.0 && !(chi_square > n_data + std::sqrt(2.0 * n_data)))) return chi_square;
  // What is struck, or closes in a snap, begins at once. Where, the fit feels only within a cycle or so: look first.
  const double f = std::exp(bubble.chirp.log_frequency), beta = std::exp(bubble.chirp.log_decay);
  const bool to_quick = bubble.law.soft_attack();
  ChirpLaw law = bubble.law;
  law.quick_attack_per_s = to_quick ? kQuickAttack * f : 0.0;
  Chirp start = bubble.chirp;
  double least = 1e300;
  // The same track, begun at another time.
  const auto consider = [&](double shift) {
    ChirpLaw moved = law;
    if (moved.rest_s) *moved.rest_s = std::max(0.0, *bubble.law.rest_s - shift);
    Chirp trial = bubble.chirp;
    trial.onset_s += shift;
    trial.log_frequency += bubble.law.pitch_at(shift, bubble.chirp.pitch).log_ratio;
    trial.pitch[0] *= std::exp(trial.pitch[1] * shift);
    const double chi = fit_amplitude(own, moved, trial);
    if (!(chi < least)) return;
    least = chi;
    start = trial;
    law.rest_s = moved.rest_s;
  };
  const double first = to_quick ? -1.0 / f : -0.3 / beta - 1.0 / f, last = to_quick ? 0.3 / beta + 2.0 / f : 1.0 / f;
  for (double shift = first; shift < last; shift += 0.25 / f) consider(shift);
  const double coarse = start.onset_s - bubble.chirp.onset_s;
  for (int step = -8; step <= 8; ++step) consider(coarse + 0.03 * step / f);
  const ChirpFit other = fit_chirps(own, {law}, {start}, {}, 40, false);
  if (!(other.ok && other.chi_square < chi_square - std::max(share > 0.0 ? kAttackGain : 0.0, share * (chi_square - n_data)))) return chi_square;
  bubble.law = law;
  bubble.chirp = other.chirps[0];
  return other.chi_square;
}

/// Whether the pitch stays from some time on, which no smooth law follows: tried where the smooth one leaves more than noise.
double Search::choose_rest(const ChirpWindow& own, FoundBubble& bubble, double chi_square) const {
  const auto n_data = static_cast<double>(own.n_real_data());
  if (!(chi_square > n_data + 4.0 * std::sqrt(2.0 * n_data))) return chi_square;
  const double f = std::exp(bubble.chirp.log_frequency), beta = std::exp(bubble.chirp.log_decay);
  FoundBubble best = bubble;
  double least = 1e300;
  const auto consider = [&](double rest_s, const Chirp& from, int n_steps) {
    FoundBubble trial = best;
    trial.law.rest_s = rest_s;
    const ChirpFit fit = fit_chirps(own, {trial.law}, {from}, {}, n_steps, false);
    if (!(fit.ok && fit.chi_square < least)) return;
    least = fit.chi_square;
    best.law.rest_s = rest_s;
    best.chirp = fit.chirps[0];
  };
  struct Start {
    double rest_s;
    Chirp chirp;
    double chi_square;
  };
  std::vector<Start> starts;
  for (double rest_s = std::max(0.1 / beta, 2.0 / f); rest_s < kLatestRest / beta; rest_s *= 1.2) {
    // The same way up until then, growing as a rise at an even speed does.
    const double rise = bubble.law.pitch_at(rest_s, bubble.chirp.pitch).log_ratio, growth = 20.0;
    Chirp growing = bubble.chirp;
    growing.pitch = {rise * growth / std::expm1(growth * rest_s), growth};
    for (Chirp start : {bubble.chirp, growing}) {
      ChirpLaw law = bubble.law;
      law.rest_s = rest_s;
      const double chi = fit_amplitude(own, law, start);
      starts.push_back({rest_s, start, chi});
    }
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.chi_square < b.chi_square; });
  starts.resize(std::min<std::size_t>(starts.size(), kRestStarts));
  for (const Start& start : starts) consider(start.rest_s, start.chirp, 8);
  if (!best.law.rest_s) return chi_square;
  for (const double step : {0.08, 0.03, 0.01, 0.003})
    for (const double sign : {-1.0, 1.0}) consider(*best.law.rest_s * (1.0 + sign * step), best.chirp, 8);
  consider(*best.law.rest_s, best.chirp, 40);
  if (!(least < chi_square - std::max(kRestGain, kRestShare * (chi_square - n_data)))) return chi_square;
  bubble.law = best.law;
  bubble.chirp = best.chirp;
  return least;
}

std::optional<FoundBubble> Search::fitted_near(const DampedFilterBank::Peak& peak, const DampedFilterBank::Atom& atom) const {
  FoundBubble bubble;
  if (!options_.soft_attack) bubble.law.quick_attack_per_s = kQuickAttack * atom.frequency_hz;
  bubble.law = law_at(atom.frequency_hz, bubble.law);
  const double time = static_cast<double>(peak.sample) / rate_;
  struct Start {
    Chirp chirp;
    double chi_square;
  };
  std::vector<Start> starts;
  FoundBubble widest = bubble;
  widest.chirp.onset_s = std::max(0.0, time - 1.0 / atom.decay_per_s);
  widest.chirp.log_frequency = std::log(atom.frequency_hz);
  widest.chirp.log_decay = std::log(0.7 * atom.decay_per_s);
  const ChirpWindow wide = window_of({&widest});
  for (const auto& [rate, growth] : kStartPitches) {
    for (const double earlier : {0.0, 0.5, 1.0}) {
      Chirp chirp;
      chirp.pitch = {rate, growth};
      chirp.onset_s = std::max(0.0, time - earlier / atom.decay_per_s);
      chirp.log_decay = std::log(atom.decay_per_s);
      // The atom saw the frequency of about half a decay time after its begin.
      chirp.log_frequency = std::log(atom.frequency_hz) - rate * (time + 0.4 / atom.decay_per_s - chirp.onset_s);
      const double chi = fit_amplitude(wide, bubble.law, chirp);
      starts.push_back({chirp, chi});
    }
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.chi_square < b.chi_square; });
  const double silent_chi = wide.data.cwiseProduct(wide.weight.cast<std::complex<double>>()).squaredNorm();
  const double wanted = std::pow(10.0, 0.1 * options_.min_snr_db);
  // No start explains a third of what is asked for: a blot of noise that no chirp will fit.
  const double found = silent_chi - starts.front().chi_square;
  if (!(found >= 0.3 * wanted && found >= kLeastStartShare * (silent_chi - static_cast<double>(wide.n_real_data())))) return std::nullopt;
  starts.resize(std::min<std::size_t>(starts.size(), 3));
  // A few steps from each, then only the best goes on.
  std::vector<ChirpFit> tries(starts.size());
  parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) tries[i] = fit_chirps(wide, {bubble.law}, {starts[i].chirp}, {}, 8, false);
  });
  double best = 1e300;
  for (const ChirpFit& fit : tries) {
    if (!fit.ok || !(fit.chi_square < best)) continue;
    best = fit.chi_square;
    bubble.chirp = fit.chirps[0];
  }
  if (best >= 1e300) return std::nullopt;
  if (!(silent_chi - best >= kLeastTryShare * (silent_chi - static_cast<double>(wide.n_real_data())))) return std::nullopt;
  // Once more under the window that its own pitch and decay ask for.
  FoundBubble silent = bubble;
  silent.chirp.cosine = silent.chirp.sine = 0.0;
  const ChirpWindow own = window_of({&silent});
  const double before = own.data.cwiseProduct(own.weight.cast<std::complex<double>>()).squaredNorm();
  const double f = std::exp(bubble.chirp.log_frequency);
  if (!(f > options_.band.low_hz && f < high_hz_)) return std::nullopt;
  const double beta = std::exp(bubble.chirp.log_decay);
  if (!(beta < kHopelessDecay * atom.decay_per_s && beta > atom.decay_per_s / kHopelessDecay)) return std::nullopt;
  if (!(bubble.chirp.onset_s > -1e-3)) return std::nullopt;
  bubble.law = law_at(f, bubble.law);
  const ChirpFit fit = fit_chirps(own, {bubble.law}, {bubble.chirp}, {}, 40, false);
  if (!fit.ok) return std::nullopt;
  bubble.chirp = fit.chirps[0];
  const double gain = before - choose_attack(own, bubble, fit.chi_square, kAttackShare);
  const auto n_data = static_cast<double>(fit.n_real_data);
  if (!(gain >= wanted && gain >= kLeastShare * (before - n_data))) return std::nullopt;
  return bubble;
}

bool Search::overlap(const FoundBubble& a, const FoundBubble& b) const {
  const Span sa = span_of(a.chirp), sb = span_of(b.chirp);
  const auto ba = band_of(a), bb = band_of(b);
  return sa.first < sb.last && sb.first < sa.last && ba.first < bb.second && bb.first < ba.second;
}

void Search::refit(const std::vector<std::size_t>& group, bool last) {
  std::vector<const FoundBubble*> members;
  std::vector<ChirpLaw> laws;
  std::vector<Chirp> start;
  for (const std::size_t i : group) {
    const FoundBubble& bubble = result_.found[i];
    members.push_back(&bubble);
    laws.push_back(law_at(std::clamp(std::exp(bubble.chirp.log_frequency), options_.band.low_hz, high_hz_), bubble.law));
    start.push_back(bubble.chirp);
  }
  const ChirpWindow window = window_of(members);
  const ChirpFit fit = fit_chirps(window, laws, start, {}, last ? 60 : 12, last);
  if (!fit.ok) return;
  for (std::size_t k = 0; k < group.size(); ++k) {
    FoundBubble& bubble = result_.found[group[k]];
    add(bubble, 1.0);
    bubble.law = laws[k];
    bubble.chirp = fit.chirps[k];
    add(bubble, -1.0);
    if (!last) continue;
    // Where the band holds more than the noise floor (echoes, splashes), the errors grow with it.
    const double dof = static_cast<double>(fit.n_real_data) - 7.0 * static_cast<double>(group.size());
    bubble.covariance = std::max(1.0, fit.chi_square / std::max(dof, 1.0)) * fit.covariance[k];
  }
}

/// Once more with all others known: alone, a ring takes the attack that suits its neighbours' sound, and with it the scraps
/// that stood for the wrong one.
void Search::choose_attacks() {
  std::vector<double> energy;
  for (const FoundBubble& bubble : result_.found) energy.push_back(energy_of(bubble));
  std::vector<bool> keep(result_.found.size(), true);
  for (std::size_t i = 0; i < result_.found.size(); ++i) {
    monitor_.throw_if_stopped();
    if (!keep[i]) continue;
    FoundBubble& bubble = result_.found[i];
    const double near_s = std::max(kOnsetS, 0.3 / std::exp(bubble.chirp.log_decay));
    std::vector<std::size_t> scraps;
    for (std::size_t j = 0; j < result_.found.size(); ++j)
      if (j != i && keep[j] && energy[j] < kScrapEnergy * energy[i] && std::abs(result_.found[j].chirp.onset_s - bubble.chirp.onset_s) < near_s) scraps.push_back(j);
    if (scraps.size() >= kMostTogether) scraps.resize(kMostTogether - 1);
    std::vector<const FoundBubble*> members = {&bubble};
    std::vector<ChirpLaw> laws = {bubble.law};
    std::vector<Chirp> chirps = {bubble.chirp};
    for (const std::size_t j : scraps) {
      members.push_back(&result_.found[j]);
      laws.push_back(result_.found[j].law);
      chirps.push_back(result_.found[j].chirp);
    }
    const ChirpWindow window = window_of(members);
    const double with_scraps = fit_chirps(window, laws, chirps, {}, 0, false).chi_square;
    const double alone = fit_chirps(window, {bubble.law}, {bubble.chirp}, {}, 0, false).chi_square;
    FoundBubble other = bubble;
    const double chosen = choose_attack(window, other, alone, 0.0);
    if (!(chosen < alone && chosen < with_scraps + kAttackGain * static_cast<double>(scraps.size()))) continue;
    add(bubble, 1.0);
    for (const std::size_t j : scraps) {
      add(result_.found[j], 1.0);
      keep[j] = false;
    }
    bubble = other;
    add(bubble, -1.0);
  }
  std::vector<FoundBubble> kept;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (keep[i]) kept.push_back(result_.found[i]);
  result_.found = std::move(kept);
}

/// Once more with all others known.
void Search::choose_rests() {
  for (FoundBubble& bubble : result_.found) {
    monitor_.throw_if_stopped();
    const ChirpWindow own = window_of({&bubble});
    const double before = fit_chirps(own, {bubble.law}, {bubble.chirp}, {}, 0, false).chi_square;
    FoundBubble resting = bubble;
    if (!(choose_rest(own, resting, before) < before)) continue;
    add(bubble, 1.0);
    bubble = resting;
    add(bubble, -1.0);
  }
}

std::vector<std::vector<std::size_t>> Search::groups() const {
  std::vector<std::size_t> order(result_.found.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return result_.found[a].chirp.onset_s < result_.found[b].chirp.onset_s; });
  std::vector<std::vector<std::size_t>> list;
  for (const std::size_t i : order) {
    std::vector<std::size_t>* home = nullptr;
    for (auto& group : list) {
      if (group.size() >= kMostTogether) continue;
      if (std::any_of(group.begin(), group.end(), [&](std::size_t j) { return overlap(result_.found[i], result_.found[j]); })) home = &group;
    }
    if (home) {
      home->push_back(i);
    } else {
      list.push_back({i});
    }
  }
  return list;
}

double Search::energy_of(const FoundBubble& bubble) const {
  FoundBubble silent = bubble;
  silent.chirp.cosine = silent.chirp.sine = 0.0;
  const ChirpWindow window = window_of({&silent});
  Eigen::VectorXd value(window.taper.size());
  evaluate_chirp(bubble.law, bubble.chirp, window.first_s, rate_, value);
  return window.weighted(value).squaredNorm();
}

void Search::mask(const FoundBubble& bubble) {
  const double score = energy_of(bubble) / kChi2OfScore, beta = std::exp(bubble.chirp.log_decay), onset = bubble.chirp.onset_s;
  const auto sample = [&](double time_s) { return static_cast<Eigen::Index>(std::max(0.0, time_s) * rate_); };
  filters_->mask(sample(onset - kOnsetS), sample(onset + std::max(kOnsetS, 0.2 / beta)), 0.0, 1e9, kOnsetFragmentEnergy * score);
  const double side = std::exp2(kFragmentOctaves), step = 0.5 / beta;
  for (double since = -0.01; since < kHeardSpan / beta; since += step) {
    const double at = std::max(since, 0.0), ratio = std::exp(bubble.law.pitch_at(at, bubble.chirp.pitch).log_ratio);
    const double f = ratio * std::exp(bubble.chirp.log_frequency), left = std::exp(-2.0 * std::max(0.0, beta * at - 1.0));
    filters_->mask(sample(onset + since), sample(onset + since + step), f / side, f * side, kFragmentEnergy * score * left);
    filters_->mask(sample(onset + since), sample(onset + since + step), 0.0, 1e9, kFarFragmentEnergy * score * left);
  }
}

void Search::prune() {
  std::vector<double> energy;
  for (FoundBubble& bubble : result_.found) {
    energy.push_back(energy_of(bubble));
    bubble.snr_db = 10.0 * std::log10(std::max(energy.back(), 1e-30));
  }
  std::vector<bool> keep(energy.size(), true);
  for (std::size_t i = 0; i < energy.size(); ++i) {
    const FoundBubble& weak = result_.found[i];
    if (!(weak.snr_db >= options_.min_snr_db)) keep[i] = false;
    for (std::size_t j = 0; j < energy.size() && keep[i]; ++j) {
      const FoundBubble& strong = result_.found[j];
      if (!(energy[i] < kFragmentEnergy * energy[j])) continue;
      const double since = weak.chirp.onset_s - strong.chirp.onset_s, beta = std::exp(strong.chirp.log_decay);
      if (since < -0.01 || since > kHeardSpan / beta) continue;
      const double there = strong.chirp.log_frequency + strong.law.pitch_at(std::max(since, 0.0), strong.chirp.pitch).log_ratio;
      if (std::abs(weak.chirp.log_frequency - there) < kFragmentOctaves * std::log(2.0)) keep[i] = false;
    }
  }
  std::vector<FoundBubble> kept;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) {
      kept.push_back(result_.found[i]);
    } else {
      add(result_.found[i], 1.0);
    }
  }
  result_.found = std::move(kept);
}

void Search::judge(FoundBubble& bubble) const {
  const double f = std::exp(bubble.chirp.log_frequency), beta = std::exp(bubble.chirp.log_decay);
  bubble.radius_m = radius_of_frequency_m(f, options_.medium, options_.theory);
  const double wider = radius_of_frequency_m(1.001 * f, options_.medium, options_.theory);
  const double slope = std::log(wider / bubble.radius_m) / std::log(1.001);
  bubble.theory_decay_per_s = decay_of(options_.medium, options_.theory, bubble.radius_m, 2.0 * kPi * f);
  if (!bubble.covariance) {
    bubble.verdict = BubbleVerdict::kUnclear;
    bubble.end_s = bubble.chirp.onset_s;
    return;
  }
  const Eigen::MatrixXd& covariance = *bubble.covariance;
  // The pitch is that of the onset: where it rises, its time matters.
  const double by_onset = bubble.chirp.pitch[0] * (bubble.law.soft_attack() ? kOnsetDecays / beta : kOnsetCycles / f);
  bubble.radius_std_m = bubble.radius_m * std::abs(slope) * std::sqrt(covariance(3, 3) + by_onset * by_onset);
  const double log_ratio = std::log(beta / bubble.theory_decay_per_s), spread = 2.0 * std::sqrt(covariance(4, 4));
  // Heard until it is 26 dB down (the pitch of what follows is the model's, not the sound's) or as weak as the noise that its own bandwidth lets through.
  const double bandwidth = 4.0 * beta / rate_, floor = std::sqrt(2.0 * result_.noise.at(f) * bandwidth);
  std::vector<double> times;
  for (int i = 0; i <= 200; ++i) times.push_back(kHeardSpan / beta * i / 200.0);
  const auto track = chirp_track(bubble.law, bubble.chirp, times);
  double end = 0.0;
  for (const ChirpPoint& point : track)
    if (point.envelope >= std::max(kHeardLevel * track.front().envelope, floor)) end = point.time_s;
  bubble.end_s = std::min(bubble.chirp.onset_s + end, static_cast<double>(residual_.size()) / rate_);
  const double rise = bubble.law.pitch_at(end, bubble.chirp.pitch).log_ratio, rate_std = std::sqrt(covariance(0, 0));
  const double pitch_std = std::sqrt(covariance(3, 3));
  const bool rises = rise > kLeastRise && bubble.chirp.pitch[0] > 3.0 * rate_std;
  if (!(rate_std <= kUnclearRatePerS && 0.5 * spread <= kUnclearDecay && pitch_std <= kUnclearPitch)) {
    bubble.verdict = BubbleVerdict::kUnclear;
  } else if (log_ratio + spread < std::log(kLeastDecayRatio)) {
    bubble.verdict = rises ? BubbleVerdict::kDriven : BubbleVerdict::kRingsTooLong;
  } else if (log_ratio - spread > std::log(kMostDecayRatio)) {
    bubble.verdict = BubbleVerdict::kDampedTooStrongly;
  }
}

std::vector<RingGroup> Search::windows(const BubbleSearchResult& result) {
  result_ = result;
  residual_ = result.mono.samples.col(0) - render(result.found, result.mono.n_frames(), rate_);
  std::vector<RingGroup> list;
  for (auto& members : groups()) {
    std::vector<const FoundBubble*> bubbles;
    for (const std::size_t i : members) bubbles.push_back(&result_.found[i]);
    list.push_back({members, std::make_shared<const ChirpWindow>(window_of(bubbles))});
  }
  return list;
}

BubbleSearchResult Search::run() {
  const Eigen::VectorXd samples = result_.mono.samples.col(0);
  residual_ = samples;
  result_.noise = noise_spectrum(samples, rate_);
  whitened_ = Eigen::VectorXf::Zero(samples.size());
  whiten(samples, 0, samples.size());
  const double energy = whitened_.cast<double>().squaredNorm();
  make_filters();
  filters_->update(whitened_, 0, samples.size());
  const double threshold = std::pow(10.0, 0.1 * options_.min_snr_db) / kChi2OfScore;
  const Eigen::Index n = samples.size();
  for (int round = 0; round < 2; ++round) {
    int n_failures = 0;
    while (static_cast<int>(result_.found.size()) < options_.max_bubbles) {
      monitor_.throw_if_stopped();
      const DampedFilterBank::Peak best = filters_->highest(0, n);
      if (!(best.score >= threshold)) break;
      const DampedFilterBank::Atom& atom = filters_->atom(best.atom);
      const auto bubble = fitted_near(best, atom);
      // Tried once: what is left there afterwards is nothing new.
      filters_->mask(best.sample, best.sample + 1, 0.94 * atom.frequency_hz, 1.06 * atom.frequency_hz, (bubble ? 0.5 : 1.1) * best.score);
      n_failures = bubble ? 0 : n_failures + 1;
      if (n_failures > kMostFailures) break;
      if (!bubble) continue;
      result_.found.push_back(*bubble);
      add(*bubble, -1.0);
      mask(*bubble);
      monitor_.progress("bubbles", 0.0);
      const std::size_t newest = result_.found.size() - 1;
      std::vector<std::size_t> group = {newest};
      for (std::size_t i = newest; i-- > 0 && group.size() < kMostTogether;)
        if (overlap(result_.found[i], result_.found[newest])) group.push_back(i);
      if (group.size() > 1) refit(group, false);
    }
    prune();
    choose_attacks();
    choose_rests();
    for (const auto& group : groups()) {
      monitor_.throw_if_stopped();
      refit(group, round > 0);
    }
  }
  prune();
  std::sort(result_.found.begin(), result_.found.end(), [](const FoundBubble& a, const FoundBubble& b) { return a.chirp.onset_s < b.chirp.onset_s; });
  for (FoundBubble& bubble : result_.found) {
    judge(bubble);
  }
  result_.explained_energy = energy > 0.0 ? std::optional(1.0 - whitened_.cast<double>().squaredNorm() / energy) : std::nullopt;
  result_.status = result_.found.empty() ? BubbleSearchStatus::kNothingFound : BubbleSearchStatus::kDone;
  if (result_.found.empty()) result_.message = "no decaying chirp stands above the noise";
  return std::move(result_);
}

}  // namespace

std::vector<RingGroup> ring_groups(const BubbleSearchResult& result, const BubbleSearchOptions& options) {
  return Search(result.mono, options, silent_monitor()).windows(result);
}

BubbleSearchResult find_bubbles(const audio::Signal& recording, const BubbleSearchOptions& options, Monitor& monitor) {
  options.validate();
  if (recording.n_frames() < 256) throw InputError(recording.origin, "has too few samples", std::to_string(recording.n_frames()), "256 or more");
  if (!recording.samples.allFinite()) throw InputError(recording.origin, "has a sample that is not finite");
  if (!(recording.samples.cwiseAbs().maxCoeff() > 0.0)) throw InputError(recording.origin, "is silent");
  return Search(recording, options, monitor).run();
}

}  // namespace klang::fit::bubble
