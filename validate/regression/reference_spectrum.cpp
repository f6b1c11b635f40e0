#include "validate/regression/reference_spectrum.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "validate/regression/detail/partial_pairs.hpp"
#include "validate/regression/detail/scales.hpp"
#include "validate/regression/detail/take_scatter.hpp"

namespace klang::validate {
namespace {

constexpr double kQuietestDb = -200.0;
constexpr double kThirdsPerDegree = 3.0;  // neighbouring bands share their partials, and so their scatter

using detail::Samples;

double to_db(double power) { return std::max(kQuietestDb, 10.0 * std::log10(std::max(power, 1e-30))); }

struct Mean {
  double value = 0.0, std = 0.0;
};
Mean weighted_mean(const Samples& samples, double scatter) {
  Mean mean;
  double weights = 0.0;
  for (std::size_t i = 0; i < samples.value.size(); ++i) {
    const double weight = 1.0 / std::max(samples.std[i] * samples.std[i] + scatter * scatter, 1e-30);
    weights += weight;
    mean.value += weight * samples.value[i];
  }
  mean.value /= weights;
  mean.std = 1.0 / std::sqrt(weights);
  return mean;
}

/// One partial over the takes: logarithms of frequency, decay and amplitude, so that deviations are relative.
struct Track {
  Samples frequency, decay, amplitude;

  void add(const fit::Partial& p, double gain_db, std::size_t take) {
    frequency.add(std::log(p.frequency_hz), p.frequency_std_hz.value_or(0.0) / p.frequency_hz, take);
    if (p.decay_per_s && *p.decay_per_s > 0.0)
      decay.add(std::log(*p.decay_per_s), p.decay_std_per_s.value_or(0.0) / *p.decay_per_s, take);
    if (p.amplitude && *p.amplitude > 0.0)
      amplitude.add(std::log(*p.amplitude) - gain_db * std::log(10.0) / 20.0,
                    p.amplitude_std.value_or(0.0) / *p.amplitude, take);
  }
};

template <class Member>
detail::Scatter scatter_of(const std::vector<Track>& tracks, Member member) {
  std::vector<Samples> samples;
  for (const Track& track : tracks) samples.push_back(track.*member);
  return detail::moderated_scatter(samples);
}

fit::Partial mean_partial(const Track& track, double frequency_scatter, double decay_scatter) {
  fit::Partial p;
  const Mean f = weighted_mean(track.frequency, frequency_scatter);
  p.frequency_hz = std::exp(f.value);
  p.frequency_std_hz = p.frequency_hz * f.std;
  if (!track.decay.value.empty()) {
    const Mean d = weighted_mean(track.decay, decay_scatter);
    p.decay_per_s = std::exp(d.value);
    p.decay_std_per_s = *p.decay_per_s * d.std;
  }
  if (!track.amplitude.value.empty()) {
    const double scatter = std::sqrt(std::max(0.0, track.amplitude.variance() - track.amplitude.own_variance()));
    const Mean a = weighted_mean(track.amplitude, scatter);
    p.amplitude = std::exp(a.value);
    p.amplitude_std = *p.amplitude * a.std;
  }
  return p;
}

/// Takes' powers at the first one's level, cut to what all have.
void merge_fingerprints(const std::vector<SoundDescription>& takes, const std::vector<double>& gain_db,
                        ReferenceSpectrum& result) {
  Eigen::Index n_bands = takes[0].fingerprint.power.rows(), n_frames = takes[0].fingerprint.power.cols();
  for (const SoundDescription& take : takes) {
    n_bands = std::min(n_bands, take.fingerprint.power.rows());
    n_frames = std::min(n_frames, take.fingerprint.power.cols());
  }
  Fingerprint& mean = result.fingerprint = takes[0].fingerprint;
  mean.power = Eigen::MatrixXf::Zero(n_bands, n_frames);
  mean.noise = Eigen::VectorXf::Zero(n_bands);
  const auto n = static_cast<float>(takes.size());
  std::vector<Eigen::MatrixXf> aligned;
  for (std::size_t k = 0; k < takes.size(); ++k) {
    const auto scale = static_cast<float>(std::pow(10.0, -0.1 * gain_db[k]));
    aligned.push_back(scale * takes[k].fingerprint.power.topLeftCorner(n_bands, n_frames));
    mean.power += aligned.back() / n;
    mean.noise = mean.noise.cwiseMax(scale * takes[k].fingerprint.noise.head(n_bands));
  }
  result.third_scatter_db.assign(static_cast<std::size_t>(mean.n_thirds()), 0.0);
  if (takes.size() < 2) return;
  std::vector<Samples> levels;
  std::vector<std::size_t> bands;
  float loudest_third = 0.0f;
  for (Eigen::Index i = 0; i < mean.n_thirds(); ++i)
    loudest_third = std::max(loudest_third, mean.power.middleRows(4 * i, 4).sum());
  for (Eigen::Index i = 0; i < mean.n_thirds(); ++i) {
    if (!(mean.power.middleRows(4 * i, 4).sum() > static_cast<float>(detail::kLevelRange) * loudest_third)) continue;
    levels.emplace_back();
    bands.push_back(static_cast<std::size_t>(i));
    for (std::size_t k = 0; k < takes.size(); ++k)
      levels.back().add(
          to_db(static_cast<double>(aligned[k].middleRows(4 * i, 4).sum()) / static_cast<double>(n_frames)), 0.0, k);
  }
  const detail::Scatter scatter = detail::moderated_scatter(levels);
  for (std::size_t i = 0; i < bands.size(); ++i) result.third_scatter_db[bands[i]] = scatter.std[i];
  const double together = static_cast<double>(bands.size()) / kThirdsPerDegree;
  result.level_scatter_dof = std::min(scatter.dof, std::max(1.0, together) * static_cast<double>(takes.size() - 1));
  const float loudest = mean.power.maxCoeff();
  double sum = 0.0, count = 0.0;
  for (const Eigen::MatrixXf& take : aligned) {
    for (Eigen::Index t = 0; t < n_frames; ++t) {
      for (Eigen::Index i = 0; i < n_bands; ++i) {
        const float floor = std::max(1e-5f * loudest, 16.0f * mean.noise[i]);
        if (!(mean.power(i, t) > floor)) continue;
        const double difference = 10.0 * std::log10(std::max(take(i, t), floor) / mean.power(i, t));
        sum += difference * difference;
        ++count;
      }
    }
  }
  if (count > 0.0) result.spectrum_scatter_db = std::sqrt(sum / count);
}

}  // namespace

std::vector<fit::Partial> ReferenceSpectrum::table() const {
  std::vector<fit::Partial> list;
  for (const ReferencePartial& p : partials) list.push_back(p.partial);
  return list;
}

ReferenceSpectrum make_reference(const std::vector<SoundDescription>& takes) {
  if (takes.empty()) throw InputError("reference", "needs a sound");
  ReferenceSpectrum result;
  result.n_takes = static_cast<int>(takes.size());
  result.sample_rate_hz = takes[0].sample_rate_hz;
  result.duration_s = takes[0].duration_s;
  result.band = takes[0].band;
  for (const SoundDescription& take : takes) {
    result.origin += (result.origin.empty() ? "" : ", ") + take.origin;
    result.sample_rate_hz = std::min(result.sample_rate_hz, take.sample_rate_hz);
    result.duration_s = std::min(result.duration_s, take.duration_s);
    result.contact_s = std::max(result.contact_s, take.contact_s);
    result.band.high_hz = std::min(result.band.high_hz, take.band.high_hz);
    result.band.low_hz = std::max(result.band.low_hz, take.band.low_hz);
  }
  // The take with the most partials gathers the others'; levels are the first take's.
  std::size_t base = 0;
  for (std::size_t k = 1; k < takes.size(); ++k) {
    if (takes[k].partials.partials.size() > takes[base].partials.partials.size()) base = k;
  }
  const std::vector<fit::Partial>& gathering = takes[base].partials.partials;
  std::vector<double> gain_db(takes.size(), 0.0);  // over the base, then over the first
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> pairs(takes.size());
  std::vector<double> loners_hz;
  for (std::size_t k = 0; k < takes.size(); ++k) {
    const detail::Pairing found = detail::pairing(gathering, takes[k].partials.partials);
    gain_db[k] = found.gain.db;
    pairs[k] = found.pairs;
    std::vector<bool> taken(takes[k].partials.partials.size(), false);
    for (const auto& [i, j] : found.pairs) taken[j] = true;
    for (std::size_t j = 0; j < taken.size(); ++j) {
      if (!taken[j]) loners_hz.push_back(takes[k].partials.partials[j].frequency_hz);
    }
  }
  const double first_db = gain_db[0];
  for (double& g : gain_db) g -= first_db;

  std::vector<Track> tracks(gathering.size());
  for (std::size_t k = 0; k < takes.size(); ++k) {
    for (const auto& [i, j] : pairs[k]) tracks[i].add(takes[k].partials.partials[j], gain_db[k], k);
  }
  std::vector<Track> kept;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (2 * tracks[i].frequency.value.size() > takes.size()) {
      kept.push_back(std::move(tracks[i]));
    } else {
      loners_hz.push_back(gathering[i].frequency_hz);
    }
  }
  if (kept.empty()) throw InputError(result.origin, "no partial is in more than half of the takes");
  std::sort(loners_hz.begin(), loners_hz.end());
  result.occasional_hz = std::move(loners_hz);
  const detail::Scatter frequency = scatter_of(kept, &Track::frequency), decay = scatter_of(kept, &Track::decay);
  result.scatter_dof = frequency.dof;
  result.decay_scatter_dof = decay.dof;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ReferencePartial p;
    p.partial = mean_partial(kept[i], frequency.std[i], decay.std[i]);
    p.frequency_scatter_cents = frequency.std[i] * detail::kCentsPerNeper;
    p.decay_scatter = decay.std[i];
    p.n_takes = static_cast<int>(kept[i].frequency.value.size());
    result.partials.push_back(p);
  }
  std::vector<Samples> frequencies;
  for (const Track& track : kept) frequencies.push_back(track.frequency);
  result.common_scatter_cents = detail::common_scatter(frequencies, takes.size()) * detail::kCentsPerNeper;
  std::sort(result.partials.begin(), result.partials.end(), [](const ReferencePartial& a, const ReferencePartial& b) {
    return a.partial.frequency_hz < b.partial.frequency_hz;
  });
  merge_fingerprints(takes, gain_db, result);
  result.ring_10db_s = ring_10db_s(result.table());
  return result;
}

}  // namespace klang::validate
