#include "core/sound/audio/resample.hpp"

#include <samplerate.h>

#include <cmath>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang::audio {

Signal resample(const Signal& signal, double sample_rate_hz) {
  checked_open("resample", "the signal's sample_rate_hz", signal.sample_rate_hz, 0, 1e9);
  checked("resample", "sample_rate_hz", sample_rate_hz, signal.sample_rate_hz / 256, signal.sample_rate_hz * 256);
  if (signal.samples.size() == 0) throw InputError("resample", "the signal has no samples");
  if (!signal.samples.allFinite()) throw InputError("resample", "the signal has samples that are not finite numbers");
  Signal result = signal;
  result.sample_rate_hz = sample_rate_hz;
  if (sample_rate_hz == signal.sample_rate_hz) return result;
  const double ratio = sample_rate_hz / signal.sample_rate_hz;
  const auto n_out = std::max<Eigen::Index>(1, std::llround(static_cast<double>(signal.n_frames()) * ratio));
  result.samples = Eigen::MatrixXd::Zero(n_out, signal.n_channels());
  for (Eigen::Index channel = 0; channel < signal.n_channels(); ++channel) {
    // libsamplerate works in single precision; scaling to the channel's peak keeps quiet channels clean.
    const double peak = signal.samples.col(channel).cwiseAbs().maxCoeff();
    if (!(peak > 0)) continue;
    const Eigen::VectorXf in = (signal.samples.col(channel) / peak).cast<float>();
    Eigen::VectorXf out = Eigen::VectorXf::Zero(n_out + 64);
    SRC_DATA data{};
    data.data_in = in.data();
    data.data_out = out.data();
    data.input_frames = static_cast<long>(in.size());
    data.output_frames = static_cast<long>(out.size());
    data.src_ratio = ratio;
    if (const int error = src_simple(&data, SRC_SINC_BEST_QUALITY, 1); error != 0) {
      throw InputError("resample", src_strerror(error));
    }
    result.samples.col(channel) = out.head(n_out).cast<double>() * peak;
  }
  return result;
}

}  // namespace klang::audio
