#pragma once
#include "core/physics/modal/constraints/contact_problem.hpp"

namespace klang::modal {

/// A contact problem with friction as solve_friction() has it.
struct FrictionProblem {
  const Eigen::MatrixXd& a;
  const Eigen::VectorXd& b;
  const Eigen::VectorXd& friction;  ///< per contact
};

/// How far forces are from meeting it: of the natural map, over the largest force.
double friction_residual(const FrictionProblem& problem, const Eigen::VectorXd& forces);

/// By guesses of which contacts are open, stick or slide which way, each of them a linear system: the guess of the next one follows from
/// the forces and speeds of the last. Where many contacts share what a few motions need, as corners of a flat face at rest, the systems are as small as those
/// motions and of all forces that meet them the nearest to those before are taken. The best of what it came to; it may be far off.
/// @param tolerance  of the residual, where guesses end. @param enough  where what they came to is taken before the barrier is asked
ContactForces solve_by_statuses(const FrictionProblem& problem, const Eigen::VectorXd& start, double tolerance,
                                double enough);

}  // namespace klang::modal
