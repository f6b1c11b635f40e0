#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/audio/strikes.hpp"
#include "fit/ringdown/detail/sub_band_fit.hpp"

namespace klang::fit::detail {

/// A stretch of free ringing: from the end of contact (and of clipping) to just before the next strike.
struct Segment {
  Eigen::Index begin = 0, end = 0;  ///< frames that are fitted
  double strike_s = 0.0;            ///< time of its strike
  double delay_s = 0.0;             ///< begin / rate - strike_s, >= 0
};

/// A partial while it is searched: its pole and its complex amplitude where each segment begins.
struct RingPartial {
  Pole pole;
  Eigen::MatrixXcd amplitude;  ///< n_segments x n_channels
  double energy() const;       ///< sum |a|^2 / (4 (decay + 1)), for ordering
};

/// What the fits see of a recording: channels that carry information, segments, and the spectra of their
/// windows (cached: every fit of the same window length shares one transform).
class RingData {
 public:
  /// Clipped samples are left out by starting the segment after them.
  RingData(const audio::Signal& recording, const std::vector<audio::Strike>& strikes, const Band& band);

  double sample_rate_hz() const { return rate_; }
  /// Seconds between a coder's transforms (Signal::coded_frames); 0: not coded.
  double coded_s() const { return coded_s_; }
  const Band& band() const { return band_; }
  const std::vector<Segment>& segments() const { return segments_; }
  const std::vector<Eigen::VectorXd>& channels() const { return channels_; }
  const std::vector<Eigen::Index>& channel_numbers() const { return channel_numbers_; }
  Eigen::Index n_clipped() const { return n_clipped_; }
  /// Rings that end suddenly (sudden_end): their segments end there.
  Eigen::Index n_cut_off() const { return n_cut_off_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Largest magnitude of a channel within a segment.
  double peak(Eigen::Index segment, Eigen::Index channel) const { return peaks_(segment, channel); }
  double longest_segment_s() const;
  Eigen::Index longest_segment() const;

  /// Bins within [low_hz, high_hz] of every segment and channel, windows of at most duration_s, less what the
  /// partials of `others` put there. Segments too short for the band are left out. Windows start `offset`
  /// frames into the segments, and so do the amplitudes of a fit to them.
  SubBand sub_band(double low_hz, double high_hz, double duration_s, const std::vector<RingPartial>& others,
                   Eigen::Index offset = 0) const;

  /// Channel less the partials, n frames from the segment's begin.
  Eigen::VectorXd residual(Eigen::Index segment, Eigen::Index channel, Eigen::Index n,
                           const std::vector<RingPartial>& partials) const;

 private:
  const Eigen::VectorXcd& spectrum(Eigen::Index segment, Eigen::Index channel, Eigen::Index offset,
                                   Eigen::Index n) const;
  void choose_channels(const audio::Signal& recording);
  void cut_segments(const std::vector<audio::Strike>& strikes, Eigen::Index n_frames);

  double rate_ = 0.0, coded_s_ = 0.0;
  Band band_;
  std::vector<Segment> segments_;
  std::vector<Eigen::VectorXd> channels_;
  std::vector<Eigen::Index> channel_numbers_;
  Eigen::MatrixXd peaks_;  ///< n_segments x n_channels
  Eigen::Index n_clipped_ = 0, n_cut_off_ = 0;
  std::vector<std::string> warnings_;
  mutable std::mutex mutex_;
  mutable std::map<std::array<Eigen::Index, 4>, Eigen::VectorXcd> spectra_;
};

}  // namespace klang::fit::detail
