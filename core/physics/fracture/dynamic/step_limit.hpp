#pragma once
#include <Eigen/Core>

#include "core/foundation/config/fields.hpp"

namespace klang::fracture {

/// How time is stepped. Forward Euler and the positions-only Taylor scheme are B99's; without damping both grow at any step (erratum 63).
enum class Integrator {
  kLeapfrog,  ///< v += a dt/2, x += v dt, v += a dt/2; viscous forces with the velocity of the middle
  kEuler,     ///< x += v dt, v += a dt
  kTaylor     ///< x += v dt + a dt^2/2, v += a dt
};
constexpr auto words_of(Integrator) {
  return std::array{Word{Integrator::kLeapfrog, "leapfrog"}, Word{Integrator::kEuler, "euler"},
                    Word{Integrator::kTaylor, "taylor"}};
}

/// Largest angular frequency of one element with lumped mass: 4/rho times the largest eigenvalue of B^T C B / V with B from the
/// gradients (rows: corners 1 to 3) and C of two Lame constants. With the viscosities for the Lame constants: its largest rate of
/// damping c [1/s], of which the ratio is c / (2 omega). The assembled mesh has no higher ones.
double element_omega_sq(const Eigen::Matrix3d& gradients, double lame_lambda, double lame_mu, double density_kg_m3);

/// Largest step for which an oscillator does not grow. @param damping_ratio  z >= 0
///   leapfrog  2 (sqrt(1 + z^2) - z) / omega
///   euler     2 z / omega up to z = 1, then 2 (z - sqrt(z^2 - 1)) / omega
///   taylor    the smaller of 4 z and 1/z, over omega
double largest_step_s(Integrator integrator, double omega_rad_s, double damping_ratio);

}  // namespace klang::fracture
