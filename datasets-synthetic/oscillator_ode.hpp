#pragma once
#include <Eigen/Core>
#include <functional>

namespace klang::datasets {

/// Coefficients of q'' + 2 decay q' + omega0^2 q = 0 at a moment.
struct OscillatorCoefficients {
  double omega0_rad_s = 0.0, decay_per_s = 0.0;
};

/// Displacement, velocity and acceleration at equally spaced times (n x 3), from q = 0 and q' = start_velocity at time
/// 0, by the implicit Gauss-Legendre method of 4 stages (order 8, A-stable, symplectic at constant coefficients) with
/// steps of at most 0.4 / omega0: about 1e-11 per step.
/// @param first_s  time of the first row, >= 0; step_s > 0 between rows
/// @param corners_s  ascending times at which the coefficients are not smooth: steps end there
Eigen::MatrixXd integrate_oscillator(const std::function<OscillatorCoefficients(double)>& coefficients,
                                     double start_velocity, double first_s, double step_s, Eigen::Index n,
                                     const std::vector<double>& corners_s = {});

}  // namespace klang::datasets
