#include "datasets-synthetic/disturbances.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/nyquist.hpp"

namespace klang::datasets {
namespace {

constexpr double kPinkCorner_hz = 20.0;

using Spectrum = std::vector<std::complex<double>>;

// Real transforms of a power-of-two length; Eigen's own FFT, so that the bits depend on nothing outside.
Spectrum spectrum_of(const Eigen::VectorXd& values, std::size_t length) {
  std::vector<double> padded(length, 0.0);
  std::copy(values.data(), values.data() + values.size(), padded.begin());
  Spectrum spectrum;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(spectrum, padded);
  return spectrum;
}

Eigen::VectorXd values_of(const Spectrum& spectrum, std::size_t length, Eigen::Index n) {
  std::vector<double> values;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.inv(values, spectrum, static_cast<Eigen::Index>(length));
  return Eigen::Map<const Eigen::VectorXd>(values.data(), n);
}

}  // namespace

Eigen::VectorXd white_noise(Eigen::Index n, RandomStream& random) {
  Eigen::VectorXd noise(n);
  for (Eigen::Index i = 0; i < n; ++i) noise[i] = random.normal();
  return noise;
}

Eigen::VectorXd pink_noise(Eigen::Index n, double sample_rate_hz, RandomStream& random) {
  if (n == 0) return {};
  const std::size_t length = std::bit_ceil(static_cast<std::size_t>(std::max<Eigen::Index>(n, 2)));
  Spectrum spectrum = spectrum_of(white_noise(static_cast<Eigen::Index>(length), random), length);
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    const double hz = static_cast<double>(k) * sample_rate_hz / static_cast<double>(length);
    spectrum[k] *= std::sqrt(kPinkCorner_hz / std::max(hz, kPinkCorner_hz));
  }
  const Eigen::VectorXd noise = values_of(spectrum, length, n);
  return noise / std::sqrt(noise.squaredNorm() / static_cast<double>(n));
}

Eigen::VectorXd room_tail(const Eigen::VectorXd& sound, double sample_rate_hz, double rt60_s, double level_db,
                          RandomStream& random) {
  const Eigen::Index n = sound.size();
  if (n == 0) return {};
  const auto reach = static_cast<Eigen::Index>(std::ceil(1.5 * rt60_s * sample_rate_hz));  // to -90 dB
  Eigen::VectorXd response = white_noise(std::min(n, reach), random);
  for (Eigen::Index i = 0; i < response.size(); ++i) {
    response[i] *= std::exp(-static_cast<double>(i) / sample_rate_hz * std::log(1000.0) / rt60_s);
  }
  response *= std::pow(10.0, level_db / 20.0) / response.norm();
  const std::size_t length = std::bit_ceil(static_cast<std::size_t>(n + response.size()));
  Spectrum product = spectrum_of(sound, length);
  const Spectrum other = spectrum_of(response, length);
  for (std::size_t k = 0; k < product.size(); ++k) product[k] *= other[k];
  return values_of(product, length, n);
}

Eigen::VectorXd mains_hum(Eigen::Index n, double sample_rate_hz, double frequency_hz, double amplitude, int harmonics,
                          RandomStream& random) {
  Eigen::VectorXd hum = Eigen::VectorXd::Zero(n);
  for (int k = 1; k <= harmonics && k * frequency_hz < audio::highest_rendered_hz(sample_rate_hz); ++k) {
    const double phase = random.uniform(0.0, 2.0 * kPi), omega = 2.0 * kPi * k * frequency_hz;
    for (Eigen::Index i = 0; i < n; ++i) {
      hum[i] += amplitude / k * std::cos(omega * static_cast<double>(i) / sample_rate_hz + phase);
    }
  }
  return hum;
}

}  // namespace klang::datasets
