#pragma once
#include <Eigen/Core>

namespace klang::stage {

/// Two bodies that touch at n places at once, as rigid bodies with elastic modes and Hertz' springs between them.
struct YieldingContact {
  Eigen::MatrixXd
      mobility_per_kg;  ///< n x n, symmetric: closing acceleration at place i by a unit force at j, of the rigid bodies
  Eigen::VectorXd approach_m_s;             ///< n, > 0: closing speed when they touch
  Eigen::VectorXd stiffness_n_m32;          ///< n, > 0: k of F = k depth^(3/2)
  Eigen::VectorXd residual_m_n;             ///< n, >= 0: compliance of what the modes leave out, in series with k
  Eigen::VectorXd angular_frequency_rad_s;  ///< of the modes of both bodies, > 0
  Eigen::MatrixXd shapes;                   ///< n_modes x n: displacement along the push at each place [1/sqrt(kg)]
};

/// Forces of such a contact, one after the other for each place, from the touch on.
struct ContactForces {
  double step_s = 0.0;
  Eigen::MatrixXd force_n;      ///< n_steps x n; 0 in the first and last row
  Eigen::VectorXd impulse_n_s;  ///< n: what they sum up to
};

/// Steps
///   depth_i'' = -sum_j A_ij F_j,   q_m'' + omega_m^2 q_m = sum_i W_mi F_i,
///   F_i = k_i (depth_i - sum_m W_mi q_m - c_i F_i)^(3/2) where that is positive, else 0,
/// from depth 0 until no place has touched for as long as the contact had lasted and all open, at most limit_s. Modes turn exactly
/// between kicks (Deuflhard 1979: order 2, no energy drifts). Without modes it is Hertz' contact; with those of a wide plate Zener's (1941),
/// lambda = m / (8 sqrt(D rho h) T0).
/// @throws InputError for sizes that do not fit or values out of range
ContactForces yielding_forces(const YieldingContact& contact, double limit_s);

/// Energy that forces leave in the modes: 1/2 sum_m |sum_i W_mi int F_i e^(i omega_m t) dt|^2.
double vibration_j(const YieldingContact& contact, const ContactForces& forces);

/// k of Hertz' spring from the contact time of two rigid bodies: T = 3.2181 (m / (k sqrt(v)))^(2/5).
double hertz_stiffness_n_m32(double mass_kg, double approach_m_s, double duration_s);

/// Compliance of the modes above those that are known, by those of their highest octave: where sum W^2 goes on growing with frequency as
/// it does there, as it does for a plate, sum W^2 / omega^2 over the rest is s / omega_n, s the growth per omega.
/// @param angular_frequency_rad_s  rising
Eigen::VectorXd residual_of_higher_modes_m_n(const Eigen::VectorXd& angular_frequency_rad_s,
                                             const Eigen::MatrixXd& shapes);

}  // namespace klang::stage
