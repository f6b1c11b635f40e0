#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/audio/signal.hpp"

/// Struck objects that do not exist, and recordings of them: what regression is tried on.
namespace klang::tests {

struct RingingPartial {
  double frequency_hz = 0.0, decay_per_s = 0.0, amplitude = 0.0, phase_rad = 0.0;
};
using RingingObject = std::vector<RingingPartial>;

/// Six to ten partials from about 250 Hz to 7 kHz, at least a semitone apart; decays of 3 per s rising to 10 to 40 per s, each off by
/// up to 30 %; levels falling by up to 25 dB at random; the loudest has amplitude 0.25.
inline RingingObject random_object(RandomStream& random) {
  const int n = 6 + static_cast<int>(random.below(5));
  const double top_decay = random.uniform(10.0, 40.0);
  RingingObject object;
  for (int i = 0; i < n; ++i) {
    const double place = (i + random.uniform(0.15, 0.85)) / n;
    RingingPartial p;
    p.frequency_hz = 250.0 * std::pow(28.0, place);
    p.decay_per_s = (3.0 + (top_decay - 3.0) * place * place) * random.uniform(0.7, 1.3);
    p.amplitude = std::pow(10.0, -random.uniform(0.0, 25.0) / 20.0);
    p.phase_rad = random.uniform(-kPi, kPi);
    object.push_back(p);
  }
  double loudest = 0.0;
  for (const RingingPartial& p : object) loudest = std::max(loudest, p.amplitude);
  for (RingingPartial& p : object) p.amplitude *= 0.25 / loudest;
  return object;
}

struct Take {
  double sample_rate_hz = 22050.0;
  double duration_s = 1.2;
  double onset_s = 0.1;
  double gain = 1.0;
  double snr_db = 40.0;  ///< of the loudest partial at the strike (amplitude / sqrt 2) over the noise's rms
};

/// The object struck at onset_s in white noise.
inline audio::Signal recorded(const RingingObject& object, const Take& take, RandomStream& random) {
  audio::Signal signal{{}, take.sample_rate_hz, "synthetic"};
  signal.samples.resize(static_cast<Eigen::Index>(take.duration_s * take.sample_rate_hz), 1);
  double loudest = 0.0;
  for (const RingingPartial& p : object) loudest = std::max(loudest, p.amplitude);
  const double noise_rms = loudest / std::sqrt(2.0) * std::pow(10.0, -take.snr_db / 20.0);
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i) / take.sample_rate_hz - take.onset_s;
    double x = noise_rms * random.normal();
    if (t >= 0.0) {
      for (const RingingPartial& p : object) {
        x += p.amplitude * std::exp(-p.decay_per_s * t) * std::cos(2 * kPi * p.frequency_hz * t + p.phase_rad);
      }
    }
    signal.samples(i, 0) = take.gain * x;
  }
  return signal;
}

/// A take with a level, onset and noise of its own.
inline Take random_take(double snr_db, RandomStream& random) {
  Take take;
  take.snr_db = snr_db;
  take.onset_s = random.uniform(0.02, 0.2);
  take.gain = std::pow(10.0, random.uniform(-12.0, 6.0) / 20.0);
  return take;
}

}  // namespace klang::tests
