#pragma once
#include <Eigen/Core>

namespace klang::validate::detail {

/// Lower edge of band i of a twelfth octave (four to a third octave of IEC 61260) [Hz]; i may be the number of bands.
double band_edge_hz(int first_third, Eigen::Index i);

struct BandFrames {
  double rate_hz = 0.0, start_s = 0.0, window_s = 0.0, hop_s = 0.0;
  int first_third = 0;
  Eigen::Index n_bands = 0, n_frames = 0;
};

/// Power in each band of Hann windows that begin at start_s + k hop_s (a sine of amplitude 1 in the midst of a band has 1).
/// The integral of the window's power spectrum between the band's edges, exact: with r the autocorrelation of the windowed
/// samples, r_0 (f2 - f1) + sum_l r_l (sin(2 pi f2 l / rate) - sin(2 pi f1 l / rate)) rate / (pi l). No bins, hence the same
/// at every sample rate; the windows begin between samples where the time asks for it. What lies beyond the end is silent.
/// @return n_bands x n_frames
Eigen::MatrixXf band_powers(const Eigen::VectorXd& samples, const BandFrames& frames);

/// Highest frequency that the recording carries: half of the sample rate, or where a coder or an older sample rate has cut it
/// off: there the floor between the lines (a low quantile of the mean power spectrum) falls by 10 dB or more within a sixth of
/// an octave and never comes back.
double heard_limit_hz(const Eigen::VectorXd& samples, double rate_hz);

}  // namespace klang::validate::detail
