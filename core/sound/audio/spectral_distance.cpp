#include "core/sound/audio/spectral_distance.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/audio/resample.hpp"
#include "core/sound/audio/stft.hpp"

namespace klang::audio {
namespace {

constexpr const char* kPlace = "spectral distance";
// libsamplerate passes up to 0.48 of the lower rate; the transition is left out.

double mel(double frequency_hz) { return 2595.0 * std::log10(1.0 + frequency_hz / 700.0); }

Signal at_rate(const Signal& signal, double sample_rate_hz) {
  return signal.sample_rate_hz == sample_rate_hz ? signal : resample(signal, sample_rate_hz);
}

void extend(Signal& signal, Eigen::Index n_frames) {
  const Eigen::Index before = signal.n_frames();
  signal.samples.conservativeResize(n_frames, Eigen::NoChange);
  signal.samples.bottomRows(n_frames - before).setZero();
}

/// Sums power by triangles of even width on the mel scale.
Eigen::MatrixXf mel_power(const Eigen::MatrixXf& bins, const std::vector<double>& frequencies_hz, const Band& band,
                          int n_mel) {
  const double low = mel(band.low_hz), step = (mel(band.high_hz) - low) / (n_mel + 1);
  Eigen::VectorXd position(bins.rows());  // band m has its tip at m + 1
  for (Eigen::Index k = 0; k < bins.rows(); ++k)
    position[k] = (mel(frequencies_hz[static_cast<std::size_t>(k)]) - low) / step;
  Eigen::MatrixXf result = Eigen::MatrixXf::Zero(n_mel, bins.cols());
  for (Eigen::Index m = 0; m < n_mel; ++m) {
    const auto first = std::upper_bound(position.begin(), position.end(), static_cast<double>(m)) - position.begin();
    const auto count =
        std::lower_bound(position.begin(), position.end(), static_cast<double>(m + 2)) - position.begin() - first;
    if (count < 1) continue;
    const Eigen::VectorXf weights =
        (1.0 - (position.segment(first, count).array() - static_cast<double>(m + 1)).abs()).cast<float>();
    for (Eigen::Index t = 0; t < bins.cols(); ++t) result(m, t) = weights.dot(bins.col(t).segment(first, count));
  }
  return result;
}

struct FrameDistance {
  double mean_db = 0.0;
  int n_frames = 0;
};

/// Mean over the columns with anything above the floor of the rms level difference.
FrameDistance frame_distance(const Eigen::MatrixXf& reference, const Eigen::MatrixXf& sound, float gain_sq,
                             double floor_db) {
  const float floor = reference.maxCoeff() * static_cast<float>(std::pow(10.0, 0.1 * floor_db));
  FrameDistance result;
  double sum = 0.0;
  for (Eigen::Index t = 0; t < reference.cols(); ++t) {
    if (!(std::max(reference.col(t).maxCoeff(), gain_sq * sound.col(t).maxCoeff()) > floor)) continue;
    const Eigen::ArrayXf ratio = (gain_sq * sound.col(t).array()).max(floor) / reference.col(t).array().max(floor);
    sum += std::sqrt((10.0f * ratio.log10()).square().cast<double>().mean());
    ++result.n_frames;
  }
  result.mean_db = sum / std::max(result.n_frames, 1);
  return result;
}

}  // namespace

void SpectralDistanceOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e9)));
  throw_violations("spectral distance", std::move(violations));
}

FramePowers frame_powers(const Signal& signal, const Band& band, const SpectralDistanceOptions& options) {
  StftOptions frames;
  frames.window_s = options.window_s;
  frames.hop_s = options.window_s / 4.0;
  const Stft power = stft(signal, frames);
  const std::vector<double>& f = power.frequencies_hz;
  const auto first = std::lower_bound(f.begin(), f.end(), band.low_hz);
  const auto count = std::upper_bound(f.begin(), f.end(), band.high_hz) - first;
  if (count < 1)
    throw InputError(kPlace, "the band holds no bin of the window", to_text(options.window_s), "a longer window_s");
  FramePowers result;
  result.bins = power.power.middleRows(first - f.begin(), count);
  result.mel = mel_power(result.bins, {first, first + count}, band, options.n_mel);
  return result;
}

BandEnergies band_energies(const Signal& signal, const Band& band) {
  const EnergySpectrum energy(signal);
  BandEnergies result;
  result.band = band;
  result.in_band = energy.within(band.low_hz, band.high_hz);
  result.a_weighted = energy.a_weighted(band.low_hz, band.high_hz);
  result.duration_s = energy.duration_s();
  for (const ThirdOctave& third : third_octaves(band)) result.third_octaves.push_back(energy.within(third));
  return result;
}

void compare_frames(const FramePowers& reference, const FramePowers& sound, double gain,
                    const SpectralDistanceOptions& options, SpectralDistance& result) {
  const auto gain_sq = static_cast<float>(gain * gain);
  const FrameDistance bins = frame_distance(reference.bins, sound.bins, gain_sq, options.floor_db);
  result.log_spectral_db = bins.mean_db;
  result.n_frames = bins.n_frames;
  result.mel_db = frame_distance(reference.mel, sound.mel, gain_sq, options.floor_db).mean_db;
}

void compare_energies(const BandEnergies& reference, const BandEnergies& sound, double gain,
                      const SpectralDistanceOptions& options, SpectralDistance& result) {
  const double gain_sq = gain * gain;
  result.band = reference.band;
  result.level_difference_db = 10.0 * std::log10(gain_sq * sound.in_band / reference.in_band);
  result.loudness_difference_db = 10.0 * std::log10(gain_sq * sound.a_weighted / reference.a_weighted);
  const std::vector<ThirdOctave> bands = third_octaves(result.band);
  double loudest = 0.0;
  for (const double energy : reference.third_octaves) loudest = std::max(loudest, energy);
  const double floor = loudest * std::pow(10.0, 0.1 * options.floor_db);
  double sum = 0.0;
  int count = 0;
  result.third_octaves.clear();
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double expected = reference.third_octaves[i], found = gain_sq * sound.third_octaves[i];
    BandDifference difference{bands[i], level_db(expected, reference.duration_s), {}};
    if (std::max(expected, found) > floor) {
      difference.difference_db = 10.0 * std::log10(std::max(found, floor) / std::max(expected, floor));
      sum += *difference.difference_db * *difference.difference_db;
      ++count;
    }
    result.third_octaves.push_back(difference);
  }
  result.third_octave_db = std::sqrt(sum / std::max(count, 1));
}

SpectralDistance spectral_distance(const Signal& reference, const Signal& sound,
                                   const SpectralDistanceOptions& options) {
  options.validate();
  const double rate = std::min(reference.sample_rate_hz, sound.sample_rate_hz);
  const Band band{options.band.low_hz, std::min(options.band.high_hz, highest_compared_hz(rate))};
  if (!(band.low_hz < band.high_hz))
    throw InputError(kPlace, "no common band", to_text(band.low_hz) + " to " + to_text(band.high_hz) + " Hz");
  const BandEnergies expected = band_energies(reference, band), found = band_energies(sound, band);
  if (!(expected.in_band > 0.0)) throw InputError(reference.origin, "silent in the band");
  if (!(found.in_band > 0.0)) throw InputError(sound.origin, "silent in the band");
  const double gain = options.align_level ? std::sqrt(expected.in_band / found.in_band) : 1.0;
  SpectralDistance result;
  compare_energies(expected, found, gain, options, result);
  result.level_difference_db = 10.0 * std::log10(found.in_band / expected.in_band);  // before any alignment

  Signal a = at_rate(reference, rate), b = at_rate(sound, rate);
  const Eigen::Index n_frames = std::max(a.n_frames(), b.n_frames());
  extend(a, n_frames);
  extend(b, n_frames);
  compare_frames(frame_powers(a, band, options), frame_powers(b, band, options), gain, options, result);
  return result;
}

}  // namespace klang::audio
