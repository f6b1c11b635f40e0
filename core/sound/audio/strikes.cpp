#include "core/sound/audio/strikes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/fft.hpp"
#include "core/sound/audio/resample.hpp"
#include "core/sound/audio/sudden_end.hpp"

namespace klang::audio {
namespace {

constexpr Eigen::Index kBands = 24;
constexpr Eigen::Index kTopBands = 6;  ///< a strike shows in at least this many
constexpr double kFrameS = 0.010;
constexpr double kHopS = 0.0025;
constexpr double kEnvelopeS = 0.0005;
constexpr Eigen::Index kLagMin = 4;   ///< frames: 10 ms, the windows do not overlap
constexpr Eigen::Index kLagMax = 16;  ///< frames: 40 ms
constexpr double kMaxRiseDb = 20.0;   ///< of one band, so that no single band carries the score

struct Frames {
  Eigen::MatrixXd band_power;  ///< kBands x n_frames, sum over channels
  Eigen::Index window = 0, hop = 0;
};

Frames band_frames(const Signal& signal, const Band& band) {
  const double rate = signal.sample_rate_hz;
  Frames frames;
  frames.window = std::max<Eigen::Index>(8, std::llround(kFrameS * rate));
  frames.hop = std::max<Eigen::Index>(1, std::llround(kHopS * rate));
  const Eigen::Index n = signal.n_frames();
  const Eigen::Index n_frames = n > frames.window ? (n - frames.window) / frames.hop + 1 : 1;
  const Eigen::Index n_fft = good_fft_size(frames.window);
  Eigen::VectorXd window(frames.window);
  for (Eigen::Index i = 0; i < frames.window; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(frames.window));
  }
  window /= std::sqrt(window.squaredNorm() * static_cast<double>(n_fft) / 2);
  // Band of each bin; below 100 Hz a 10 ms frame resolves nothing.
  const double low = std::max(band.low_hz, std::min(100.0, 0.1 * rate));
  const double high = std::max(std::min(band.high_hz, 0.5 * rate), 1.5 * low);
  std::vector<Eigen::Index> band_of(static_cast<std::size_t>(n_fft / 2 + 1), -1);
  for (Eigen::Index k = 1; k <= n_fft / 2; ++k) {
    const double f = static_cast<double>(k) * rate / static_cast<double>(n_fft);
    if (f < 0.7 * low || f > high) continue;
    const double x = std::log(std::max(f, low) / low) / std::log(high / low);
    band_of[static_cast<std::size_t>(k)] =
        std::clamp<Eigen::Index>(static_cast<Eigen::Index>(x * kBands), 0, kBands - 1);
  }
  frames.band_power = Eigen::MatrixXd::Zero(kBands, n_frames);
  parallel_for(static_cast<std::size_t>(n_frames), 64, [&](std::size_t begin, std::size_t end) {
    Eigen::VectorXd block(n_fft);
    for (auto t = static_cast<Eigen::Index>(begin); t < static_cast<Eigen::Index>(end); ++t) {
      const Eigen::Index first = t * frames.hop;
      const Eigen::Index count = std::min(frames.window, n - first);
      for (Eigen::Index channel = 0; channel < signal.n_channels(); ++channel) {
        block.setZero();
        block.head(count) = signal.samples.col(channel).segment(first, count).cwiseProduct(window.head(count));
        const Eigen::VectorXcd spectrum = real_spectrum(block, n_fft);
        for (Eigen::Index k = 1; k <= n_fft / 2; ++k) {
          const Eigen::Index b = band_of[static_cast<std::size_t>(k)];
          if (b >= 0) frames.band_power(b, t) += std::norm(spectrum[k]);
        }
      }
    }
  });
  return frames;
}

/// Rise of every frame in dB: the better of the whole band and the mean of the kTopBands that rise most.
Eigen::VectorXd rises_db(const Frames& frames) {
  const Eigen::Index n = frames.band_power.cols();
  const Eigen::VectorXd total = frames.band_power.colwise().sum();
  const double smallest = 1e-9 * total.maxCoeff() + 1e-300;
  Eigen::VectorXd floor(kBands);
  for (Eigen::Index b = 0; b < kBands; ++b) {
    std::vector<double> sorted(static_cast<std::size_t>(n));
    for (Eigen::Index t = 0; t < n; ++t) sorted[static_cast<std::size_t>(t)] = frames.band_power(b, t);
    const auto quantile = sorted.begin() + n / 20;
    std::nth_element(sorted.begin(), quantile, sorted.end());
    floor[b] = 3 * *quantile + smallest / kBands;
  }
  Eigen::VectorXd result = Eigen::VectorXd::Zero(n);
  for (Eigen::Index t = kLagMin; t < n; ++t) {
    const Eigen::Index from = std::max<Eigen::Index>(0, t - kLagMax);
    const Eigen::Index count = t - kLagMin - from + 1;
    std::vector<double> rise(kBands);
    for (Eigen::Index b = 0; b < kBands; ++b) {
      const double before = frames.band_power.row(b).segment(from, count).maxCoeff();
      const double ratio = (frames.band_power(b, t) + floor[b]) / (before + floor[b]);
      rise[static_cast<std::size_t>(b)] = std::clamp(10 * std::log10(ratio), 0.0, kMaxRiseDb);
    }
    std::partial_sort(rise.begin(), rise.begin() + kTopBands, rise.end(), std::greater<>());
    double top = 0;
    for (std::size_t b = 0; b < kTopBands; ++b) top += rise[b] / kTopBands;
    const double before = total.segment(from, count).maxCoeff();
    const double whole = 10 * std::log10((total[t] + floor.sum()) / (before + floor.sum()));
    result[t] = std::max(top, whole);
  }
  return result;
}

/// Energy of the sound above about 100 Hz, averaged over 0.5 ms, summed over channels, frames [begin, end).
Eigen::VectorXd envelope(const Signal& signal, Eigen::Index begin, Eigen::Index end) {
  const double rate = signal.sample_rate_hz;
  const double pole = std::exp(-2 * kPi * std::min(100.0, 0.05 * rate) / rate);
  const auto width = std::max<Eigen::Index>(1, std::llround(kEnvelopeS * rate));
  const Eigen::Index warm = std::max<Eigen::Index>(0, begin - std::llround(0.02 * rate));
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(end - begin);
  for (Eigen::Index channel = 0; channel < signal.n_channels(); ++channel) {
    double x_before = signal.samples(warm, channel), y = 0;
    for (Eigen::Index i = warm; i < end; ++i) {
      const double x = signal.samples(i, channel);
      y = pole * (y + x - x_before);
      x_before = x;
      if (i >= begin) squares[i - begin] += y * y;
    }
  }
  Eigen::VectorXd mean(squares.size());
  double sum = 0;
  for (Eigen::Index i = 0; i < squares.size(); ++i) {
    sum += squares[i];
    if (i >= width) sum -= squares[i - width];
    mean[i] = std::max(sum, 0.0) / static_cast<double>(width);
  }
  return mean;
}

/// First frame of the strike and the frame where contact is over, by the envelope in [begin, end).
Strike refined(const Signal& signal, Eigen::Index begin, Eigen::Index guess, Eigen::Index end, bool starts_at_begin) {
  const double rate = signal.sample_rate_hz;
  const Eigen::VectorXd e = envelope(signal, begin, end);
  Strike strike;
  Eigen::Index onset = starts_at_begin ? 0 : std::clamp<Eigen::Index>(guess - begin, 0, e.size() - 1);
  // What begins within the signal's first 10 ms has nothing to be compared with before it.
  const Eigen::Index quiet = std::clamp<Eigen::Index>(std::llround(0.010 * rate), 1, e.size());
  const double before = starts_at_begin ? 0.0 : e.head(quiet).maxCoeff();
  const double threshold = std::max(1.3 * before, 0.02 * e.maxCoeff());
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    if (e[i] > threshold) {
      onset = i;
      break;
    }
  }
  if (starts_at_begin && static_cast<double>(onset) <= kEnvelopeS * rate) onset = 0;  // it sounds from the first frame
  const Eigen::Index span = std::min<Eigen::Index>(e.size() - onset, std::llround(0.008 * rate) + 1);
  const double top = e.segment(onset, span).maxCoeff();
  Eigen::Index half = onset;
  while (half < onset + span - 1 && e[half] < 0.5 * top) ++half;
  strike.time_s = static_cast<double>(begin + onset) / rate;
  strike.settled_s = strike.time_s + std::min(0.012, 1.5 * static_cast<double>(half - onset) / rate + 0.001);
  return strike;
}

/// Prediction error of a linear predictor of the given order (Burg's recursion): free ringing is predictable
/// from its past, a push from outside is not. Source: Burg 1975; as in Kay, Modern Spectral Estimation, 1988,
/// section 7.3.
Eigen::VectorXd prediction_error(const Eigen::VectorXd& x, int order) {
  Eigen::VectorXd forward = x, backward = x;
  for (Eigen::Index m = 1; m <= order; ++m) {
    const Eigen::Index n = x.size() - m;
    const auto f = forward.tail(n), b = backward.segment(m - 1, n);
    const double power = f.squaredNorm() + b.squaredNorm();
    if (!(power > 0)) break;
    const double k = 2 * f.dot(b) / power;
    const Eigen::VectorXd f_next = f - k * b;
    const Eigen::VectorXd b_next = b - k * f;
    forward.tail(n) = f_next;
    backward.tail(n) = b_next;
  }
  return forward;
}

double median(Eigen::VectorXd values) {
  double* middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  return *middle;
}

/// Time after which nothing touches the body any more, when it was touched again within 60 ms of the strike
/// (a mallet that bounces); 0 when it was not. Such pushes are rises of the prediction error.
double last_push_s(const Signal& signal, double strike_s, double end_s) {
  constexpr double kSpanS = 0.4, kSearchS = 0.06, kBinS = 0.0005;
  constexpr double kRise = 2.2, kAbove = 2.0, kWeakest = 0.05;
  constexpr Eigen::Index kBefore = 6, kAfter = 24;
  const double rate = signal.sample_rate_hz;
  const Eigen::Index begin = std::llround(strike_s * rate);
  const Eigen::Index end =
      std::min<Eigen::Index>(signal.n_frames(), std::llround(std::min(end_s, strike_s + kSpanS) * rate));
  if (static_cast<double>(end - begin) < 0.04 * rate || rate < 6000) return 0;
  Eigen::Index loudest = 0;
  signal.samples.middleRows(begin, end - begin).colwise().squaredNorm().maxCoeff(&loudest);
  Signal part;
  part.sample_rate_hz = rate;
  part.samples = signal.samples.col(loudest).segment(begin, end - begin);
  part.samples.array() -= part.samples.mean();
  if (rate > 60000) part = resample(part, 48000);
  const Eigen::Index bin = std::max<Eigen::Index>(2, std::llround(kBinS * part.sample_rate_hz));
  const auto order = static_cast<int>(std::min<Eigen::Index>(128, part.n_frames() / 8));
  const Eigen::VectorXd error = prediction_error(part.samples.col(0), order);
  Eigen::VectorXd level(error.size() / bin);
  for (Eigen::Index i = 0; i < level.size(); ++i) {
    level[i] = std::sqrt(error.segment(i * bin, bin).squaredNorm() / static_cast<double>(bin));
  }
  if (level.size() < kBefore + kAfter + 8) return 0;
  const double struck = level.head(4).maxCoeff();
  const double bin_s = static_cast<double>(bin) / part.sample_rate_hz;
  double last = 0;
  for (Eigen::Index i = kBefore; i + kAfter + 4 < level.size() && static_cast<double>(i) * bin_s < kSearchS; ++i) {
    const bool rises = level[i] > kRise * median(level.segment(i - kBefore, kBefore));
    const bool stands_out = level[i] > kAbove * median(level.segment(i + 4, kAfter));
    if (rises && stands_out && level[i] > kWeakest * struck) last = (static_cast<double>(i) + 4) * bin_s;
  }
  return last;
}

/// The kink where a ring is cut off (a fade, a gate, a hand) splashes over the bands and would be a strike of its own, though
/// nothing is louder after it.
void drop_sudden_ends(const Signal& signal, std::vector<Strike>& strikes) {
  constexpr double kNearS = 0.05;
  const double rate = signal.sample_rate_hz;
  for (std::size_t s = 0; s + 1 < strikes.size();) {
    const auto begin =
        std::min(signal.n_frames(), static_cast<Eigen::Index>(std::llround(strikes[s].settled_s * rate)));
    const double end_s = s + 2 < strikes.size() ? strikes[s + 2].time_s - 0.002 : signal.duration_s();
    const auto end = std::min(signal.n_frames(), static_cast<Eigen::Index>(std::llround(end_s * rate)));
    const auto cut = end > begin ? sudden_end(signal.samples.middleRows(begin, end - begin), rate) : std::nullopt;
    const bool is_end = cut && std::abs(static_cast<double>(begin + *cut) / rate - strikes[s + 1].time_s) <= kNearS;
    if (is_end) {
      strikes.erase(strikes.begin() + static_cast<std::ptrdiff_t>(s) + 1);
    } else {
      ++s;
    }
  }
}

}  // namespace

void StrikeOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e9)));
  throw_violations("strikes", std::move(violations));
}

std::vector<Strike> detect_strikes(const Signal& signal, const StrikeOptions& options) {
  options.validate();
  checked_open("strikes", "sample_rate_hz", signal.sample_rate_hz, 0, 1e9);
  if (signal.samples.size() == 0) throw InputError("strikes", "the signal has no samples");
  const double rate = signal.sample_rate_hz;
  const Frames frames = band_frames(signal, options.band);
  const Eigen::VectorXd total = frames.band_power.colwise().sum();
  const Eigen::Index n = total.size();
  const double loudest = total.maxCoeff();
  if (!(loudest > 0)) return {};
  const Eigen::VectorXd rise = rises_db(frames);
  const double weakest = loudest * std::pow(10.0, options.min_level_db / 10);
  const auto apart =
      std::max<Eigen::Index>(1, std::llround(options.min_interval_s * rate / static_cast<double>(frames.hop)));
  const auto level_after = [&](Eigen::Index t) {
    return total.segment(t, std::min<Eigen::Index>(n - t, 13)).maxCoeff();
  };

  std::vector<Strike> strikes;
  if (total[0] >= 0.01 * loudest) {
    const auto end = std::min<Eigen::Index>(signal.n_frames(), std::llround(0.03 * rate) + 1);
    Strike first = refined(signal, 0, 0, end, true);
    first.level = std::sqrt(total[0]);
    strikes.push_back(first);
  }
  for (Eigen::Index t = 1; t < n; ++t) {
    if (!(rise[t] >= options.min_rise_db) || level_after(t) < weakest) continue;
    const Eigen::Index from = std::max<Eigen::Index>(0, t - apart);
    const Eigen::Index to = std::min(n - 1, t + apart);
    Eigen::Index best = 0;
    rise.segment(from, to - from + 1).maxCoeff(&best);
    if (from + best != t) continue;  // not the highest of its neighbourhood (the first one of equals)
    const Eigen::Index centre = t * frames.hop + frames.window / 2;
    const auto begin = std::max<Eigen::Index>(0, centre - std::llround(0.030 * rate));
    const auto end = std::min<Eigen::Index>(signal.n_frames(), centre + std::llround(0.012 * rate) + 1);
    Strike strike = refined(signal, begin, centre, end, false);
    strike.level = std::sqrt(level_after(t));
    if (!strikes.empty() && strike.time_s - strikes.back().time_s < options.min_interval_s) {
      if (strike.level > 2 * strikes.back().level) strikes.back() = strike;  // what came before was its prelude
      continue;
    }
    strikes.push_back(strike);
  }
  drop_sudden_ends(signal, strikes);
  for (std::size_t s = 0; s < strikes.size(); ++s) {
    const double end_s = s + 1 < strikes.size() ? strikes[s + 1].time_s - 0.002 : signal.duration_s();
    strikes[s].settled_s =
        std::max(strikes[s].settled_s, strikes[s].time_s + last_push_s(signal, strikes[s].time_s, end_s));
  }
  return strikes;
}

}  // namespace klang::audio
