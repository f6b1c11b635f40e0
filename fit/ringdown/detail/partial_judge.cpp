#include "fit/ringdown/detail/partial_judge.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "fit/ringdown/detail/partial_parts.hpp"

namespace klang::fit::detail {
namespace {

using Complex = std::complex<double>;

constexpr double kPi2 = 2 * kPi;
constexpr double kRestless = 10.0;          ///< residual over noise from which it is misfit or a codec's noise
constexpr double kSureAmidMisfitDb = 20.0;  ///< as kSureSnrDb there: such a residual is no white noise and makes bursts
constexpr double kSureCarryingDb = 12.0;    ///< there, of what explains most of its neighbourhood
constexpr double kBlowS = 1e-3;        ///< there, what falls to 1/e within this is the blow itself, as a codec left it
constexpr double kSureBurstDb = 30.0;  ///< in a coded recording, of what falls to 1/e within one of the coder's blocks
constexpr double kImagePart = 0.05;    ///< of a line's amplitude: a coder's images of it are weaker
constexpr double kNotWhite = 4.0;      ///< residual over noise from which close lines may be one that is no exponential
constexpr int kMaxPasses = 16;         ///< of pruning
constexpr int kMaxRounds = 3;          ///< of searching again in the residual

/// Amplitude at frequency_hz in the part before the first strike (Hann window), or empty when that part is
/// too short.
std::optional<double> amplitude_before(const RingData& data, Eigen::Index channel, double frequency_hz) {
  const double rate = data.sample_rate_hz();
  const auto end = static_cast<Eigen::Index>((data.segments().front().strike_s - 0.005) * rate);
  const auto n = std::min<Eigen::Index>(end, static_cast<Eigen::Index>(2 * rate));
  if (n < 64 || static_cast<double>(n) / rate < std::max(0.05, 6 / frequency_hz)) return std::nullopt;
  const Eigen::VectorXd& x = data.channels()[static_cast<std::size_t>(channel)];
  Complex sum = 0;
  double weight = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double w = 0.5 - 0.5 * std::cos(kPi2 * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
    sum += w * x[end - n + i] * std::polar(1.0, -kPi2 * frequency_hz / rate * static_cast<double>(i));
    weight += w;
  }
  return 2 * std::abs(sum) / weight;
}

/// Whether a line that is one decays. `before`: its amplitude before the strike, `loud`: after it.
Verdict decay_verdict(const RingData& data, const FittedPartial& partial, std::optional<double> before, double loud) {
  const Pole& pole = partial.ring.pole;
  const double decay_std = std::sqrt(partial.pole_covariance(1, 1));
  const double lost = pole.decay_per_s * partial.window_s;  // nepers within the window
  const double most_lost = lost + kSureDecay * decay_std * partial.window_s;
  const bool falls = pole.decay_per_s > kSureDecay * decay_std;
  const bool rang_before = before && *before > 0.3 * loud;
  // What rang before the blow rings from an earlier one when it falls after this one; a tone that only wavers does not.
  if (rang_before) return falls && lost > 0.5 ? Verdict::kDecaying : Verdict::kSteady;
  const double mains =
      std::min(std::abs(std::remainder(pole.frequency_hz, 50.0)), std::abs(std::remainder(pole.frequency_hz, 60.0)));
  if (!before && mains < 0.3 && lost < 0.3 && pole.frequency_hz < 1000) return Verdict::kSteady;
  // Without a quiet part before the strike only a long look tells a steady tone from a slow decay.
  constexpr double kLongLookS = 1.5;
  if (!before && partial.window_s >= kLongLookS && lost + 2 * decay_std * partial.window_s < 0.05)
    return Verdict::kSteady;
  if (falls) return Verdict::kDecaying;
  if (pole.decay_per_s < -kSureDecay * decay_std && lost < -0.3) return Verdict::kSteady;  // it grows
  if (!before && most_lost < 0.5) return Verdict::kSteady;
  // Where the recording goes on and the line does not there was a burst.
  return partial.window_s > 0.6 * data.longest_segment_s() ? Verdict::kTooShort : Verdict::kNoise;
}

Verdict judged(const RingData& data, const FittedPartial& partial, const SearchOptions& options) {
  const Pole& pole = partial.ring.pole;
  if (partial.unresolved || partial.amplitude_covariance.empty()) return Verdict::kNoise;
  // What carries its neighbourhood is not made by the misfit of another; there a pitch that glides is the misfit.
  const double sure_db =
      partial.disturbance > kRestless ? (partial.carries ? kSureCarryingDb : kSureAmidMisfitDb) : kSureSnrDb;
  if (!(partial.snr_db >= std::max(options.min_snr_db, sure_db))) return Verdict::kNoise;
  if (partial.disturbance > kRestless && pole.decay_per_s * kBlowS > 1.0) return Verdict::kNoise;
  // A coder's noise comes in blocks, as loud as the masking allows: what falls within one is taken for a ring only when sure.
  if (pole.decay_per_s * data.coded_s() > 1.0 && partial.snr_db < kSureBurstDb) return Verdict::kNoise;
  const double frequency_std = std::sqrt(partial.pole_covariance(0, 0));
  const double decay_std = std::sqrt(partial.pole_covariance(1, 1));
  const double width = std::max(pole.decay_per_s / kPi2, 0.5 / partial.window_s);
  if (!(frequency_std <= 0.3 * width) || !(frequency_std > 0) || !(decay_std > 0)) return Verdict::kNoise;
  if (!(pole.frequency_hz >= data.band().low_hz) || !(pole.frequency_hz <= data.band().high_hz)) return Verdict::kNoise;
  if (!(pole.decay_per_s < 0.7 * kPi2 * pole.frequency_hz)) return Verdict::kNoise;  // over before it oscillates
  Eigen::Index segment = 0, channel = 0;
  partial.ring.amplitude.cwiseAbs().maxCoeff(&segment, &channel);
  const double loud = std::abs(partial.ring.amplitude(segment, channel));
  // Two exponentials that nearly cancel have amplitudes that nobody knows.
  const auto slot = static_cast<std::size_t>(segment * partial.ring.amplitude.cols() + channel);
  if (!(loud * loud >= 4 * partial.amplitude_covariance[slot].trace())) return Verdict::kNoise;
  const StruckAmplitude struck = at_strike(data, partial, segment, channel);
  if (!(struck.amplitude_std <= 0.6 * struck.amplitude)) return Verdict::kNoise;
  if (!(struck.amplitude <= 10 * data.peak(segment, channel))) return Verdict::kNoise;
  return decay_verdict(data, partial, amplitude_before(data, channel, pole.frequency_hz), loud);
}

/// Partials that only mend the shape of a stronger neighbour (a decay that is not quite exponential, a band
/// not quite fitted): within a fraction of the wider line's width and weaker.
std::vector<bool> shadows(const std::vector<FittedPartial>& partials) {
  std::vector<bool> shadow(partials.size(), false);
  for (std::size_t i = 0; i < partials.size(); ++i) {
    for (std::size_t j = 0; j < partials.size(); ++j) {
      if (i == j || shadow[j]) continue;
      const auto& a = partials[i].ring;
      const auto& b = partials[j].ring;
      const double apart = std::abs(a.pole.frequency_hz - b.pole.frequency_hz);
      const double weak = a.amplitude.norm(), strong = b.amplitude.norm();
      if (!(a.energy() < b.energy())) continue;                           // a burst is no line, however loud it begins
      if (a.pole.decay_per_s < kOutlasts * b.pole.decay_per_s) continue;  // still there when b is gone
      const double width = std::max(a.pole.decay_per_s, b.pole.decay_per_s) / kPi2;
      const double cell = 1 / std::max(partials[i].window_s, partials[j].window_s);
      const bool inside_line = apart < 0.1 * width;
      const bool under_skirt = apart < 0.7 * width + 2 * cell && weak < 0.01 * strong;
      const bool mends = partials[j].disturbance > 10 && apart < 2 * width + 4 * cell && weak < 0.2 * strong;
      if (inside_line || under_skirt || mends) shadow[i] = true;
    }
  }
  return shadow;
}

/// Of those found wanting the ones to drop now: in each neighbourhood (6 cells) the weaker half. What is left is fitted
/// again before it is judged again: of two exponentials on one line both look bad, and one of them is the line.
std::vector<std::size_t> weaker_halves(const std::vector<FittedPartial>& partials, std::vector<std::size_t> wanting) {
  std::stable_sort(wanting.begin(), wanting.end(), [&](std::size_t a, std::size_t b) {
    return partials[a].ring.pole.frequency_hz < partials[b].ring.pole.frequency_hz;
  });
  std::vector<std::size_t> chosen;
  for (std::size_t begin = 0, end = 0; begin < wanting.size(); begin = end) {
    for (end = begin + 1; end < wanting.size(); ++end) {
      const FittedPartial& a = partials[wanting[end - 1]];
      const FittedPartial& b = partials[wanting[end]];
      const double cell = 1 / std::min(a.window_s, b.window_s);
      if (b.ring.pole.frequency_hz - a.ring.pole.frequency_hz > 6 * cell) break;
    }
    std::vector<std::size_t> near(wanting.begin() + static_cast<std::ptrdiff_t>(begin),
                                  wanting.begin() + static_cast<std::ptrdiff_t>(end));
    std::stable_sort(near.begin(), near.end(), [&](std::size_t a, std::size_t b) {
      return partials[a].ring.energy() < partials[b].ring.energy();
    });
    near.resize(std::max<std::size_t>(1, near.size() / 2));
    chosen.insert(chosen.end(), near.begin(), near.end());
  }
  return chosen;
}

/// A coder codes each line anew in every block of n frames, and its error repeats with the phase that the line has gained: lines
/// at +-f + k rate / n that fall as the line does.
bool is_image(const FittedPartial& partial, const FittedPartial& of, double coded_s) {
  const Pole& a = partial.ring.pole;
  const Pole& b = of.ring.pole;
  if (!(partial.ring.amplitude.norm() < kImagePart * of.ring.amplitude.norm())) return false;
  const double std_hz = std::hypot(std::sqrt(partial.pole_covariance(0, 0)), std::sqrt(of.pole_covariance(0, 0)));
  const double std_per_s = std::hypot(std::sqrt(partial.pole_covariance(1, 1)), std::sqrt(of.pole_covariance(1, 1)));
  if (!(std::abs(a.decay_per_s - b.decay_per_s) < 3 * std_per_s + 0.3 * b.decay_per_s)) return false;
  const double spacing = 1 / coded_s;
  const double away = std::min(std::abs(std::remainder(a.frequency_hz - b.frequency_hz, spacing)),
                               std::abs(std::remainder(a.frequency_hz + b.frequency_hz, spacing)));
  return away < 3 * std_hz + 0.02;
}

/// Takes a coder's images of louder lines away and counts them.
int drop_images(const RingData& data, std::vector<FittedPartial>& partials) {
  if (!(data.coded_s() > 0)) return 0;
  const std::vector<FittedPartial> all = partials;
  const auto n = std::erase_if(partials, [&](const FittedPartial& partial) {
    return std::any_of(all.begin(), all.end(),
                       [&](const FittedPartial& other) { return is_image(partial, other, data.coded_s()); });
  });
  return static_cast<int>(n);
}

/// Lines closer than they can be told apart: where what they leave is no noise, they may be one that is no exponential (a beat, a
/// pitch that moves), and each may lie anywhere between them.
void widen_close(std::vector<FittedPartial>& partials) {
  for (FittedPartial& partial : partials) {
    if (partial.disturbance <= kNotWhite) continue;
    const Pole& a = partial.ring.pole;
    double farthest = 0;
    for (const FittedPartial& other : partials) {
      const Pole& b = other.ring.pole;
      const double apart = std::abs(a.frequency_hz - b.frequency_hz);
      const double resolved = std::max(a.decay_per_s, 0.0) / kPi2 + std::max(b.decay_per_s, 0.0) / kPi2 +
                              1 / std::max(partial.window_s, other.window_s);
      const bool alike = other.ring.energy() > 0.1 * partial.ring.energy();
      const bool faded = a.decay_per_s < kOutlasts * b.decay_per_s;  // the other is gone while this one still rings
      if (&other != &partial && alike && !faded && apart < resolved) farthest = std::max(farthest, apart);
    }
    partial.drift_hz = std::max(partial.drift_hz, 0.5 * farthest);
  }
}

/// Drops what is no partial and fits what lay near it again, until nothing changes.
void prune(const RingData& data, const SearchOptions& options, const TailNoise& noise,
           std::vector<FittedPartial>& partials) {
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const std::vector<bool> shadow = shadows(partials);
    check_persistence(data, partials);
    std::vector<std::size_t> wanting;
    for (std::size_t i = 0; i < partials.size(); ++i) {
      if (shadow[i] || !*partials[i].lasts || judged(data, partials[i], options) == Verdict::kNoise)
        wanting.push_back(i);
    }
    std::vector<double> changed_hz;
    for (const FittedPartial& partial : partials) {  // what turned out to decay slower is fitted in its own window
      if (partial.window_s < 0.6 * window_of(partial.ring.pole, data) && pass + 1 < kMaxPasses)
        changed_hz.push_back(partial.ring.pole.frequency_hz);
    }
    if (wanting.empty() && changed_hz.empty()) return;
    std::vector<char> dropped(partials.size(), 0);
    for (const std::size_t i : weaker_halves(partials, wanting)) {
      dropped[i] = 1;
      changed_hz.push_back(partials[i].ring.pole.frequency_hz);
    }
    std::vector<FittedPartial> kept;
    for (std::size_t i = 0; i < partials.size(); ++i) {
      if (!dropped[i]) kept.push_back(std::move(partials[i]));
    }
    partials = std::move(kept);
    polish_near(data, partials, {&noise, false}, changed_hz);
  }
}

}  // namespace

StruckAmplitude at_strike(const RingData& data, const FittedPartial& partial, Eigen::Index segment,
                          Eigen::Index channel) {
  const double t = data.segments()[static_cast<std::size_t>(segment)].delay_s;
  const Complex a = partial.ring.amplitude(segment, channel);
  const auto slot = static_cast<std::size_t>(segment * partial.ring.amplitude.cols() + channel);
  const Eigen::Matrix2d& amplitude_covariance = partial.amplitude_covariance[slot];
  const Eigen::Matrix2d& cross = partial.cross_covariance[slot];
  const double size = std::abs(a);
  StruckAmplitude out;
  out.amplitude = size * std::exp(partial.ring.pole.decay_per_s * t);
  out.phase_rad = std::remainder(std::arg(a) - kPi2 * partial.ring.pole.frequency_hz * t, kPi2);
  // log amplitude = log|a| + decay t, phase = arg a - 2 pi f t, linear in (ar, ai, f, decay).
  const Eigen::Vector2d log_slope(a.real() / (size * size), a.imag() / (size * size));
  const Eigen::Vector2d arg_slope(-a.imag() / (size * size), a.real() / (size * size));
  const Eigen::Matrix2d& pole = partial.pole_covariance;
  const double log_variance =
      log_slope.dot(amplitude_covariance * log_slope) + 2 * t * log_slope.dot(cross.col(1)) + t * t * pole(1, 1);
  const double phase_variance = arg_slope.dot(amplitude_covariance * arg_slope) -
                                2 * kPi2 * t * arg_slope.dot(cross.col(0)) + std::pow(kPi2 * t, 2) * pole(0, 0);
  out.amplitude_std = out.amplitude * std::sqrt(std::max(log_variance, 1e-32));
  out.phase_std_rad = std::sqrt(std::max(phase_variance, 1e-32));
  return out;
}

JudgedPartials find_partials(const RingData& data, const SearchOptions& options, Monitor& monitor) {
  const TailNoise noise(data);
  std::vector<FittedPartial> all;
  std::vector<double> tried_hz;
  for (int round = 0; round < kMaxRounds; ++round) {
    for (FittedPartial& partial : all) partial.fresh = false;
    search_partials(data, options, noise, tried_hz, all, monitor);
    std::vector<double> fresh_hz;
    for (const FittedPartial& partial : all) {
      if (partial.fresh) fresh_hz.push_back(partial.ring.pole.frequency_hz);
    }
    if (fresh_hz.empty()) break;
    polish_near(data, all, {&noise, false}, fresh_hz);
    prune(data, options, noise, all);
    if (std::none_of(all.begin(), all.end(), [](const FittedPartial& partial) { return partial.fresh; })) break;
    tried_hz.insert(tried_hz.end(), fresh_hz.begin(), fresh_hz.end());
  }
  polish(data, all, noise);
  prune(data, options, noise, all);
  widen_close(all);
  JudgedPartials result;
  result.repeats = noise.repeats();
  result.n_images = drop_images(data, all);
  for (FittedPartial& partial : all) {
    switch (judged(data, partial, options)) {
      case Verdict::kDecaying:
        result.partials.push_back(std::move(partial));
        break;
      case Verdict::kTooShort:
        result.too_short.push_back(std::move(partial));
        break;
      case Verdict::kSteady:
        result.steady.push_back(std::move(partial));
        break;
      case Verdict::kNoise:
        break;
    }
  }
  return result;
}

}  // namespace klang::fit::detail
