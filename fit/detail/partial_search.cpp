#include "fit/detail/partial_search.hpp"

#include <algorithm>
#include <cmath>

#include "core/audio/fft.hpp"
#include "core/base/parallel.hpp"
#include "fit/detail/esprit.hpp"

namespace klang::fit::detail {
namespace {

using Complex = std::complex<double>;

constexpr double kHalfBandCells =
    20;  ///< half width of a sub-band beyond its outermost partial, in 1 / window
constexpr double kDecaysPerWindow = 5;  ///< a window ends when its partial has fallen to exp(-5)
constexpr double kShortestWindowS = 0.006;
constexpr double kLogFalseAlarm = 14;  ///< -ln of the chance that one test invents a partial
constexpr Eigen::Index kMaxOrder = 14;
constexpr double kNoiseLikeResidual = 3.0;    ///< residual over noise up to which only significance counts
constexpr double kWorthwhileReduction = 3.0;  ///< of the residual, a partial, above that
constexpr double kDisturbed = 4.0;            ///< residual over noise from which later starts are tried
constexpr double kForeseeable = 50.0;         ///< power over noise from which a partial must be seen later
constexpr double kLost = 0.7;                 ///< part of its amplitude that may be missing there
constexpr double kSurer = 1.3;                ///< how much smaller the deviation must be to start later
constexpr double kSameStory = 2.5;            ///< residual with a later start's poles over the one without

/// Smallest x with P(chi-square(dof) > x) below exp(-log_p) (Laurent and Massart 2000, Lemma 1).
double chi_square_bound(double dof, double log_p) { return dof + 2 * std::sqrt(dof * log_p) + 2 * log_p; }

/// Four-term Blackman-Harris window (side lobes below -92 dB), unit power.
Eigen::VectorXd blackman_harris(Eigen::Index n) {
  Eigen::VectorXd w(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = 2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    w[i] = 0.35875 - 0.48829 * std::cos(x) + 0.14128 * std::cos(2 * x) - 0.01168 * std::cos(3 * x);
  }
  return w / w.norm();
}

double window_of(const Pole& pole, const RingData& data) {
  const double shortest = std::max(kShortestWindowS, 64 / data.sample_rate_hz());
  const double wanted = pole.decay_per_s > 0 ? kDecaysPerWindow / pole.decay_per_s : 1e9;
  // A grid of lengths, so that fits share spectra.
  const double longest = data.longest_segment_s();
  const double steps = std::max(0.0, std::floor(2 * std::log2(longest / std::max(wanted, shortest))));
  return longest * std::exp2(-0.5 * steps);
}

struct Peak {
  double frequency_hz = 0.0;
  double excess = 0.0;  ///< power over noise
};

struct PeakSpectrum {
  std::vector<Peak> peaks;
  double window_s = 0.0;
};

/// Noise of the recording's quietest stretches by frequency: the last half of the longest segment (at most 2
/// s), channels averaged. Variance per bin in the scale of BinBlock.
class TailNoise {
 public:
  explicit TailNoise(const RingData& data) {
    const Segment& segment = data.segments()[static_cast<std::size_t>(data.longest_segment())];
    const Eigen::Index length = segment.end - segment.begin;
    const Eigen::Index n = audio::good_fft_size_below(std::max<Eigen::Index>(
        8, std::min(length / 2, static_cast<Eigen::Index>(2 * data.sample_rate_hz()))));
    per_bin_hz_ = data.sample_rate_hz() / static_cast<double>(n);
    const Eigen::VectorXd window = blackman_harris(n);
    floor_ = Eigen::VectorXd::Zero(n / 2 + 1);
    for (const Eigen::VectorXd& x : data.channels()) {
      const Eigen::VectorXd tail = x.segment(segment.end - n, n).cwiseProduct(window);
      floor_ += noise_floor(audio::real_spectrum(tail, n).cwiseAbs2(), 1) /
                static_cast<double>(data.channels().size());
    }
  }
  double at(double frequency_hz) const {
    const auto k = static_cast<Eigen::Index>(std::llround(frequency_hz / per_bin_hz_));
    return floor_[std::clamp<Eigen::Index>(k, 0, floor_.size() - 1)];
  }

 private:
  double per_bin_hz_ = 1.0;
  Eigen::VectorXd floor_;
};

/// Peaks of the residual's spectrum in windows of about window_s from the beginning of each segment.
PeakSpectrum find_peaks(const RingData& data, double window_s, const std::vector<RingPartial>& found,
                        const SearchOptions& options) {
  PeakSpectrum result;
  const auto wanted = static_cast<Eigen::Index>(window_s * data.sample_rate_hz() + 0.5);
  std::vector<Eigen::Index> usable;
  for (std::size_t s = 0; s < data.segments().size(); ++s) {
    if (data.segments()[s].end - data.segments()[s].begin >= wanted)
      usable.push_back(static_cast<Eigen::Index>(s));
  }
  Eigen::Index n = audio::good_fft_size_below(std::max<Eigen::Index>(wanted, 16));
  if (usable.empty()) {
    usable.push_back(data.longest_segment());
    const Segment& s = data.segments()[static_cast<std::size_t>(usable.front())];
    n = audio::good_fft_size_below(std::min(n, s.end - s.begin));
  }
  const auto n_channels = static_cast<Eigen::Index>(data.channels().size());
  const Eigen::VectorXd window = blackman_harris(n);
  std::vector<Eigen::VectorXd> powers(
      static_cast<std::size_t>(static_cast<Eigen::Index>(usable.size()) * n_channels));
  for_each_job(powers.size(), [&](std::size_t job) {
    const Eigen::Index segment = usable[job / static_cast<std::size_t>(n_channels)];
    const Eigen::Index channel = static_cast<Eigen::Index>(job) % n_channels;
    const Eigen::VectorXd rest = data.residual(segment, channel, n, found).cwiseProduct(window);
    powers[job] = audio::real_spectrum(rest, n).cwiseAbs2();
  });
  // Channels and strikes differ in loudness: each is measured against its own noise.
  Eigen::VectorXd excess = Eigen::VectorXd::Zero(n / 2 + 1);
  for (const Eigen::VectorXd& power : powers) {
    excess += power.cwiseQuotient((noise_floor(power, 1).array() + 1e-30).matrix());
  }
  const auto count = static_cast<double>(powers.size());
  excess /= count;
  const double per_bin = data.sample_rate_hz() / static_cast<double>(n);
  result.window_s = static_cast<double>(n) / data.sample_rate_hz();
  const double log_p = std::log(static_cast<double>(n)) + 5;
  const double sure = 1 + std::sqrt(2 * log_p / count) + log_p / count;
  const double threshold = std::max(sure, std::pow(10.0, options.min_snr_db / 10) / count);
  const Eigen::Index first =
      std::max<Eigen::Index>(2, static_cast<Eigen::Index>(std::ceil(data.band().low_hz / per_bin)));
  const Eigen::Index last =
      std::min<Eigen::Index>(n / 2 - 2, static_cast<Eigen::Index>(std::floor(data.band().high_hz / per_bin)));
  for (Eigen::Index k = first; k <= last; ++k) {
    if (excess[k] < threshold || excess[k] < excess[k - 1] || excess[k] <= excess[k + 1]) continue;
    if (excess[k] < excess[k - 2] || excess[k] < excess[k + 2]) continue;
    result.peaks.push_back({static_cast<double>(k) * per_bin, excess[k]});
  }
  const auto most = static_cast<std::size_t>(2 * options.max_partials);
  if (result.peaks.size() > most) {
    std::nth_element(result.peaks.begin(), result.peaks.begin() + static_cast<std::ptrdiff_t>(most),
                     result.peaks.end(), [](const Peak& a, const Peak& b) { return a.excess > b.excess; });
    result.peaks.resize(most);
    std::sort(result.peaks.begin(), result.peaks.end(),
              [](const Peak& a, const Peak& b) { return a.frequency_hz < b.frequency_hz; });
  }
  return result;
}

/// The damped exponential of a grid that takes most out of the residuals.
Pole best_atom(const SubBand& band, const LinearFit& fit, double low_hz, double high_hz) {
  Pole best;
  double best_gain = -1;
  const double cell = 1 / band.time_scale_s;
  for (const double decay_cells : {0.3, 1.5, 4.0, 10.0, 25.0}) {
    for (double f = low_hz; f <= high_hz; f += 0.5 * cell) {
      double gain = 0;
      for (std::size_t b = 0; b < band.blocks.size(); ++b) {
        const BinBlock& block = band.blocks[b];
        const Eigen::VectorXcd g = one_sided_bins(block, f, decay_cells * cell);
        const Complex along = g.dot(fit.residuals[b]);
        const double norm = g.squaredNorm();
        gain += std::norm(along) / norm;
      }
      if (gain > best_gain) {
        best_gain = gain;
        best = {f, decay_cells * cell};
      }
    }
  }
  return best;
}

/// A fit that describes lines of this band, not its background or each other.
bool sensible(const RefinedFit& fit, const SubBand& band, double low_hz, double high_hz) {
  if (!fit.ok) return false;
  const double cell = 1 / band.time_scale_s;
  for (std::size_t i = 0; i < fit.poles.size(); ++i) {
    const Pole& pole = fit.poles[i];
    if (!(pole.decay_per_s > -1.5 * cell) || !(pole.decay_per_s <= 45 * cell)) return false;
    if (!(pole.frequency_hz > low_hz) || !(pole.frequency_hz < high_hz)) return false;
    for (std::size_t j = 0; j < i; ++j) {
      // Two exponentials closer than a small part of their width are one that does not decay exponentially.
      const double apart = std::abs(pole.frequency_hz - fit.poles[j].frequency_hz);
      const double width = std::max(pole.decay_per_s, fit.poles[j].decay_per_s) / (2 * kPi);
      if (apart < std::max(0.1 * width, 0.02 * cell)) return false;
    }
  }
  return true;
}

double significance_bound(const SubBand& band) {
  const double added = 2 + 2 * static_cast<double>(band.blocks.size());
  return chi_square_bound(added, kLogFalseAlarm);
}

/// Twice the log-likelihood ratio of two nested fits with unknown noise, in the scale of a chi-square.
double likelihood_gain(const SubBand& band, const LinearFit& small, const LinearFit& large,
                       std::size_t large_order) {
  const double used =
      static_cast<double>(2 * large_order) +
      static_cast<double>(band.blocks.size()) * static_cast<double>(2 * large_order + 2 * kBackgroundTerms);
  const double freedom = std::max(1.0, static_cast<double>(band.n_real_data()) - used);
  return (small.residual_sum_sq - large.residual_sum_sq) / (large.residual_sum_sq / freedom + 1e-300);
}

double residual_variance(const SubBand& band, const RefinedFit& fit) {
  const auto order = static_cast<double>(fit.poles.size());
  const double used =
      2 * order + static_cast<double>(band.blocks.size()) * (2 * order + 2 * kBackgroundTerms);
  return 2 * fit.linear.residual_sum_sq / std::max(1.0, static_cast<double>(band.n_real_data()) - used);
}

/// Real partials are not exactly exponential, and every exponential more mends a little of what is left:
/// significant against the noise, but no partial. While the residual stands above the noise, one more must
/// remove most of it.
bool worthwhile(const SubBand& band, const RefinedFit& small, const RefinedFit& large,
                double noise_variance) {
  const double left = residual_variance(band, large);
  if (left <= kNoiseLikeResidual * noise_variance) return true;
  const auto added = static_cast<double>(large.poles.size() - small.poles.size());
  return small.linear.residual_sum_sq >= std::pow(kWorthwhileReduction, added) * large.linear.residual_sum_sq;
}

struct Cluster {
  double low_hz = 0.0, high_hz = 0.0;          ///< outermost peaks
  double own_low_hz = 0.0, own_high_hz = 0.0;  ///< partials outside belong to a neighbour
  Eigen::Index n_peaks = 0;
};

std::vector<Cluster> clusters_of(const PeakSpectrum& spectrum) {
  const double cell = 1 / spectrum.window_s;
  std::vector<Cluster> clusters;
  for (const Peak& peak : spectrum.peaks) {
    const bool near = !clusters.empty() && peak.frequency_hz - clusters.back().high_hz < 10 * cell &&
                      clusters.back().n_peaks < 6;
    if (!near) clusters.push_back({peak.frequency_hz, peak.frequency_hz, 0, 0, 0});
    clusters.back().high_hz = peak.frequency_hz;
    ++clusters.back().n_peaks;
  }
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    clusters[i].own_low_hz = clusters[i].low_hz - 6 * cell;
    clusters[i].own_high_hz = clusters[i].high_hz + 6 * cell;
    if (i > 0)
      clusters[i].own_low_hz =
          std::max(clusters[i].own_low_hz, 0.5 * (clusters[i - 1].high_hz + clusters[i].low_hz));
    if (i + 1 < clusters.size()) {
      clusters[i].own_high_hz =
          std::min(clusters[i].own_high_hz, 0.5 * (clusters[i].high_hz + clusters[i + 1].low_hz));
    }
  }
  return clusters;
}

Eigen::MatrixXcd amplitudes_of(const RingData& data, const SubBand& band, const LinearFit& linear,
                               std::size_t index) {
  Eigen::MatrixXcd amplitude = Eigen::MatrixXcd::Zero(static_cast<Eigen::Index>(data.segments().size()),
                                                      static_cast<Eigen::Index>(data.channels().size()));
  for (std::size_t b = 0; b < band.blocks.size(); ++b) {
    const auto i = static_cast<Eigen::Index>(2 * index);
    amplitude(band.blocks[b].segment, band.blocks[b].channel) =
        Complex(linear.coefficients[b][i], linear.coefficients[b][i + 1]);
  }
  return amplitude;
}

/// New partials of one cluster; known ones of similar decay near it are fitted along and dropped afterwards.
std::vector<FittedPartial> explore(const RingData& data, const Cluster& cluster, double window_s,
                                   const std::vector<FittedPartial>& known, double noise) {
  const double cell = 1 / window_s;
  const double low = cluster.low_hz - kHalfBandCells * cell;
  const double high = cluster.high_hz + kHalfBandCells * cell;
  std::vector<RingPartial> others;
  std::vector<Pole> poles;
  for (const FittedPartial& partial : known) {
    const Pole& pole = partial.ring.pole;
    const bool inside =
        pole.frequency_hz > cluster.low_hz - 10 * cell && pole.frequency_hz < cluster.high_hz + 10 * cell;
    if (inside && pole.decay_per_s < 40 * cell && pole.decay_per_s > -cell && poles.size() < 8) {
      poles.push_back(pole);
    } else {
      others.push_back(partial.ring);
    }
  }
  const std::size_t n_known = poles.size();
  const SubBand band = data.sub_band(low, high, window_s, others);
  if (band.blocks.empty()) return {};
  RefinedFit current = refine(band, poles, false);
  if (!current.ok) return {};
  const EspritSubspace subspace(band);
  const double inner_low = low + 2 * cell, inner_high = high - 2 * cell;
  const double bound = significance_bound(band);
  const auto most =
      std::min<Eigen::Index>(static_cast<Eigen::Index>(n_known) + cluster.n_peaks + 6, kMaxOrder);
  // Two orders are tried beyond the last success: a pair may only pay off together.
  for (Eigen::Index order = static_cast<Eigen::Index>(n_known) + 1, failures = 0;
       order <= most && failures < 2; ++order) {
    // Of the subspace's poles and the present ones plus the best single exponential, the better start is
    // refined.
    std::vector<Pole> start = subspace.poles(order);
    const bool inside = std::all_of(start.begin(), start.end(), [&](const Pole& pole) {
      return pole.frequency_hz > inner_low && pole.frequency_hz < inner_high && pole.decay_per_s < 45 * cell;
    });
    if (!inside) start.clear();
    if (static_cast<Eigen::Index>(current.poles.size()) + 1 == order) {
      std::vector<Pole> grown = current.poles;
      grown.push_back(best_atom(band, current.linear, inner_low + cell, inner_high - cell));
      const bool better =
          start.empty() || linear_fit(band, grown).residual_sum_sq < linear_fit(band, start).residual_sum_sq;
      if (better) start = std::move(grown);
    }
    RefinedFit best;
    if (!start.empty()) best = refine(band, start, false);
    best.ok = best.ok && sensible(best, band, inner_low, inner_high);
    const auto extra = static_cast<double>(order - static_cast<Eigen::Index>(current.poles.size()));
    if (best.ok && likelihood_gain(band, current.linear, best.linear, best.poles.size()) >= extra * bound &&
        worthwhile(band, current, best, noise)) {
      current = std::move(best);
      failures = 0;
    } else {
      ++failures;
    }
  }
  // Which of the poles are the known ones? The nearest to each, once.
  std::vector<bool> is_known(current.poles.size(), false);
  for (const Pole& pole : poles) {
    std::size_t nearest = current.poles.size();
    double distance = 1e300;
    for (std::size_t i = 0; i < current.poles.size(); ++i) {
      const double d = std::abs(current.poles[i].frequency_hz - pole.frequency_hz) +
                       std::abs(current.poles[i].decay_per_s - pole.decay_per_s) / (2 * kPi);
      if (!is_known[i] && d < distance) {
        distance = d;
        nearest = i;
      }
    }
    if (nearest < current.poles.size()) is_known[nearest] = true;
  }
  std::vector<FittedPartial> fresh;
  for (std::size_t i = 0; i < current.poles.size(); ++i) {
    const double f = current.poles[i].frequency_hz;
    if (is_known[i] || !(f >= cluster.own_low_hz) || !(f < cluster.own_high_hz)) continue;
    if (!(f >= data.band().low_hz) || !(f <= data.band().high_hz)) continue;
    FittedPartial partial;
    partial.ring.pole = current.poles[i];
    partial.ring.amplitude = amplitudes_of(data, band, current.linear, i);
    partial.window_s = band.time_scale_s;
    fresh.push_back(std::move(partial));
  }
  return fresh;
}

/// Neighbours whose lines overlap and whose decays are alike are fitted together.
std::vector<std::vector<std::size_t>> groups_of(const RingData& data,
                                                const std::vector<FittedPartial>& partials) {
  std::vector<std::size_t> order(partials.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return partials[a].ring.pole.frequency_hz < partials[b].ring.pole.frequency_hz;
  });
  std::vector<std::vector<std::size_t>> groups;
  for (const std::size_t i : order) {
    const Pole& pole = partials[i].ring.pole;
    const double window = window_of(pole, data);
    bool placed = false;
    for (auto group = groups.rbegin(); group != groups.rend() && !placed; ++group) {
      if (std::distance(groups.rbegin(), group) > 8) break;
      const Pole& last = partials[group->back()].ring.pole;
      const double other = window_of(last, data);
      const double shorter = std::min(window, other), longer = std::max(window, other);
      if (group->size() < 8 && pole.frequency_hz - last.frequency_hz < 6 / shorter && longer < 5 * shorter) {
        group->push_back(i);
        placed = true;
      }
    }
    if (!placed) groups.push_back({i});
  }
  return groups;
}

struct GroupFit {
  bool ok = false;
  SubBand band;
  RefinedFit fit;
  FitCovariance spread;
  double variance = 0.0;
  double strongest_std_hz = 1e300;  ///< of the group's strongest partial
};

GroupFit fit_group(const RingData& data, const std::vector<Pole>& poles,
                   const std::vector<RingPartial>& others, double window, Eigen::Index offset) {
  GroupFit result;
  double low = 1e300, high = 0, fastest = 0;
  for (const Pole& pole : poles) {
    low = std::min(low, pole.frequency_hz);
    high = std::max(high, pole.frequency_hz);
    fastest = std::max(fastest, pole.decay_per_s);
  }
  const double half = std::max(kHalfBandCells / window, fastest);
  result.band = data.sub_band(low - half, high + half, window, others, offset);
  if (result.band.blocks.empty()) return result;
  result.fit = refine(result.band, poles);
  if (!result.fit.ok) return result;
  result.variance = residual_variance(result.band, result.fit);
  result.spread = covariance(result.band, result.fit.poles, result.fit.linear, result.variance);
  if (!result.spread.ok) return result;
  const auto n = static_cast<Eigen::Index>(2 * poles.size());
  double strongest = -1;
  for (std::size_t b = 0; b < result.band.blocks.size(); ++b) {
    const double loudest = data.peak(result.band.blocks[b].segment, result.band.blocks[b].channel);
    const Eigen::VectorXd& c = result.fit.linear.coefficients[b];
    if (!(c.head(n).cwiseAbs().maxCoeff() <= 3 * loudest)) return result;
    for (Eigen::Index i = 0; i < n; i += 2) {
      if (c.segment(i, 2).norm() <= strongest) continue;
      strongest = c.segment(i, 2).norm();
      result.strongest_std_hz = std::sqrt(result.spread.poles(i, i));
    }
  }
  result.ok = true;
  return result;
}

/// Power of a partial over the variance of its amplitude with the poles known, best block.
double signal_to_noise(const GroupFit& fit, std::size_t index) {
  const auto at = static_cast<Eigen::Index>(2 * index);
  double best = 0;
  for (std::size_t b = 0; b < fit.band.blocks.size(); ++b) {
    const double power = fit.fit.linear.coefficients[b].segment(at, 2).squaredNorm();
    best = std::max(best, power / fit.spread.amplitudes_held[b].block<2, 2>(at, at).trace());
  }
  return best;
}

/// One group's joint fit; the others stay as they are.
void polish_group(const RingData& data, const std::vector<FittedPartial>& all,
                  const std::vector<std::size_t>& group, const TailNoise* noise,
                  std::vector<FittedPartial>& result) {
  double window = 0, centre = 0;
  std::vector<RingPartial> others;
  std::vector<Pole> poles;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (std::find(group.begin(), group.end(), i) == group.end()) others.push_back(all[i].ring);
  }
  for (const std::size_t i : group) {
    poles.push_back(all[i].ring.pole);
    window = std::max(window, window_of(poles.back(), data));
    centre += poles.back().frequency_hz / static_cast<double>(group.size());
  }
  GroupFit best = fit_group(data, poles, others, window, 0);
  const GroupFit early = best;
  Eigen::Index best_offset = 0;
  if (noise != nullptr && (!best.ok || best.variance > kDisturbed * noise->at(centre))) {
    // Something other than free ringing in the first part (a second touch, a rattle)? A later start that is
    // much surer of the strongest partial says so.
    for (const double part : {0.08, 0.16, 0.3, 0.45}) {
      const auto later = static_cast<Eigen::Index>(part * window * data.sample_rate_hz());
      GroupFit late = fit_group(data, poles, others, window, later);
      const bool complete = late.ok && (!best.ok || late.band.blocks.size() >= best.band.blocks.size());
      if (!complete || !(late.strongest_std_hz < best.strongest_std_hz / (best_offset == 0 ? kSurer : 1.0)))
        continue;
      // Its poles must tell the whole story nearly as well: a pitch that glides is not a disturbance.
      const SubBand whole = data.sub_band(
          late.band.blocks.front().frequency_hz(0),
          late.band.blocks.front().frequency_hz(late.band.blocks.front().y.size() - 1), window, others);
      RefinedFit held;
      held.poles = late.fit.poles;
      held.linear = linear_fit(whole, held.poles);
      if (early.ok && !(residual_variance(whole, held) <= kSameStory * early.variance)) continue;
      best = std::move(late);
      best_offset = later;
    }
  }
  for (const std::size_t i : group) result[i].amplitude_covariance.clear();  // until a fit is found sound
  if (!best.ok) return;
  std::vector<double> late_snr;
  if (best_offset > 0) {
    // Poles from the undisturbed part, amplitudes from all of it: what rang is what the recording holds.
    for (std::size_t g = 0; g < group.size(); ++g) late_snr.push_back(signal_to_noise(best, g));
    best.band = data.sub_band(best.band.blocks.front().frequency_hz(0),
                              best.band.blocks.front().frequency_hz(best.band.blocks.front().y.size() - 1),
                              window, others);
    best.fit.linear = linear_fit(best.band, best.fit.poles);
    const Eigen::MatrixXd poles_from_late = best.spread.poles;
    best.spread =
        covariance(best.band, best.fit.poles, best.fit.linear, residual_variance(best.band, best.fit));
    if (!best.spread.ok) return;
    best.spread.poles = poles_from_late;
  }
  const auto n_channels = data.channels().size();
  for (std::size_t g = 0; g < group.size(); ++g) {
    FittedPartial& partial = result[group[g]];
    partial.ring.pole = best.fit.poles[g];
    partial.ring.amplitude = amplitudes_of(data, best.band, best.fit.linear, g);
    partial.window_s = best.band.time_scale_s;
    if (noise != nullptr)
      partial.disturbance = (early.ok ? early.variance : best.variance) / (noise->at(centre) + 1e-300);
    const auto at = static_cast<Eigen::Index>(2 * g);
    partial.pole_covariance = best.spread.poles.block<2, 2>(at, at);
    const std::size_t n_blocks = data.segments().size() * n_channels;
    partial.amplitude_covariance.assign(n_blocks, Eigen::Matrix2d::Zero());
    partial.cross_covariance.assign(n_blocks, Eigen::Matrix2d::Zero());
    for (std::size_t b = 0; b < best.band.blocks.size(); ++b) {
      const auto slot = static_cast<std::size_t>(best.band.blocks[b].segment) * n_channels +
                        static_cast<std::size_t>(best.band.blocks[b].channel);
      partial.amplitude_covariance[slot] = best.spread.amplitudes[b].block<2, 2>(at, at);
      partial.cross_covariance[slot] = best.spread.cross[b].block<2, 2>(at, at);
    }
    partial.snr_db =
        10 * std::log10(std::max(late_snr.empty() ? signal_to_noise(best, g) : late_snr[g], 1e-30));
  }
}

/// Groups in two rounds: neighbours see each other's newest state (all at once, overlapping lines can chase
/// each other). Only groups for which wanted(group) holds.
template <typename Wanted>
void polish_groups(const RingData& data, std::vector<FittedPartial>& partials, const TailNoise* noise,
                   Wanted wanted) {
  const auto groups = groups_of(data, partials);
  for (std::size_t parity = 0; parity < 2; ++parity) {
    std::vector<std::size_t> chosen;
    for (std::size_t g = parity; g < groups.size(); g += 2) {
      if (wanted(groups[g])) chosen.push_back(g);
    }
    const std::vector<FittedPartial> before = partials;
    for_each_job(chosen.size(),
                 [&](std::size_t job) { polish_group(data, before, groups[chosen[job]], noise, partials); });
  }
}

/// Fits what is new and the partials whose bands it falls into.
void polish_near(const RingData& data, std::vector<FittedPartial>& partials, std::size_t first_new) {
  const std::vector<FittedPartial> snapshot = partials;
  polish_groups(data, partials, nullptr, [&](const std::vector<std::size_t>& group) {
    for (const std::size_t i : group) {
      if (i >= first_new) return true;
      const Pole& pole = snapshot[i].ring.pole;
      const double reach = kHalfBandCells / window_of(pole, data);
      for (std::size_t j = first_new; j < snapshot.size(); ++j) {
        if (std::abs(snapshot[j].ring.pole.frequency_hz - pole.frequency_hz) < reach) return true;
      }
    }
    return false;
  });
}

std::vector<RingPartial> rings_of(const std::vector<FittedPartial>& partials) {
  std::vector<RingPartial> rings;
  for (const FittedPartial& partial : partials) rings.push_back(partial.ring);
  return rings;
}

}  // namespace

Eigen::VectorXd noise_floor(const Eigen::VectorXd& power, Eigen::Index n_averaged) {
  constexpr double kQuantile = 0.35;
  // Wilson-Hilferty: quantile over mean of a gamma variable with shape n; z(0.35) = -0.3853.
  const double n = static_cast<double>(n_averaged);
  const double to_mean =
      n_averaged == 1 ? -std::log(1 - kQuantile) : std::pow(1 - 1 / (9 * n) - 0.3853 / (3 * std::sqrt(n)), 3);
  const Eigen::Index size = power.size();
  std::vector<double> centres, levels, scratch;
  const Eigen::Index narrowest = std::clamp<Eigen::Index>(size / 8, 4, 64);
  for (Eigen::Index k = 1; k < size;) {
    const Eigen::Index half = std::max(narrowest, k / 12);
    const Eigen::Index from = std::max<Eigen::Index>(1, k - half), to = std::min(size, k + half + 1);
    scratch.assign(power.data() + from, power.data() + to);
    const auto at =
        scratch.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(scratch.size()));
    std::nth_element(scratch.begin(), at, scratch.end());
    centres.push_back(static_cast<double>(k));
    levels.push_back(*at / to_mean);
    k += std::max<Eigen::Index>(1, half / 2);
  }
  Eigen::VectorXd floor(size);
  std::size_t i = 0;
  for (Eigen::Index k = 0; k < size; ++k) {
    const auto x = static_cast<double>(k);
    while (i + 2 < centres.size() && centres[i + 1] < x) ++i;
    if (centres.size() < 2) {
      floor[k] = levels.empty() ? 0.0 : levels.front();
      continue;
    }
    const double t = std::clamp((x - centres[i]) / (centres[i + 1] - centres[i]), 0.0, 1.0);
    floor[k] = (1 - t) * levels[i] + t * levels[i + 1];
  }
  return floor;
}

void polish(const RingData& data, std::vector<FittedPartial>& partials) {
  const TailNoise noise(data);
  polish_groups(data, partials, &noise, [](const std::vector<std::size_t>&) { return true; });
}

std::vector<bool> persistent(const RingData& data, const std::vector<FittedPartial>& partials) {
  std::vector<char> lasts(partials.size(), 1);
  const auto groups = groups_of(data, partials);
  for_each_job(groups.size(), [&](std::size_t g) {
    const auto& group = groups[g];
    std::vector<RingPartial> others;
    std::vector<Pole> poles;
    double low = 1e300, high = 0, window = 0;
    for (std::size_t i = 0; i < partials.size(); ++i) {
      if (std::find(group.begin(), group.end(), i) == group.end()) others.push_back(partials[i].ring);
    }
    for (const std::size_t i : group) {
      poles.push_back(partials[i].ring.pole);
      low = std::min(low, poles.back().frequency_hz);
      high = std::max(high, poles.back().frequency_hz);
      window = std::max(window, window_of(poles.back(), data));
    }
    const double half = kHalfBandCells / window;
    for (std::size_t member = 0; member < group.size(); ++member) {
      const RingPartial& ring = partials[group[member]].ring;
      const double later_s =
          std::min(1 / std::max(ring.pole.decay_per_s, 1e-9), 0.4 * data.longest_segment_s());
      const auto offset = static_cast<Eigen::Index>(later_s * data.sample_rate_hz());
      const SubBand band = data.sub_band(low - half, high + half, window, others, offset);
      if (band.blocks.empty()) continue;
      RefinedFit held;
      held.poles = poles;
      held.linear = linear_fit(band, poles);
      const double variance = residual_variance(band, held);
      const FitCovariance spread = covariance(band, poles, held.linear, variance);
      if (!spread.ok) continue;
      const Complex step = std::exp(Complex(-ring.pole.decay_per_s, 2 * kPi * ring.pole.frequency_hz) *
                                    (static_cast<double>(offset) / data.sample_rate_hz()));
      const auto at = static_cast<Eigen::Index>(2 * member);
      double expected = 0, missed = 0, noise = 0;
      for (std::size_t b = 0; b < band.blocks.size(); ++b) {
        const Complex predicted = ring.amplitude(band.blocks[b].segment, band.blocks[b].channel) * step;
        const Complex seen(held.linear.coefficients[b][at], held.linear.coefficients[b][at + 1]);
        expected += std::norm(predicted);
        missed += std::norm(seen - predicted);
        noise += spread.amplitudes_held[b].block<2, 2>(at, at).trace();
      }
      bool strongest = true;
      for (const std::size_t i : group)
        strongest = strongest && partials[i].ring.amplitude.norm() <= ring.amplitude.norm();
      if (!strongest && expected > kForeseeable * noise && missed > kLost * kLost * expected)
        lasts[group[member]] = 0;
    }
  });
  return {lasts.begin(), lasts.end()};
}

std::vector<FittedPartial> search_partials(const RingData& data, const SearchOptions& options,
                                           Monitor& monitor) {
  std::vector<FittedPartial> found;
  std::vector<double> windows;
  const TailNoise noise(data);
  const double shortest = std::max(kShortestWindowS, 64 / data.sample_rate_hz());
  for (double w = data.longest_segment_s(); w >= shortest || windows.empty(); w /= 3) windows.push_back(w);
  for (std::size_t scale = 0; scale < windows.size(); ++scale) {
    monitor.throw_if_stopped();
    const PeakSpectrum spectrum = find_peaks(data, windows[scale], rings_of(found), options);
    const auto clusters = clusters_of(spectrum);
    std::vector<std::vector<FittedPartial>> fresh(clusters.size());
    const auto job = [&](std::size_t c) {
      const double centre = 0.5 * (clusters[c].low_hz + clusters[c].high_hz);
      fresh[c] = explore(data, clusters[c], spectrum.window_s, found, noise.at(centre));
    };
    for_each_job(clusters.size(), job, "partials", monitor);
    const std::size_t first_new = found.size();
    for (auto& list : fresh) {
      for (FittedPartial& partial : list) found.push_back(std::move(partial));
    }
    if (found.size() > first_new) polish_near(data, found, first_new);
    monitor.progress("ringdown", static_cast<double>(scale + 1) / static_cast<double>(windows.size()));
  }
  return found;
}

}  // namespace klang::fit::detail
