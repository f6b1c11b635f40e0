#include <algorithm>
#include <cmath>

#include "fit/bubble/detail/search.hpp"

namespace klang::fit::bubble::detail {
namespace {

constexpr double kScrapEnergy = 0.1;  // of a ring's, beginning with it: may be what its attack leaves
constexpr double kAttackGain = 10.0;  // chi square that another kind of attack must win
constexpr double kRestGain = 25.0;    // chi square that a rest must win, with its time one more free number
constexpr double kRestShare = 0.2;    // and of what is left above the noise
constexpr std::size_t kRestStarts = 5;
constexpr double kMostBegins = 80.0;  // tried of a quick attack; a bubble needs some thirty, what rings longer is none
constexpr double kLatestRest = 3.0;   // decay times: later nothing is heard of it

}  // namespace

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
  const double step = std::max(0.25 / f, (last - first) / kMostBegins);
  for (double shift = first; shift < last; shift += step) consider(shift);
  const double coarse = start.onset_s - bubble.chirp.onset_s;
  for (int fine = -8; fine <= 8; ++fine) consider(coarse + 0.03 * fine / f);
  const ChirpFit other = fit_chirps(own, {law}, {start}, {}, 40, false);
  if (!(other.ok && plausible(other.chirps[0]) &&
        other.chi_square < chi_square - std::max(share > 0.0 ? kAttackGain : 0.0, share * (chi_square - n_data))))
    return chi_square;
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
    if (!(fit.ok && plausible(fit.chirps[0]) && fit.chi_square < least)) return;
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
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.chi_square < b.chi_square; });
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

/// Once more with all others known: alone, a ring takes the attack that suits its neighbours' sound, and with it the scraps
/// that stood for the wrong one.
void Search::choose_attacks() {
  std::vector<double> energy;
  for (const FoundBubble& bubble : result_.found) energy.push_back(energy_of(bubble));
  std::vector<bool> keep(result_.found.size(), true);
  for (std::size_t i = 0; i < result_.found.size(); ++i) {
    monitor_.throw_if_stopped();
    if (work_->used_up()) break;
    if (!keep[i]) continue;
    FoundBubble& bubble = result_.found[i];
    const double near_s = std::max(kOnsetS, 0.3 / std::exp(bubble.chirp.log_decay));
    std::vector<std::size_t> scraps;
    for (std::size_t j = 0; j < result_.found.size(); ++j)
      if (j != i && keep[j] && energy[j] < kScrapEnergy * energy[i] &&
          std::abs(result_.found[j].chirp.onset_s - bubble.chirp.onset_s) < near_s)
        scraps.push_back(j);
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
    if (work_->used_up()) break;
    const ChirpWindow own = window_of({&bubble});
    const double before = fit_chirps(own, {bubble.law}, {bubble.chirp}, {}, 0, false).chi_square;
    FoundBubble resting = bubble;
    if (!(choose_rest(own, resting, before) < before)) continue;
    add(bubble, 1.0);
    bubble = resting;
    add(bubble, -1.0);
  }
}

}  // namespace klang::fit::bubble::detail
