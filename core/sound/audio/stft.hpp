#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::audio {

struct StftOptions {
  double window_s = 0.02;  ///< Hann window's length, at least 4 samples; up to the signal's length
  double hop_s = 0.005;    ///< between frames, at least 1 sample
  int padding = 1;         ///< transform length / window length, 1 to 16
  int max_frames = 20000;  ///< the hop grows so that no more are made, 1 to 1e6
  void validate() const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"window_s", "Length of the Hann window", inside(0.0, 1e4)}, self.window_s);
    visit({"hop_s", "Time between frames", inside(0.0, 1e4)}, self.hop_s);
    visit({"padding", "Length of the transform over that of the window", between(1.0, 16.0)}, self.padding);
    visit({"max_frames", "The hop grows so that no more are made", between(1.0, 1e6)}, self.max_frames);
  }
};

/// Short-time power. times_s (n_times) at window centres, frequencies_hz (n_frequencies) from 0 to half the
/// rate.
struct Stft {
  std::vector<double> times_s, frequencies_hz;
  Eigen::MatrixXf power;  ///< n_frequencies x n_times, mean over channels; a sine of amplitude 1 peaks at 1
};

/// Power of the Hann-windowed transform. The first window starts at the first frame; the last may run past
/// the end (zeros follow). @throws InputError for options out of range, no frames, a rate that is not
/// positive.
Stft stft(const Signal& signal, const StftOptions& options = {});

/// The same transform at several window lengths (hop = a quarter of each), shortest first.
std::vector<Stft> multi_resolution_stft(const Signal& signal, const std::vector<double>& windows_s);

/// A picture's data: level in dB re full scale (a sine of amplitude 1 = 0 dB), not below floor_db.
struct Spectrogram {
  std::vector<double> times_s, frequencies_hz;
  Eigen::MatrixXf level_db;  ///< n_frequencies x n_times
};
Spectrogram spectrogram(const Signal& signal, const StftOptions& options = {}, double floor_db = -140.0);

}  // namespace klang::audio
