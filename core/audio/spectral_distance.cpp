#include "core/audio/spectral_distance.hpp"

#include <algorithm>
#include <cmath>

#include "core/audio/resample.hpp"
#include "core/audio/stft.hpp"
#include "core/base/errors.hpp"

namespace klang::audio {
namespace {

constexpr const char* kPlace = "spectral distance";
// libsamplerate passes up to 0.48 of the lower rate; the transition is left out.
constexpr double kUsableRate = 0.45;

double mel(double frequency_hz) { return 2595.0 * std::log10(1.0 + frequency_hz / 700.0); }

Signal at_rate(const Signal& signal, double sample_rate_hz) {
  return signal.sample_rate_hz == sample_rate_hz ? signal : resample(signal, sample_rate_hz);
}

void extend(Signal& signal, Eigen::Index n_frames) {
  const Eigen::Index before = signal.n_frames();
  signal.samples.conservativeResize(n_frames, Eigen::NoChange);
  signal.samples.bottomRows(n_frames - before).setZero();
}

/// Rows: triangles over the bins.
Eigen::MatrixXf mel_triangles(const std::vector<double>& frequencies_hz, const Band& band, int n_mel) {
  const double low = mel(band.low_hz), step = (mel(band.high_hz) - low) / (n_mel + 1);
  Eigen::MatrixXf weights = Eigen::MatrixXf::Zero(n_mel, static_cast<Eigen::Index>(frequencies_hz.size()));
  for (Eigen::Index k = 0; k < weights.cols(); ++k) {
    const double position = (mel(frequencies_hz[static_cast<std::size_t>(k)]) - low) / step;  // band m has its tip at m + 1
    for (Eigen::Index m = 0; m < n_mel; ++m) {
      weights(m, k) = static_cast<float>(std::max(0.0, 1.0 - std::abs(position - static_cast<double>(m + 1))));
    }
  }
  return weights;
}

struct FrameDistance {
  double mean_db = 0.0;
  int n_frames = 0;
};

/// Mean over the columns with anything above the floor of the rms level difference.
FrameDistance frame_distance(const Eigen::MatrixXf& reference, const Eigen::MatrixXf& sound, double floor_db) {
  const float floor = reference.maxCoeff() * static_cast<float>(std::pow(10.0, 0.1 * floor_db));
  FrameDistance result;
  double sum = 0.0;
  for (Eigen::Index t = 0; t < reference.cols(); ++t) {
    if (!(std::max(reference.col(t).maxCoeff(), sound.col(t).maxCoeff()) > floor)) continue;
    const Eigen::ArrayXf ratio = sound.col(t).array().max(floor) / reference.col(t).array().max(floor);
    sum += std::sqrt((10.0f * ratio.log10()).square().cast<double>().mean());
    ++result.n_frames;
  }
  result.mean_db = sum / std::max(result.n_frames, 1);
  return result;
}

void third_octave_differences(const EnergySpectrum& reference, const EnergySpectrum& sound, double floor_db, double gain_sq,
                              SpectralDistance& result) {
  double loudest = 0.0;
  for (const ThirdOctave& band : third_octaves(result.band)) loudest = std::max(loudest, reference.within(band));
  const double floor = loudest * std::pow(10.0, 0.1 * floor_db);
  double sum = 0.0;
  int count = 0;
  for (const ThirdOctave& band : third_octaves(result.band)) {
    const double expected = reference.within(band), found = gain_sq * sound.within(band);
    BandDifference difference{band, level_db(expected, reference.duration_s()), {}};
    if (std::max(expected, found) > floor) {
      difference.difference_db = 10.0 * std::log10(std::max(found, floor) / std::max(expected, floor));
      sum += *difference.difference_db * *difference.difference_db;
      ++count;
    }
    result.third_octaves.push_back(difference);
  }
  result.third_octave_db = std::sqrt(sum / std::max(count, 1));
}

}  // namespace

void SpectralDistanceOptions::validate() const {
  checked_open(kPlace, "band.low_hz", band.low_hz, 0.0, 1e9);
  checked_open(kPlace, "band.high_hz", band.high_hz, band.low_hz, 1e9);
  checked(kPlace, "window_s", window_s, 0.005, 1.0);
  checked(kPlace, "floor_db", floor_db, -120.0, -10.0);
  checked(kPlace, "n_mel", n_mel, 8, 256);
}

SpectralDistance spectral_distance(const Signal& reference, const Signal& sound, const SpectralDistanceOptions& options) {
  options.validate();
  const EnergySpectrum reference_energy(reference), sound_energy(sound);
  const double rate = std::min(reference.sample_rate_hz, sound.sample_rate_hz);
  SpectralDistance result;
  result.band = {options.band.low_hz, std::min(options.band.high_hz, kUsableRate * rate)};
  if (!(result.band.low_hz < result.band.high_hz)) {
    throw InputError(kPlace, "no common band", to_text(result.band.low_hz) + " to " + to_text(result.band.high_hz) + " Hz");
  }

  const double expected = reference_energy.within(result.band.low_hz, result.band.high_hz);
  const double found = sound_energy.within(result.band.low_hz, result.band.high_hz);
  if (!(expected > 0.0)) throw InputError(reference.origin, "silent in the band");
  if (!(found > 0.0)) throw InputError(sound.origin, "silent in the band");
  result.level_difference_db = 10.0 * std::log10(found / expected);
  const double gain_sq = options.align_level ? expected / found : 1.0;
  result.loudness_difference_db =
      10.0 * std::log10(gain_sq * sound_energy.a_weighted(result.band.low_hz, result.band.high_hz) /
                        reference_energy.a_weighted(result.band.low_hz, result.band.high_hz));
  third_octave_differences(reference_energy, sound_energy, options.floor_db, gain_sq, result);

  Signal a = at_rate(reference, rate), b = at_rate(sound, rate);
  const Eigen::Index n_frames = std::max(a.n_frames(), b.n_frames());
  extend(a, n_frames);
  extend(b, n_frames);
  b.samples *= std::sqrt(gain_sq);
  StftOptions frames;
  frames.window_s = options.window_s;
  frames.hop_s = options.window_s / 4.0;
  const Stft expected_power = stft(a, frames), found_power = stft(b, frames);

  const std::vector<double>& f = expected_power.frequencies_hz;
  const auto first = std::lower_bound(f.begin(), f.end(), result.band.low_hz) - f.begin();
  const auto count = std::upper_bound(f.begin(), f.end(), result.band.high_hz) - f.begin() - first;
  if (count < 1) throw InputError(kPlace, "the band holds no bin of the window", to_text(options.window_s), "a longer window_s");
  const FrameDistance bins = frame_distance(expected_power.power.middleRows(first, count),
                                            found_power.power.middleRows(first, count), options.floor_db);
  result.log_spectral_db = bins.mean_db;
  result.n_frames = bins.n_frames;
  const Eigen::MatrixXf triangles = mel_triangles(f, result.band, options.n_mel);
  result.mel_db = frame_distance(triangles * expected_power.power, triangles * found_power.power, options.floor_db).mean_db;
  return result;
}

}  // namespace klang::audio
