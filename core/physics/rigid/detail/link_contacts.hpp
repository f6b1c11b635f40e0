#pragma once
#include <vector>

#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/link.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid::detail {

/// Links as contacts of bodies where they would be: a cord that is taut pushes a towards b along itself; places that stay together
/// are tied. Only gap, place, normal, arms and what marks them as links are filled in.
/// @param length  inner length of a metre
std::vector<Contact> link_contacts(const std::vector<Link>& links, const std::vector<RigidBodySpec>& specs,
                                   const std::vector<BodyState>& bodies, double length, double slop);

}  // namespace klang::rigid::detail
