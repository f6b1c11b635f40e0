#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/events/event_log.hpp"
#include "core/physics/rigid/recording.hpp"
#include "core/sound/scene/deformed_shapes.hpp"
#include "core/sound/scene/scene_bodies.hpp"
#include "core/sound/scene/scene_breaking.hpp"

namespace klang::scene {

enum class MotionStatus { kNotRun, kDone };

/// How a body ended.
struct FinalState {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of the centre of mass
  Eigen::Vector4d orientation_wxyz = Eigen::Vector4d(1.0, 0.0, 0.0, 0.0);
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), angular_velocity_rad_s = Eigen::Vector3d::Zero();
};

/// What cracking bodies did.
struct CrackSummary {
  int n_splits = 0, n_elements_start = 0, n_elements_end = 0;
  double dissipation_j = 0.0, max_strain = 0.0;  ///< by plastic flow; Green's measure
  double round_off_j = 0.0;                      ///< elastic energy that round-off of places makes: less is none
  std::vector<fracture::PartedFace> faces;       ///< of all bodies, in their rest shapes
  /// Steps with splits, body by body and in time.
  struct Split {
    double time_s = 0.0, crack_area_m2 = 0.0;
    std::optional<double> largest_stress_pa;  ///< none: a toughness in newtons decides
    int body = 0, n = 0, pieces = 1;
    fracture::SolidEnergies energies;  ///< of the whole body then, and what it lost until then
  };
  std::vector<Split> splits;
  std::vector<std::string> warnings;
};

struct SceneMotion {
  MotionStatus status = MotionStatus::kNotRun;
  events::EventLog log;                     ///< bodies in the scene's order, then pieces
  std::vector<rigid::EnergyLedger> ledger;  ///< a row per step, and the start
  std::vector<double> mass_kg;              ///< of each body
  std::vector<FinalState> final;            ///< of each body
  double end_s = 0.0;
  double residual_relative = 0.0;  ///< largest |residual| over the energy at the start (energy_scale_j)
  /// Kinetic energy at the start, and what potential energy lay above its lowest value in the run; at least what lifts every movable
  /// body by half its smallest width.
  double energy_scale_j = 0.0;
  double solver_residual_m_s = 0.0, deepest_m = 0.0;  ///< worst of all steps (rigid::StepRecord)
  int n_steps = 0;
  std::vector<BreakEvent> breaks;
  std::vector<ScenePiece> pieces;
  DeformedShapes shapes;  ///< of bodies that deform, where frames are wanted
  std::int64_t n_stress_solves = 0;
  std::optional<CrackSummary> cracks;  ///< of a scene with cracking bodies
  std::optional<double>
      contact_residual;        ///< of a scene with modal bodies: worst of their contact problems, dimensionless
  double joint_error_m = 0.0;  ///< farthest that held places and joints were off at ends of small steps
};

/// Adds energies of bodies that are not in the rigid world, a row per step and the start, to the motion's.
void add_ledger(SceneMotion& motion, const std::vector<rigid::EnergyLedger>& rows);

/// Moves the bodies of a scene until its duration, or until all rest.
/// @param until_s  ends it earlier
/// @param seed     of the cells of bodies that break
/// @throws InputError: a scene that does not come to rest, a body that is too fast for the steps; Interrupted
SceneMotion move(const Scene& scene, std::optional<double> until_s = {}, std::uint64_t seed = 1,
                 const SceneNotes& notes = {}, Monitor& monitor = silent_monitor());

}  // namespace klang::scene
