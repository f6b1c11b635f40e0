#pragma once
#include <Eigen/Core>
#include <string>

namespace klang::audio {

/// Sound in memory. Full scale is -1 to 1 whatever the file's sample format.
struct Signal {
  Eigen::MatrixXd samples;      ///< n_frames x n_channels (column-major: a channel is contiguous)
  double sample_rate_hz = 0.0;  ///< > 0
  std::string origin;           ///< file name or recipe, for messages and reports
  /// Of a lossy coder: frames between its transforms (Vorbis 1024, MP3 576, Opus 20 ms); 0 where nothing is known of one.
  Eigen::Index coded_frames = 0;

  Eigen::Index n_frames() const { return samples.rows(); }
  Eigen::Index n_channels() const { return samples.cols(); }
  double duration_s() const { return static_cast<double>(samples.rows()) / sample_rate_hz; }
};

}  // namespace klang::audio
