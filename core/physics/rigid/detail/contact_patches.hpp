#pragma once
#include <vector>

#include "core/physics/rigid/detail/contact_solver.hpp"

namespace klang::rigid::detail {

/// Contacts of pairs of bodies without those that say nothing new: parts of a body share corners and sides, so that the same point
/// comes more than once, and points inside a flat patch of equal normals, or on its sides, hold nothing that its corners do not (the
/// relative speed is linear over the patch). What is left is the same from step to step of a body at rest, whatever the last digits
/// do, which a warm start needs. Of a patch with more than eight corners (a round foot) those stay that lie farthest in eight
/// directions fixed in body a, and what lies deeper: a disk may tip over a polygon's side, 8 % nearer to its centre, until the next
/// corner touches. The floor's contacts stay as they are.
/// @param contacts  sorted by body a, then b
/// @param slop      gap below which bodies touch; a thousandth of it is no distance
std::vector<Contact> patch_corners(const std::vector<Contact>& contacts, const std::vector<BodyState>& bodies,
                                   double slop);

}  // namespace klang::rigid::detail
