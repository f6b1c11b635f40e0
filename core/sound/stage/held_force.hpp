#pragma once
#include <vector>

#include "core/sound/stage/modal_voice.hpp"

namespace klang::stage {

/// What the held impulses of a log do to the modes of a body, as modal impulses without duration.
///
/// The modal force f is the polygon through the middles of the steps. Of q'' + 2 b q' + w^2 q = f the part q - f / w^2 rings,
///   r'' + 2 b r' + w^2 r = -(f'' + 2 b f') / w^2,
/// and f / w^2, the bending under a load that is slow, makes no sound. f'' is an impulse at each corner of the polygon, the
/// change of its slope; 2 b f' is taken half at either end of each side. So a body that rests under a constant force is
/// silent to the last bit, and a force that changes slowly does not sing at the rate of the steps. A contact that begins or
/// ends does so within a step; one that lasts from time 0 on, or up to the last held impulse of the log, has no begin or end.
std::vector<ModalImpulse> held_impulses(const events::EventLog& log, int body, const ModalPush& push,
                                        const PushedModes& modes);

}  // namespace klang::stage
