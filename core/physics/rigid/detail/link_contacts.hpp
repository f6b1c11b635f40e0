#pragma once
#include <optional>

#include "core/physics/rigid/detail/contact_solver.hpp"
#include "core/physics/rigid/link.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid::detail {

struct LinkEnd {
  const RigidBodySpec& spec;
  const BodyState& at;
};

/// The contact of a link that is taut, or would be, with place, arms and normal where the bodies are.
/// @param b       not read where it is the world
/// @param length  inner lengths per metre  @param slop  inner length
std::optional<Contact> link_contact(const Link& link, const LinkEnd& a, const LinkEnd& b, double length, double slop);

}  // namespace klang::rigid::detail
