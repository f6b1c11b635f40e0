#include "core/sound/stage/partials_voice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/nyquist.hpp"

namespace klang::stage {
namespace {

constexpr double kInaudibleNeper = 60.0;  // also keeps the samples clear of denormal numbers, which are slow
constexpr Eigen::Index kLanes = 8;        // samples in a row, each with its own state: independent products

void add_partial(const Partial& partial, double sample_rate_hz, Eigen::VectorXd& sound) {
  const Eigen::Index n = sound.size();
  double* out = sound.data();
  const std::complex<double> rate(-partial.decay_per_s / sample_rate_hz,
                                  2.0 * kPi * partial.frequency_hz / sample_rate_hz);
  const std::complex<double> step = std::exp(rate * static_cast<double>(kLanes));
  std::array<double, kLanes> re{}, im{};
  for (Eigen::Index i = 0; i < kLanes; ++i) {
    const std::complex<double> state = partial.amplitude * std::exp(rate * static_cast<double>(i));
    re[static_cast<std::size_t>(i)] = state.real();
    im[static_cast<std::size_t>(i)] = state.imag();
  }
  const double end = kInaudibleNeper * sample_rate_hz / std::max(partial.decay_per_s, 1e-300);
  const auto last = static_cast<Eigen::Index>(std::min(end, static_cast<double>(n)));
  const double a = step.real(), b = step.imag();
  for (Eigen::Index start = 0; start < last; start += kLanes) {
    const Eigen::Index count = std::min(kLanes, n - start);
    for (Eigen::Index i = 0; i < count; ++i) out[start + i] += im[static_cast<std::size_t>(i)];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double x = re[i] * a - im[i] * b;
      im[i] = re[i] * b + im[i] * a;
      re[i] = x;
    }
  }
}

}  // namespace

void PartialsVoice::add_to(Mix& mix, const events::EventLog&, const Listener&, Monitor&) {
  Eigen::VectorXd sound = Eigen::VectorXd::Zero(mix.known_frames());
  for (const Partial& partial : partials_) {
    if (partial.frequency_hz < audio::highest_compared_hz(mix.sample_rate_hz()))
      add_partial(partial, mix.sample_rate_hz(), sound);
  }
  for (int c = 0; c < mix.n_channels(); ++c) mix.add(c, 0, {sound.data(), static_cast<std::size_t>(sound.size())});
}

}  // namespace klang::stage
