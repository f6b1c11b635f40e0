#pragma once
#include <vector>

#include "core/physics/rigid/detail/contact_solver.hpp"

namespace klang::rigid::detail {

/// How far bodies' centres are to go so that what overlaps by more than two slops goes apart by a fifth of what is more than one: of all
/// ways that do so, and press nothing else together beyond a slop, those with the least sum of mass times way squared, whatever the order of
/// bodies and contacts. Points of a pair with one normal ask once, for the deepest. Where all cannot be had, as of a body
/// caught between fixed ones, bodies there go less far, so that nothing that asks goes deeper.
///   min sum m |w|^2  with  n . (w_a - w_b) >= want:  projected gradients of the dual, accelerated (Nesterov 1983), for each contact with the
/// share 1 / (its number of contacts) of a body's mass, with which they converge (Tonge et al. 2012).
/// @param contacts  sorted by body a, then b
/// @param gaps      of the contacts, negative: overlap
/// @return          a way for each body; empty: nothing overlaps so far
std::vector<Eigen::Vector3d> ways_apart(const std::vector<Contact>& contacts, const std::vector<double>& gaps,
                                        double slop, const std::vector<BodyState>& bodies);

}  // namespace klang::rigid::detail
