#pragma once
#include <Eigen/Core>

#include "core/foundation/base/random.hpp"

namespace klang::datasets {

/// n samples of Gaussian noise of unit mean square (in expectation, white; pink: exactly). Pink falls by 3 dB
/// an octave above 20 Hz and is flat below.
Eigen::VectorXd white_noise(Eigen::Index n, RandomStream& random);
Eigen::VectorXd pink_noise(Eigen::Index n, double sample_rate_hz, RandomStream& random);

/// sound convolved with a room's tail: Gaussian noise under exp(-t ln(1000) / rt60), scaled so that the
/// energy of its response is level_db against the direct sound's 1. The direct sound is not part of it.
Eigen::VectorXd room_tail(const Eigen::VectorXd& sound, double sample_rate_hz, double rt60_s, double level_db,
                          RandomStream& random);

/// sum_k amplitude / k cos(2 pi k frequency t + phase_k), phases drawn uniformly.
Eigen::VectorXd mains_hum(Eigen::Index n, double sample_rate_hz, double frequency_hz, double amplitude, int harmonics,
                          RandomStream& random);

}  // namespace klang::datasets
