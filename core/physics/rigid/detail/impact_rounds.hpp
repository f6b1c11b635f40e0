#pragma once
#include <vector>

#include "core/physics/rigid/detail/contact_solver.hpp"

namespace klang::rigid::detail {

/// What impacts lost, in inner units.
struct ImpactLosses {
  double normal = 0.0, friction = 0.0;
};

struct ImpactRules {
  Eigen::Vector3d gravity;
  double rest_speed = 0.0;  ///< slower touches are no impacts: the lasting contacts hold them
  bool simultaneous = false;
};

/// Solves the impacts of a step: pairs in the order of touch, each with v+ >= -e v- at all of its points at once and Coulomb's cone,
/// at most five rounds over pairs that approach (one round over all points where simultaneous). Bodies fly on their
/// parabolas to the moment of touch first (BodyState::clock). A pair that would gain energy, as Newton's rule with friction can
/// (Kane 1984), rebounds less.
ImpactLosses solve_impacts(std::vector<Contact>& contacts, const ImpactRules& rules, Bodies& bodies);

/// Moves a body on its parabola to a time in the step; nothing if it is there or beyond.
void fly_to(BodyState& body, double time, const Eigen::Vector3d& gravity);

}  // namespace klang::rigid::detail
