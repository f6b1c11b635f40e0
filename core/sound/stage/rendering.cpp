#include "core/sound/stage/rendering.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::stage {

Mix::Mix(int n_channels, const RenderOptions& options)
    : options_(options), channels_(static_cast<std::size_t>(n_channels)) {
  if (!options.duration_s) return;
  n_frames_ = static_cast<Eigen::Index>(std::llround(*options.duration_s * options.sample_rate_hz));
  for (auto& channel : channels_) channel.assign(static_cast<std::size_t>(*n_frames_), 0.0);
}

Eigen::Index Mix::known_frames() const {
  if (!n_frames_) throw InputError("render", "duration_s is missing, and a voice does not know its end");
  return *n_frames_;
}

void Mix::add(int channel, std::int64_t first_frame, std::span<const double> samples) {
  std::vector<double>& to = channels_[static_cast<std::size_t>(channel)];
  const auto n = static_cast<std::int64_t>(samples.size());
  if (!n_frames_ && first_frame + n > static_cast<std::int64_t>(to.size()))
    to.resize(static_cast<std::size_t>(first_frame + n), 0.0);
  const std::int64_t begin = std::max<std::int64_t>(0, -first_frame);
  const std::int64_t end = std::min(n, static_cast<std::int64_t>(to.size()) - first_frame);
  for (std::int64_t i = begin; i < end; ++i)
    to[static_cast<std::size_t>(first_frame + i)] += samples[static_cast<std::size_t>(i)];
}

Eigen::MatrixXd Mix::samples() const {
  std::size_t longest = 0;
  for (const auto& channel : channels_) longest = std::max(longest, channel.size());
  Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(longest), n_channels());
  for (int c = 0; c < n_channels(); ++c) {
    const auto& channel = channels_[static_cast<std::size_t>(c)];
    std::copy(channel.begin(), channel.end(), samples.col(c).data());
  }
  return samples;
}

audio::Signal render(const events::EventLog& log, std::span<Voice* const> voices, const Listener& listener,
                     const RenderOptions& options, Monitor& monitor) {
  validate_fields("render", options);
  listener.validate();
  log.validate();
  Mix mix(listener.n_channels(), options);
  for (Voice* voice : voices) {
    monitor.throw_if_stopped();
    voice->add_to(mix, log, listener, monitor);
  }
  return {mix.samples(), options.sample_rate_hz, "synthesis"};
}

}  // namespace klang::stage
