#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/sound/scene/scene_sound.hpp"
#include "core/sound/stage/impact_pulses.hpp"

/// How the force of an impact goes over time where the bodies that touch give way by their own modes.
namespace klang::scene {

/// The surface of a piece, by its row of the log; none: unknown.
using SurfaceOfPiece = std::function<std::optional<mesh::SurfaceMesh>(int row)>;

/// Pulses of the impacts of bodies that are heard, instead of Hertz' between rigid bodies: all points of a pair that touch at one moment are
/// one contact problem (stage::yielding_forces) of the two rigid bodies, as cords and hinges hold them, the modes of those that are heard, and Hertz' springs, whose stiffness is that
/// which the row's contact time has. Kept of the rigid step are the impulses: each history is scaled to its row's. Where what it then leaves in the modes
/// is more than the contacts took from the motion (by the pair's restitution e: sum J u (1 - e) / 2, all of it in the step that breaks a body), modes
/// feel a smaller share of it. Rows of modal and cracking bodies, whose contacts yield already, rows without duration and
/// of bodies of unknown mass keep their pulse.
stage::ImpactPulses impact_pulses(const Scene& scene, const events::EventLog& log, const std::vector<HeardBody>& heard,
                                  const SurfaceOfPiece& surface_of_piece, Monitor& monitor = silent_monitor());

}  // namespace klang::scene
