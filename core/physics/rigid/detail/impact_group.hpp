#pragma once
#include <vector>

#include "core/physics/rigid/detail/contact_solver.hpp"

namespace klang::rigid::detail {

/// What impacts lost, in inner units.
struct ImpactLosses {
  double normal = 0.0, friction = 0.0;
};

/// Takes what cords and hinges of a group do not let go, as their bodies have flown freely since the step's begin: what strikes
/// bodies that swing then finds them as held, and gives back no more than it has. The impulse is added to theirs.
ImpactLosses settle_ties(const std::vector<Contact*>& group, Bodies& bodies);

/// Points that are solved at once, for v+ >= -e v- and Coulomb's cone. Where that would gain energy, as Newton's rule with friction can
/// (Kane 1984), they rebound less. The impulse is added to theirs.
ImpactLosses solve_impacts(const std::vector<Contact*>& group, Bodies& bodies);

}  // namespace klang::rigid::detail
