#pragma once
#include <Eigen/Core>

namespace klang::modal {

/// What contacts exert.
struct ContactForces {
  Eigen::VectorXd forces;
  double residual =
      0.0;  ///< worst violation of 0 <= f, 0 <= A f + b, f (A f + b) = 0 and of the cone, over the largest |b| and |f|
  int iterations = 0;
};

/// Linear complementarity: f >= 0, A f + b >= 0, f . (A f + b) = 0; A symmetric, positive semidefinite: least of f.A f/2 + b.f over
/// f >= 0, by active sets. @throws NumericalError where it does not end
ContactForces solve_lcp(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// H03's linear program: least sum of f with A f + b >= 0, f >= 0. It is not the contact problem: a contact may be pushed while it separates
/// (erratum 71). @throws NumericalError where nothing satisfies it
ContactForces solve_contact_lp(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// When sweeps end: at the tolerance; after as many as are for it, at what is enough.
struct FrictionSweeps {
  int most = 10000, fine = 10000;
  double tolerance = 1e-10, enough = 1e-10;
  Eigen::VectorXd start;  ///< forces to start from, such as those of the step before; empty: none
};

/// Coulomb's friction: three rows per contact (normal, two tangents), |f_t| <= mu f_n, normal complementarity, and tangential forces against the
/// sliding (De Saxce's associated form at velocity level): by guesses of which contacts stick and slide (friction_statuses.hpp), and where those do not
/// get there from the best of them by block Gauss-Seidel with the exact projection on the cone.
/// @param friction  per contact
ContactForces solve_friction(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& friction,
                             const FrictionSweeps& sweeps = {});

}  // namespace klang::modal
