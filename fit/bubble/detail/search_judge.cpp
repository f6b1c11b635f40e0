#include <algorithm>
#include <cmath>

#include "fit/bubble/detail/search.hpp"

namespace klang::fit::bubble::detail {
namespace {

// Of the rise in ln pitch while a bubble is heard: what the law of an even rise makes of one that starts from rest, at the onset
// (one deviation; of 24 rises from rest to terminal speed at 30 dB the worst was 1.9 %).
constexpr double kUnevenRise = 0.013;
constexpr double kHeardLevel = 0.05;  // of the amplitude at the onset: the end of what tells the pitch
// A weak ring on top of a strong one is what the strong one's model leaves, not a bubble.
constexpr double kFragmentEnergy = 0.03, kFragmentOctaves = 0.5;
// Standard deviations beyond which a ring is too short or too noisy to be called anything: as wide as the prior.
constexpr double kUnclearRatePerS = 40.0, kUnclearDecay = 0.4, kUnclearPitch = 0.03;
constexpr double kOnsetCycles = 0.1;  // how well a quick attack's form tells the onset
constexpr double kOnsetDecays = 0.1;  // and a soft one's, in decay times: it may have been quick and faint
constexpr double kLeastDecayRatio = 0.6, kMostDecayRatio = 10.0, kLeastRise = 0.05;

}  // namespace

double Search::energy_of(const FoundBubble& bubble) const {
  FoundBubble silent = bubble;
  silent.chirp.cosine = silent.chirp.sine = 0.0;
  const ChirpWindow window = window_of({&silent});
  Eigen::VectorXd value(window.taper.size());
  evaluate_chirp(bubble.law, bubble.chirp, window.first_s, rate_, value);
  return window.weighted(value).squaredNorm();
}

void Search::mask(const FoundBubble& bubble) {
  const double score = energy_of(bubble) / kChi2OfScore, beta = std::exp(bubble.chirp.log_decay),
               onset = bubble.chirp.onset_s;
  const auto sample = [&](double time_s) { return static_cast<Eigen::Index>(std::max(0.0, time_s) * rate_); };
  filters_->mask(sample(onset - kOnsetS), sample(onset + std::max(kOnsetS, 0.2 / beta)), 0.0, 1e9,
                 kOnsetFragmentEnergy * score);
  const double side = std::exp2(kFragmentOctaves), step = 0.5 / beta;
  for (double since = -0.01; since < kHeardSpan / beta; since += step) {
    const double at = std::max(since, 0.0), ratio = std::exp(bubble.law.pitch_at(at, bubble.chirp.pitch).log_ratio);
    const double f = ratio * std::exp(bubble.chirp.log_frequency),
                 left = std::exp(-2.0 * std::max(0.0, beta * at - 1.0));
    filters_->mask(sample(onset + since), sample(onset + since + step), f / side, f * side,
                   kFragmentEnergy * score * left);
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
      const double there =
          strong.chirp.log_frequency + strong.law.pitch_at(std::max(since, 0.0), strong.chirp.pitch).log_ratio;
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
  bubble.radius_std_m = std::hypot(*bubble.radius_std_m, bubble.radius_m * std::abs(slope) * kUnevenRise * rise);
  const bool rises = rise > kLeastRise && bubble.chirp.pitch[0] > 3.0 * rate_std;
  if (!(rate_std <= kUnclearRatePerS && 0.5 * spread <= kUnclearDecay && pitch_std <= kUnclearPitch)) {
    bubble.verdict = BubbleVerdict::kUnclear;
  } else if (log_ratio + spread < std::log(kLeastDecayRatio)) {
    bubble.verdict = rises ? BubbleVerdict::kDriven : BubbleVerdict::kRingsTooLong;
  } else if (log_ratio - spread > std::log(kMostDecayRatio)) {
    bubble.verdict = BubbleVerdict::kDampedTooStrongly;
  }
}

}  // namespace klang::fit::bubble::detail
