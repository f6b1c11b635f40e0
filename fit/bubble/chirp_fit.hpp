#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fit/bubble/chirp_model.hpp"
#include "fit/bubble/search_work.hpp"

namespace ceres {
class CostFunction;
class Problem;
}  // namespace ceres

namespace klang::fit::bubble {

/// Variance of stationary noise by frequency: S(f), in units of one sample's variance were it white (a white noise of
/// variance v has S = v at every frequency). Linear between equally spaced frequencies.
struct NoiseSpectrum {
  double step_hz = 0.0;
  Eigen::VectorXd variance;  ///< at 0, step_hz, ...
  double at(double frequency_hz) const;
};

/// A stretch of the recording in which some bubbles are fitted together: its transform over a band, under a cosine-edged
/// window that the model is put under too.
struct ChirpWindow {
  double first_s = 0.0, sample_rate_hz = 0.0;
  Eigen::VectorXd taper;  ///< n_samples
  Eigen::Index n_fft = 0, first_bin = 0, n_bins = 0;
  Eigen::VectorXcd data;   ///< n_bins
  Eigen::VectorXd weight;  ///< sqrt(2) / standard deviation of a bin's noise: real and imaginary part get variance 1
  std::shared_ptr<SearchWork> work;  ///< counts what is evaluated in this window and stops its fits; may be null

  /// Where the samples stand in the recording, whose ends are no edges of the sound, and the band that is fitted.
  struct Place {
    Eigen::Index first = 0, n_recording = 0;  ///< samples
    double low_hz = 0.0, high_hz = 0.0;
  };
  /// @param samples  samples first, first + 1, ... of the recording, less what other bubbles make of it
  ChirpWindow(const Eigen::VectorXd& samples, double sample_rate_hz, const Place& place, const NoiseSpectrum& noise);
  Eigen::Index n_real_data() const { return 2 * n_bins; }
  /// 2 n_bins: weighted real, then imaginary parts of tapered samples' bins.
  Eigen::VectorXd weighted(const Eigen::VectorXd& samples) const;
};

/// Residual (model - data) of a window. Blocks: the pitch parameters of each pitch group (2), then each bubble's
/// (onset, ln f, ln decay, c, s) (5), all in units of kChirpScale. Residuals: 2 n_bins.
/// @param pitch_group  of each bubble; groups are numbered from 0 without gaps
std::unique_ptr<ceres::CostFunction> make_chirp_cost(std::shared_ptr<const ChirpWindow> window,
                                                     std::vector<ChirpLaw> laws, std::vector<int> pitch_group);

/// A quick attack falls between two samples: once it is found, only this keeps the onset from sliding along the track, which
/// the sound after it does not notice. Residual (onset - where it was found) / (a twentieth of a cycle); block: a bubble's own.
std::unique_ptr<ceres::CostFunction> make_onset_prior(const ChirpLaw& law, const Chirp& found);

/// One unit of each parameter as the solver sees it: steps of like effect.
Eigen::Matrix<double, Chirp::kParameters, 1> chirp_scale(const ChirpLaw& law);

/// Weak knowledge of a pitch parameter: normal. Infinite std: none.
struct PitchPrior {
  Eigen::Vector2d mean{0.0, 20.0},
      standard_deviation{60.0, 40.0};  ///< of bubbles that rise by 0 to 0.5 m/s within centimetres of a surface
};

struct ChirpFit {
  bool ok = false;
  std::vector<Chirp> chirps;
  double chi_square = 0.0;  ///< of the window's residual
  Eigen::Index n_real_data = 0;
  /// 7 x 7 per bubble, all others' uncertainty in it; not scaled by chi_square. Empty when it was not asked for.
  std::vector<Eigen::MatrixXd> covariance;
};

/// Covariance of a problem's parameters at their present values, (J^T J)^-1 in the order of the blocks; directions that the
/// residuals do not see are left out of the inverse.
Eigen::MatrixXd parameter_covariance(ceres::Problem& problem, const std::vector<double*>& blocks);

/// Best complex amplitude of a chirp with all else held. @return chi square it leaves
/// @throws Interrupted when the window's monitor asks for it
double fit_amplitude(const ChirpWindow& window, const ChirpLaw& law, Chirp& chirp);

/// Maximum-posterior chirps of a window from a start. Not ok when the window's monitor stopped it.
ChirpFit fit_chirps(const ChirpWindow& window, const std::vector<ChirpLaw>& laws, const std::vector<Chirp>& start,
                    const PitchPrior& prior, int max_iterations, bool with_covariance);

}  // namespace klang::fit::bubble
