#include "fit/ringdown/detail/ring_data.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/sound/audio/fft.hpp"
#include "core/sound/audio/sudden_end.hpp"

namespace klang::fit::detail {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t kMaxChannels = 4;
constexpr Eigen::Index kMaxWindow = Eigen::Index{1} << 22;  ///< frames; bounds memory for long recordings
constexpr double kMinSegmentS = 0.008;

/// Frames at which a channel stands at its rail: at least three neighbours at the very same extreme value,
/// which lies far above the quantisation step.
std::vector<Eigen::Index> clipped_frames(const Eigen::VectorXd& x) {
  const double top = x.maxCoeff(), bottom = x.minCoeff();
  double step = 0;
  for (const double v : x) {
    if (v != 0 && (step == 0 || std::abs(v) < step)) step = std::abs(v);
  }
  std::vector<Eigen::Index> frames;
  for (const double rail : {top, bottom}) {
    if (std::abs(rail) < 0.02 || std::abs(rail) < 100 * step) continue;
    const double tolerance = 1e-7 * std::abs(rail);
    Eigen::Index run = 0;
    for (Eigen::Index i = 0; i <= x.size(); ++i) {
      if (i < x.size() && std::abs(x[i] - rail) <= tolerance) {
        ++run;
        continue;
      }
      if (run >= 3) {
        for (Eigen::Index j = i - run; j < i; ++j) frames.push_back(j);
      }
      run = 0;
    }
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

/// What a partial puts into a band is a polynomial over its bins, which the fits' background takes up to 1e-5 of it, when
/// the line lies 20 widths of the band (and of the line) away.
bool leaks_smoothly(const Pole& pole, double low_hz, double high_hz) {
  constexpr double kFar = 20;
  const double away = std::max(low_hz - pole.frequency_hz, pole.frequency_hz - high_hz);
  return away > kFar * (high_hz - low_hz + std::abs(pole.decay_per_s) / (2 * kPi)) &&
         pole.frequency_hz + low_hz > kFar * (high_hz - low_hz);
}

}  // namespace

double RingPartial::energy() const { return amplitude.squaredNorm() / (4 * (std::max(pole.decay_per_s, 0.0) + 1)); }

RingData::RingData(const audio::Signal& recording, const std::vector<audio::Strike>& strikes, const Band& band)
    : rate_(recording.sample_rate_hz),
      coded_s_(static_cast<double>(recording.coded_frames) / recording.sample_rate_hz),
      band_(band) {
  choose_channels(recording);
  cut_segments(strikes, recording.n_frames());
}

/// The loudest channels, without those that are copies of (combinations of) louder ones: a mono recording
/// stored twice has one channel's worth of information.
void RingData::choose_channels(const audio::Signal& recording) {
  const Eigen::RowVectorXd mean = recording.samples.colwise().mean();
  std::vector<double> energy;
  for (Eigen::Index c = 0; c < recording.n_channels(); ++c) {
    energy.push_back((recording.samples.col(c).array() - mean[c]).square().sum());
  }
  std::vector<Eigen::Index> order(energy.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return energy[static_cast<std::size_t>(a)] > energy[static_cast<std::size_t>(b)];
  });
  std::size_t left_out = 0;
  for (const Eigen::Index c : order) {
    const double own = energy[static_cast<std::size_t>(c)];
    if (!(own > 1e-4 * energy[static_cast<std::size_t>(order.front())])) continue;
    if (channels_.size() == kMaxChannels) {
      ++left_out;
      continue;
    }
    Eigen::VectorXd x = recording.samples.col(c).array() - mean[c];
    const auto k = static_cast<Eigen::Index>(channels_.size());
    Eigen::MatrixXd gram(k, k);
    Eigen::VectorXd shared(k);
    for (Eigen::Index i = 0; i < k; ++i) {
      shared[i] = channels_[static_cast<std::size_t>(i)].dot(x);
      for (Eigen::Index j = 0; j < k; ++j) {
        gram(i, j) = channels_[static_cast<std::size_t>(i)].dot(channels_[static_cast<std::size_t>(j)]);
      }
    }
    const double explained = k > 0 ? shared.dot(gram.colPivHouseholderQr().solve(shared)) : 0.0;
    if (k > 0 && !(own - explained > 1e-9 * own)) continue;
    channels_.push_back(std::move(x));
    channel_numbers_.push_back(c);
  }
  if (left_out > 0) {
    warnings_.push_back("the " + std::to_string(kMaxChannels) + " loudest of " +
                        std::to_string(recording.n_channels()) + " channels used");
  }
}

void RingData::cut_segments(const std::vector<audio::Strike>& strikes, Eigen::Index n_frames) {
  std::vector<Eigen::Index> clipped;
  for (const Eigen::VectorXd& x : channels_) {
    const auto frames = clipped_frames(x);
    clipped.insert(clipped.end(), frames.begin(), frames.end());
  }
  std::sort(clipped.begin(), clipped.end());
  clipped.erase(std::unique(clipped.begin(), clipped.end()), clipped.end());
  n_clipped_ = static_cast<Eigen::Index>(clipped.size());
  for (std::size_t s = 0; s < strikes.size(); ++s) {
    Segment segment;
    segment.strike_s = strikes[s].time_s;
    segment.begin = std::llround(strikes[s].settled_s * rate_);
    segment.end = n_frames;
    if (s + 1 < strikes.size()) {
      segment.end = std::min(n_frames, static_cast<Eigen::Index>(std::floor((strikes[s + 1].time_s - 0.002) * rate_)));
    }
    const auto next = std::lower_bound(clipped.begin(), clipped.end(), segment.end);
    if (next != clipped.begin() && *(next - 1) >= segment.begin) segment.begin = *(next - 1) + 2;
    segment.begin = std::max<Eigen::Index>(segment.begin, 0);
    segment.end = std::min(segment.end, segment.begin + kMaxWindow / static_cast<Eigen::Index>(channels_.size()));
    Eigen::MatrixXd stretch(std::max<Eigen::Index>(0, segment.end - segment.begin),
                            static_cast<Eigen::Index>(channels_.size()));
    for (std::size_t c = 0; c < channels_.size(); ++c)
      stretch.col(static_cast<Eigen::Index>(c)) = channels_[c].segment(segment.begin, stretch.rows());
    if (const auto cut = audio::sudden_end(stretch, rate_)) {
      segment.end = segment.begin + *cut;
      ++n_cut_off_;
    }
    segment.delay_s = static_cast<double>(segment.begin) / rate_ - segment.strike_s;
    const auto shortest = std::max<Eigen::Index>(16, std::llround(kMinSegmentS * rate_));
    if (segment.end - segment.begin >= shortest) segments_.push_back(segment);
  }
  peaks_.resize(static_cast<Eigen::Index>(segments_.size()), static_cast<Eigen::Index>(channels_.size()));
  for (Eigen::Index s = 0; s < peaks_.rows(); ++s) {
    const Segment& segment = segments_[static_cast<std::size_t>(s)];
    for (Eigen::Index c = 0; c < peaks_.cols(); ++c) {
      peaks_(s, c) = channels_[static_cast<std::size_t>(c)]
                         .segment(segment.begin, segment.end - segment.begin)
                         .cwiseAbs()
                         .maxCoeff();
    }
  }
}

double RingData::longest_segment_s() const {
  double longest = 0;
  for (const Segment& s : segments_) longest = std::max(longest, static_cast<double>(s.end - s.begin) / rate_);
  return longest;
}

Eigen::Index RingData::longest_segment() const {
  std::size_t best = 0;
  for (std::size_t s = 1; s < segments_.size(); ++s) {
    if (segments_[s].end - segments_[s].begin > segments_[best].end - segments_[best].begin) best = s;
  }
  return static_cast<Eigen::Index>(best);
}

const Eigen::VectorXcd& RingData::spectrum(Eigen::Index segment, Eigen::Index channel, Eigen::Index offset,
                                           Eigen::Index n) const {
  const std::array<Eigen::Index, 4> key{segment, channel, offset, n};
  {
    const std::lock_guard lock(mutex_);
    const auto found = spectra_.find(key);
    if (found != spectra_.end()) return found->second;
  }
  Eigen::VectorXcd bins = audio::real_spectrum(channels_[static_cast<std::size_t>(channel)].segment(
                                                   segments_[static_cast<std::size_t>(segment)].begin + offset, n),
                                               n);
  bins /= std::sqrt(static_cast<double>(n));
  const std::lock_guard lock(mutex_);
  return spectra_.try_emplace(key, std::move(bins)).first->second;
}

SubBand RingData::sub_band(double low_hz, double high_hz, double duration_s, const std::vector<RingPartial>& others,
                           Eigen::Index offset) const {
  SubBand band;
  const double offset_s = static_cast<double>(offset) / rate_;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const Eigen::Index available = segments_[s].end - segments_[s].begin - offset;
    if (available < 16) continue;
    const auto wanted = static_cast<Eigen::Index>(std::min(duration_s * rate_, static_cast<double>(available)));
    if (wanted < 16) continue;
    const Eigen::Index n = audio::good_fft_size_below(wanted);
    const double per_bin = rate_ / static_cast<double>(n);
    const Eigen::Index first = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::ceil(low_hz / per_bin)));
    const Eigen::Index last =
        std::min<Eigen::Index>((n - 1) / 2, static_cast<Eigen::Index>(std::floor(high_hz / per_bin)));
    if (last - first + 1 < 2 * kBackgroundTerms) continue;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      BinBlock block;
      block.segment = static_cast<Eigen::Index>(s);
      block.channel = static_cast<Eigen::Index>(c);
      block.n = n;
      block.first_bin = first;
      block.sample_rate_hz = rate_;
      block.y = spectrum(block.segment, block.channel, offset, n).segment(first, last - first + 1);
      for (const RingPartial& other : others) {
        if (leaks_smoothly(other.pole, low_hz, high_hz)) continue;
        const Complex sigma(-other.pole.decay_per_s, 2 * kPi * other.pole.frequency_hz);
        const Complex a = other.amplitude(block.segment, block.channel) * std::exp(sigma * offset_s);
        block.y -= exponential_bins(block, other.pole.frequency_hz, other.pole.decay_per_s, a);
      }
      band.time_scale_s = std::max(band.time_scale_s, block.duration_s());
      band.blocks.push_back(std::move(block));
    }
  }
  return band;
}

Eigen::VectorXd RingData::residual(Eigen::Index segment, Eigen::Index channel, Eigen::Index n,
                                   const std::vector<RingPartial>& partials) const {
  Eigen::VectorXd x =
      channels_[static_cast<std::size_t>(channel)].segment(segments_[static_cast<std::size_t>(segment)].begin, n);
  constexpr Eigen::Index kBlock = 1024;  // the recurrence restarts from the closed form before rounding adds up
  for (const RingPartial& partial : partials) {
    const Complex a = partial.amplitude(segment, channel);
    if (a == Complex(0, 0)) continue;
    const Complex sigma(-partial.pole.decay_per_s / rate_, 2 * kPi * partial.pole.frequency_hz / rate_);
    // y[m+1] = 2 Re(z) y[m] - |z|^2 y[m-1]
    const Complex z = std::exp(sigma);
    const double c1 = 2 * z.real(), c2 = -std::norm(z);
    for (Eigen::Index begin = 0; begin < n; begin += kBlock) {
      const Eigen::Index end = std::min(begin + kBlock, n);
      const Complex now = a * std::exp(sigma * static_cast<double>(begin));
      if (std::norm(now) < 1e-24 * std::norm(a) && partial.pole.decay_per_s > 0) break;
      double y0 = now.real(), y1 = (now * z).real();
      for (Eigen::Index i = begin; i < end; ++i) {
        x[i] -= y0;
        const double y2 = c1 * y1 + c2 * y0;
        y0 = y1;
        y1 = y2;
      }
    }
  }
  return x;
}

}  // namespace klang::fit::detail
