#include "fit/ringdown/detail/partial_search.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/sound/audio/fft.hpp"
#include "fit/ringdown/detail/esprit.hpp"
#include "fit/ringdown/detail/partial_parts.hpp"

namespace klang::fit::detail {
namespace {

using Complex = std::complex<double>;

constexpr double kLogFalseAlarm = 14;  ///< -ln of the chance that one test invents a partial
constexpr Eigen::Index kMaxOrder = 14;
constexpr double kNoiseLikeResidual = 3.0;    ///< residual over noise up to which only significance counts
constexpr int kPeaksAtOnce = 400;             ///< of one window length, at least
constexpr double kOwnCells = 2.5;             ///< around a line, where its own energy is
constexpr double kOwnReduction = 3.0;         ///< times kWorthwhileReduction there
constexpr double kWorthwhileReduction = 3.0;  ///< of the residual, a partial, above that

/// Smallest x with P(chi-square(dof) > x) below exp(-log_p) (Laurent and Massart 2000, Lemma 1).
double chi_square_bound(double dof, double log_p) { return dof + 2 * std::sqrt(dof * log_p) + 2 * log_p; }

struct Peak {
  double frequency_hz = 0.0;
  double excess = 0.0;  ///< power over noise
};

struct PeakSpectrum {
  std::vector<Peak> peaks;
  double window_s = 0.0;
};

/// Peaks of the residual's spectrum in windows of about window_s from the beginning of each segment.
PeakSpectrum find_peaks(const RingData& data, double window_s, const std::vector<RingPartial>& found,
                        const std::vector<double>& tried_hz, const SearchOptions& options, double repeats) {
  PeakSpectrum result;
  const auto wanted = static_cast<Eigen::Index>(window_s * data.sample_rate_hz() + 0.5);
  std::vector<Eigen::Index> usable;
  for (std::size_t s = 0; s < data.segments().size(); ++s) {
    if (data.segments()[s].end - data.segments()[s].begin >= wanted) usable.push_back(static_cast<Eigen::Index>(s));
  }
  Eigen::Index n = audio::good_fft_size_below(std::max<Eigen::Index>(wanted, 16));
  if (usable.empty()) {
    usable.push_back(data.longest_segment());
    const Segment& s = data.segments()[static_cast<std::size_t>(usable.front())];
    n = audio::good_fft_size_below(std::min(n, s.end - s.begin));
  }
  const auto n_channels = static_cast<Eigen::Index>(data.channels().size());
  const Eigen::VectorXd window = blackman_harris(n);
  std::vector<Eigen::VectorXd> powers(static_cast<std::size_t>(static_cast<Eigen::Index>(usable.size()) * n_channels));
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
  const double count = std::max(1.0, static_cast<double>(powers.size()) / repeats);  // that are independent
  excess /= static_cast<double>(powers.size());
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
    const double f = static_cast<double>(k) * per_bin;
    if (std::any_of(tried_hz.begin(), tried_hz.end(), [&](double tried) { return std::abs(tried - f) < 4 * per_bin; }))
      continue;
    result.peaks.push_back({f, excess[k]});
  }
  const auto most = static_cast<std::size_t>(std::max(kPeaksAtOnce, options.max_partials));
  if (result.peaks.size() > most) {
    std::nth_element(result.peaks.begin(), result.peaks.begin() + static_cast<std::ptrdiff_t>(most), result.peaks.end(),
                     [](const Peak& a, const Peak& b) { return a.excess > b.excess; });
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
      const double faster = std::max(pole.decay_per_s, fit.poles[j].decay_per_s);
      if (std::min(pole.decay_per_s, fit.poles[j].decay_per_s) < kOutlasts * faster) continue;  // two stages
      const double width = faster / (2 * kPi);
      if (apart < std::max(0.1 * width, 0.02 * cell)) return false;
    }
  }
  return true;
}

/// @param repeats blocks that say the same (TailNoise::repeats)
double significance_bound(const SubBand& band, double repeats) {
  const double added = 2 + 2 * static_cast<double>(band.blocks.size()) / repeats;
  return chi_square_bound(added, kLogFalseAlarm);
}

/// Twice the log-likelihood ratio of two nested fits with unknown noise, in the scale of a chi-square.
double likelihood_gain(const SubBand& band, const LinearFit& small, const LinearFit& large, std::size_t large_order) {
  const double used =
      static_cast<double>(2 * large_order) +
      static_cast<double>(band.blocks.size()) * static_cast<double>(2 * large_order + 2 * kBackgroundTerms);
  const double freedom = std::max(1.0, static_cast<double>(band.n_real_data()) - used);
  return (small.residual_sum_sq - large.residual_sum_sq) / (large.residual_sum_sq / freedom + 1e-300);
}

/// What a fit leaves within kOwnCells cells of a frequency.
double left_near(const SubBand& band, const LinearFit& fit, double frequency_hz) {
  double sum = 0;
  for (std::size_t b = 0; b < band.blocks.size(); ++b) {
    for (Eigen::Index k = 0; k < band.blocks[b].y.size(); ++k) {
      const double apart = std::abs(band.blocks[b].frequency_hz(k) - frequency_hz);
      if (apart <= kOwnCells / band.time_scale_s) sum += std::norm(fit.residuals[b][k]);
    }
  }
  return sum;
}

/// Real partials are not exactly exponential, and every exponential more mends a little of what is left:
/// significant against the noise, but no partial. While the residual stands above the noise, one more must
/// remove most of it: of all, or, where many lines are left, of what stands where it is.
bool worthwhile(const SubBand& band, const RefinedFit& small, const RefinedFit& large, double noise_variance) {
  const double left = residual_variance(band, large);
  if (left <= kNoiseLikeResidual * noise_variance) return true;
  const auto added = static_cast<double>(large.poles.size() - small.poles.size());
  const double reduction = std::pow(kWorthwhileReduction, added);
  if (small.linear.residual_sum_sq >= reduction * large.linear.residual_sum_sq) return true;
  return std::any_of(large.poles.begin(), large.poles.end(), [&](const Pole& pole) {
    return left_near(band, small.linear, pole.frequency_hz) >=
           kOwnReduction * reduction * left_near(band, large.linear, pole.frequency_hz);
  });
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
    const bool near =
        !clusters.empty() && peak.frequency_hz - clusters.back().high_hz < 10 * cell && clusters.back().n_peaks < 6;
    if (!near) clusters.push_back({peak.frequency_hz, peak.frequency_hz, 0, 0, 0});
    clusters.back().high_hz = peak.frequency_hz;
    ++clusters.back().n_peaks;
  }
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    clusters[i].own_low_hz = clusters[i].low_hz - 6 * cell;
    clusters[i].own_high_hz = clusters[i].high_hz + 6 * cell;
    if (i > 0)
      clusters[i].own_low_hz = std::max(clusters[i].own_low_hz, 0.5 * (clusters[i - 1].high_hz + clusters[i].low_hz));
    if (i + 1 < clusters.size()) {
      clusters[i].own_high_hz = std::min(clusters[i].own_high_hz, 0.5 * (clusters[i].high_hz + clusters[i + 1].low_hz));
    }
  }
  return clusters;
}

/// New partials of one cluster; known ones of similar decay near it are fitted along and dropped afterwards.
std::vector<FittedPartial> explore(const RingData& data, const Cluster& cluster, double window_s,
                                   const std::vector<FittedPartial>& known, const TailNoise& tail) {
  const double noise = tail.at(0.5 * (cluster.low_hz + cluster.high_hz));
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
  const double bound = tail.repeats() * significance_bound(band, tail.repeats());
  const auto most = std::min<Eigen::Index>(static_cast<Eigen::Index>(n_known) + cluster.n_peaks + 6, kMaxOrder);
  // Two orders are tried beyond the last success: a pair may only pay off together.
  for (Eigen::Index order = static_cast<Eigen::Index>(n_known) + 1, failures = 0; order <= most && failures < 2;
       ++order) {
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
    // What grows within a short window is not carried on into longer ones.
    partial.ring.pole.decay_per_s = std::max(partial.ring.pole.decay_per_s, 0.0);
    partial.ring.amplitude = amplitudes_of(data, band, current.linear, i);
    partial.window_s = band.time_scale_s;
    fresh.push_back(std::move(partial));
  }
  return fresh;
}

std::vector<RingPartial> rings_of(const std::vector<FittedPartial>& partials) {
  std::vector<RingPartial> rings;
  for (const FittedPartial& partial : partials) rings.push_back(partial.ring);
  return rings;
}

}  // namespace

void search_partials(const RingData& data, const SearchOptions& options, const TailNoise& noise,
                     const std::vector<double>& tried_hz, std::vector<FittedPartial>& found, Monitor& monitor) {
  std::vector<double> windows;
  const double shortest = std::max(kShortestWindowS, 64 / data.sample_rate_hz());
  for (double w = data.longest_segment_s(); w >= shortest || windows.empty(); w /= 3) windows.push_back(w);
  for (std::size_t scale = 0; scale < windows.size(); ++scale) {
    monitor.throw_if_stopped();
    const PeakSpectrum spectrum = find_peaks(data, windows[scale], rings_of(found), tried_hz, options, noise.repeats());
    const auto clusters = clusters_of(spectrum);
    std::vector<std::vector<FittedPartial>> fresh(clusters.size());
    const auto job = [&](std::size_t c) { fresh[c] = explore(data, clusters[c], spectrum.window_s, found, noise); };
    for_each_job(clusters.size(), job, "partials", monitor);
    std::vector<double> fresh_hz;
    for (auto& list : fresh) {
      for (FittedPartial& partial : list) {
        fresh_hz.push_back(partial.ring.pole.frequency_hz);
        found.push_back(std::move(partial));
      }
    }
    polish_near(data, found, {}, fresh_hz);
    std::erase_if(found, [](const FittedPartial& partial) { return partial.unresolved; });
    monitor.progress("ringdown", static_cast<double>(scale + 1) / static_cast<double>(windows.size()));
  }
}

}  // namespace klang::fit::detail
