#pragma once
#include "core/physics/modal/constraints/friction_statuses.hpp"

namespace klang::modal {

/// Forces well within their cones that nearly meet the problem, by the logarithmic barrier of the cones and Newton's method; what slides lifts by
/// mu |w_t|, De Saxce's term, which follows along. Of all ways that corners can share a load it takes the most even one, from which
/// solve_by_statuses() gets to the end. Frictionless contacts have no cone: not for those.
/// @param root  R with A = R R^T
Eigen::VectorXd forces_within(const FrictionProblem& problem, const Eigen::MatrixXd& root);

}  // namespace klang::modal
