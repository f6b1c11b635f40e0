#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/events/event_log.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/scene/scene_bodies.hpp"
#include "core/sound/stage/impact_pulses.hpp"
#include "core/sound/stage/listener.hpp"
#include "core/sound/transfer/transfer_model.hpp"

namespace klang::scene {

/// A mesh's error of frequencies above which what is left of it after its estimate is taken off (about a tenth) is said.
inline constexpr double kOpenMeshError = 0.04;

/// The modes of a body and how they radiate.
struct SoundModel {
  modal::ModalModel modes;
  acoustics::TransferModel transfer;
  bool proxy = false;  ///< an ellipsoid's (scene_proxies.hpp)
  /// Largest relative error of the frequencies for the mesh, by its estimate, which was taken off; not known of a model that was read.
  std::optional<double> mesh_error;
};

/// Modes of the body within the scene's band, and their radiation: of the free one, of a modal one that still holds or joints to the world
/// keep as kept there. Nothing where it has no mode there: a steel ball of 40 mm rings above hearing (notes.warning says so).
/// @throws InputError that names the body, where it has no mode in the band and sound = "modes" asks for them; NumericalError;
///   Interrupted
std::optional<SoundModel> sound_model_of(const Scene& scene, const SceneBody& body, const SceneNotes& notes = {},
                                         Monitor& monitor = silent_monitor());

/// The same of a piece of a broken body of the scene, from its surface. Nothing where it has no mode in the band, or where
/// no mesher takes it (notes.warning says so).
std::optional<SoundModel> sound_model_of(const Scene& scene, const SceneBody& parent, const std::string& name,
                                         const mesh::SurfaceMesh& surface, const SceneNotes& notes = {},
                                         Monitor& monitor = silent_monitor());

/// The same of a piece of a cracking body, from its own tetrahedra with quadratic functions, so that slits need no mesher: each tetrahedron is made eight of
/// while the estimate of what the mesh leaves out is above 2 %, up to 20,000 of them. No sound where no boundary elements can be made of its
/// surface, which touches itself (notes.warning says so).
std::optional<SoundModel> sound_model_of(const Scene& scene, const SceneBody& parent, const std::string& name,
                                         mesh::TetMesh tetrahedra, const SceneNotes& notes = {},
                                         Monitor& monitor = silent_monitor());

/// Bodies with the same number sound alike: same shape or mesh, material, mesh size, and places that are kept. One number per body of the scene,
/// from 0 up; none for bodies that are silent.
std::vector<std::optional<int>> sound_model_numbers(const Scene& scene);

/// Warns of each material without damping that a sounding body or floor is of.
void warn_of_assumed_damping(const Scene& scene, const SceneNotes& notes);
/// Warns where the sample rate ends below the band that is to be heard.
void warn_of_low_sample_rate(const Scene& scene, const SceneNotes& notes);
/// That bodies whose own modes are asked for have one in the band, as far as that is known without their radiation: of convex ones by
/// polynomials, of others by their mesh. @throws InputError naming the body
void require_modes(const Scene& scene, Monitor& monitor = silent_monitor());
/// Says which materials come from fits whose own verdict is contradicted.
void warn_of_contradicted_fits(const Scene& scene, const SceneNotes& notes);

/// A body of a log that is heard.
struct HeardBody {
  int body = 0;  ///< row of the log's bodies
  std::shared_ptr<const SoundModel> model;
  damping::LawValue damping;  ///< of its material
};

/// Decay of each mode by the law and, with radiation_damping, by what it radiates.
Eigen::VectorXd decay_per_s(const HeardBody& body, bool radiation_damping);

/// How long the slowest mode of all rings by 60 dB [s].
double ring_time_s(const std::vector<HeardBody>& bodies, bool radiation_damping);

stage::Listener listener_of(const SceneListener& listener);

/// The sound at the listener [Pa].
/// @param pulses  impact_pulses() of the log; none: every impact is Hertz' between rigid bodies
audio::Signal sound_of(const events::EventLog& log, const std::vector<HeardBody>& bodies,
                       const SceneSoundOptions& options, double duration_s, Monitor& monitor = silent_monitor(),
                       const stage::ImpactPulses* pulses = nullptr);

}  // namespace klang::scene
