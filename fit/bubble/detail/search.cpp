#include "fit/bubble/detail/search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/bubble/bubble_formulas.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::fit::bubble::detail {
namespace {

constexpr Eigen::Index kWhiteningReach = 1024;
constexpr double kHopelessDecay = 40.0;   // of theory's, up or down: no ring
constexpr double kAttackShare = 0.5;      // while neighbours are not yet found, their sound must not pass for an attack
constexpr double kLeastShare = 0.35;      // of what stands above the noise around it: less is a patch of a splash
constexpr double kLeastStartShare = 0.1;  // the same before any fitting
constexpr double kLeastTryShare = 0.2;    // and after a few steps
constexpr std::array<std::pair<double, double>, 8> kStartPitches = {{{0.0, 0.0},
                                                                     {10.0, 20.0},
                                                                     {16.0, 35.0},
                                                                     {25.0, 20.0},
                                                                     {25.0, 40.0},
                                                                     {50.0, 20.0},
                                                                     {50.0, 60.0},
                                                                     {-15.0, 0.0}}};  // rate, growth [1/s]
constexpr double kLastShare =
    1.5;  // of the limit of work, within which what was found is still fitted for the last time
constexpr double kPieceS = 10.0, kLeastAbove = 0.05;
constexpr int kMostFailures = 20;  // candidates in a row that were none: the rest are weaker still

}  // namespace

double decay_of(const klang::bubble::BubbleMedium& medium, klang::bubble::BubbleTheory theory, double radius_m,
                double omega) {
  return klang::bubble::bubble_damping(medium, theory, radius_m, omega).decay_per_s;
}

/// Law of a ring of this pitch that begins, and comes to rest, as another does.
ChirpLaw Search::law_at(double frequency_hz, const ChirpLaw& like) const {
  static const auto pitch = std::make_shared<const ExponentialPitch>();
  ChirpLaw law = like;
  law.pitch = pitch;
  law.amplitude_exponent = options_.amplitude_exponent;
  const double radius_m = radius_of_frequency_m(frequency_hz, options_.medium, options_.theory),
               omega = 2.0 * kPi * frequency_hz;
  law.decay_exponent = std::log(decay_of(options_.medium, options_.theory, radius_m, 1.05 * omega) /
                                decay_of(options_.medium, options_.theory, radius_m, omega / 1.05)) /
                       (2.0 * std::log(1.05));
  return law;
}

Span Search::span_of(const Chirp& chirp) const {
  const double beta = std::exp(chirp.log_decay);
  const auto n = residual_.size();
  Span span;
  span.first = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::ceil(chirp.onset_s * rate_)), 0, n - 1);
  span.last = std::clamp<Eigen::Index>(
      static_cast<Eigen::Index>(std::ceil((chirp.onset_s + kHeardSpan / beta) * rate_)), span.first + 1, n);
  return span;
}

std::pair<double, double> Search::band_of(const FoundBubble& bubble) const {
  const double beta = std::exp(bubble.chirp.log_decay), f = std::exp(bubble.chirp.log_frequency);
  const double ratio = std::exp(bubble.law.pitch_at(2.5 / beta, bubble.chirp.pitch).log_ratio),
               side = 3.0 * beta / (2.0 * kPi);
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
  ChirpWindow window(samples, rate_, {first, residual_.size(), low, high}, result_.noise);
  window.work = work_;
  return window;
}

/// Gain at the band's edges, 0 outside: steep ones would ring before a strong onset.
double Search::band_edge(double f) const {
  const double x = std::clamp(std::min((f / options_.band.low_hz - 1.0) / 0.25, (1.0 - f / high_hz_) / 0.1), 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

/// Of stationary noise alone, whitened, over the whole recording.
double Search::noise_energy() const {
  constexpr int kSteps = 2000;
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k) sum += std::pow(band_edge(0.5 * rate_ * (k + 0.5) / kSteps), 2) / kSteps;
  return sum * static_cast<double>(residual_.size());
}

/// The filters over the whole recording, some seconds at a time: the caller may stop it.
void Search::look_everywhere() {
  const auto piece = static_cast<Eigen::Index>(kPieceS * rate_);
  for (Eigen::Index first = 0; first < residual_.size(); first += piece) {
    monitor_.throw_if_stopped();
    filters_->update(whitened_, first, std::min(residual_.size(), first + piece));
  }
}

void Search::whiten(const Eigen::VectorXd& change, Eigen::Index first, Eigen::Index n) {
  const Eigen::Index low = std::max<Eigen::Index>(0, first - kWhiteningReach),
                     high = std::min(whitened_.size(), first + n + kWhiteningReach);
  const Eigen::Index n_fft = audio::good_fft_size(high - low + kWhiteningReach);
  const Eigen::Index even = n_fft % 2 ? audio::good_fft_size(n_fft + 1) : n_fft;
  Eigen::VectorXd padded = Eigen::VectorXd::Zero(even);
  padded.segment(first - low, n) = change;
  Eigen::VectorXcd spectrum = audio::real_spectrum(padded, even);
  for (Eigen::Index k = 0; k < spectrum.size(); ++k) {
    const double f = rate_ * static_cast<double>(k) / static_cast<double>(even);
    const double edge = band_edge(f);
    spectrum[k] *= edge > 0.0 ? edge / std::sqrt(result_.noise.at(f)) : 0.0;
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
    const double beta = decay_of(options_.medium, options_.theory,
                                 radius_of_frequency_m(f, options_.medium, options_.theory), 2.0 * kPi * f);
    atoms.push_back({f, beta});
    f += beta / kPi;  // neighbours are off by no more than the decay: at most 1 dB is lost
  }
  filters_ = std::make_unique<DampedFilterBank>(std::move(atoms), rate_, residual_.size());
}

std::optional<FoundBubble> Search::fitted_near(const DampedFilterBank::Peak& peak,
                                               const DampedFilterBank::Atom& atom) const {
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
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.chi_square < b.chi_square; });
  const double silent_chi = wide.data.cwiseProduct(wide.weight.cast<std::complex<double>>()).squaredNorm();
  const double wanted = std::pow(10.0, 0.1 * options_.min_snr_db);
  // No start explains a third of what is asked for: a blot of noise that no chirp will fit.
  const double found = silent_chi - starts.front().chi_square;
  if (!(found >= 0.3 * wanted && found >= kLeastStartShare * (silent_chi - static_cast<double>(wide.n_real_data()))))
    return std::nullopt;
  starts.resize(std::min<std::size_t>(starts.size(), 3));
  // A few steps from each, then only the best goes on.
  std::vector<ChirpFit> tries(starts.size());
  parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      tries[i] = fit_chirps(wide, {bubble.law}, {starts[i].chirp}, {}, 8, false);
  });
  double best = 1e300;
  for (const ChirpFit& fit : tries) {
    if (!fit.ok || !(fit.chi_square < best)) continue;
    best = fit.chi_square;
    bubble.chirp = fit.chirps[0];
  }
  if (best >= 1e300) return std::nullopt;
  if (!(silent_chi - best >= kLeastTryShare * (silent_chi - static_cast<double>(wide.n_real_data()))))
    return std::nullopt;
  // Once more under the window that its own pitch and decay ask for.
  FoundBubble silent = bubble;
  silent.chirp.cosine = silent.chirp.sine = 0.0;
  const ChirpWindow own = window_of({&silent});
  const double before = own.data.cwiseProduct(own.weight.cast<std::complex<double>>()).squaredNorm();
  if (!plausible(bubble.chirp)) return std::nullopt;
  bubble.law = law_at(std::exp(bubble.chirp.log_frequency), bubble.law);
  const ChirpFit fit = fit_chirps(own, {bubble.law}, {bubble.chirp}, {}, 40, false);
  if (!fit.ok || !plausible(fit.chirps[0])) return std::nullopt;
  bubble.chirp = fit.chirps[0];
  const double gain = before - choose_attack(own, bubble, fit.chi_square, kAttackShare);
  const auto n_data = static_cast<double>(fit.n_real_data);
  if (!(gain >= wanted && gain >= kLeastShare * (before - n_data))) return std::nullopt;
  return bubble;
}

/// Within the band and the recording, and with a decay that leaves no doubt of a ring. What drifts out of it (a decay of next to
/// nothing, which the window that it asks for makes longer still) was none.
bool Search::plausible(const Chirp& chirp) const {
  const double f = std::exp(chirp.log_frequency), beta = std::exp(chirp.log_decay);
  if (!(f > options_.band.low_hz && f < high_hz_)) return false;
  if (!(chirp.onset_s > -1e-3 && chirp.onset_s < static_cast<double>(residual_.size()) / rate_)) return false;
  const double theory = decay_of(options_.medium, options_.theory,
                                 radius_of_frequency_m(f, options_.medium, options_.theory), 2.0 * kPi * f);
  return beta < kHopelessDecay * theory && beta > theory / kHopelessDecay;
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
    laws.push_back(
        law_at(std::clamp(std::exp(bubble.chirp.log_frequency), options_.band.low_hz, high_hz_), bubble.law));
    start.push_back(bubble.chirp);
  }
  const ChirpWindow window = window_of(members);
  const ChirpFit fit = fit_chirps(window, laws, start, {}, last ? 60 : 12, last);
  if (!fit.ok || !std::all_of(fit.chirps.begin(), fit.chirps.end(), [&](const Chirp& c) { return plausible(c); }))
    return;
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

std::vector<std::vector<std::size_t>> Search::groups() const {
  std::vector<std::size_t> order(result_.found.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return result_.found[a].chirp.onset_s < result_.found[b].chirp.onset_s;
  });
  std::vector<std::vector<std::size_t>> list;
  for (const std::size_t i : order) {
    std::vector<std::size_t>* home = nullptr;
    for (auto& group : list) {
      if (group.size() >= kMostTogether) continue;
      if (std::any_of(group.begin(), group.end(),
                      [&](std::size_t j) { return overlap(result_.found[i], result_.found[j]); }))
        home = &group;
    }
    if (home) {
      home->push_back(i);
    } else {
      list.push_back({i});
    }
  }
  return list;
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
  look_everywhere();
  const double threshold = std::pow(10.0, 0.1 * options_.min_snr_db) / kChi2OfScore;
  const Eigen::Index n = samples.size();
  for (int round = 0; round < 2; ++round) {
    int n_failures = 0;
    while (static_cast<int>(result_.found.size()) < options_.max_bubbles && !work_->used_up()) {
      monitor_.throw_if_stopped();
      const DampedFilterBank::Peak best = filters_->highest(0, n);
      if (!(best.score >= threshold)) break;
      const DampedFilterBank::Atom& atom = filters_->atom(best.atom);
      const auto bubble = fitted_near(best, atom);
      // Tried once: what is left there afterwards is nothing new.
      filters_->mask(best.sample, best.sample + 1, 0.94 * atom.frequency_hz, 1.06 * atom.frequency_hz,
                     (bubble ? 0.5 : 1.1) * best.score);
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
      // Then the rest has no standard deviations and is called unclear.
      if (!work_->used_up(kLastShare)) refit(group, round > 0);
    }
  }
  prune();
  std::sort(result_.found.begin(), result_.found.end(),
            [](const FoundBubble& a, const FoundBubble& b) { return a.chirp.onset_s < b.chirp.onset_s; });
  for (FoundBubble& bubble : result_.found) {
    judge(bubble);
  }
  result_.explained_energy =
      energy > 0.0 ? std::optional(1.0 - whitened_.cast<double>().squaredNorm() / energy) : std::nullopt;
  if (result_.explained_energy) {
    const double above = std::max(energy - noise_energy(), kLeastAbove * energy);
    result_.explained_above_noise = std::clamp(*result_.explained_energy * energy / above, 0.0, 1.0);
  }
  result_.stopped_early = work_->used_up();
  result_.status = result_.found.empty() ? BubbleSearchStatus::kNothingFound : BubbleSearchStatus::kDone;
  if (result_.found.empty()) result_.message = "no decaying chirp stands above the noise";
  return std::move(result_);
}

}  // namespace klang::fit::bubble::detail
