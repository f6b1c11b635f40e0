#include "core/sound/scene/scene_motion.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/sound/scene/scene_cracking.hpp"
#include "core/sound/scene/scene_modal.hpp"

namespace klang::scene {
namespace {

constexpr double kMadeByContacts = 0.005;  ///< of the scene's energy

/// What lifts every movable body by half its smallest width: the least that the ledger of bodies at rest is measured by.
double lift_j(const rigid::RigidWorld& world, const Eigen::Vector3d& gravity_m_s2) {
  double sum = 0.0;
  for (int i = 0; i < world.n_bodies(); ++i) {
    const rigid::RigidBodySpec& body = world.spec(i);
    if (!body.fixed) sum += body.mass_kg * gravity_m_s2.norm() * body.smallest_half_width_m();
  }
  return sum;
}

void judge_ledger(SceneMotion& motion, double least_j) {
  double lowest_j = HUGE_VAL, worst_j = 0.0;
  for (const rigid::EnergyLedger& row : motion.ledger) {
    lowest_j = std::min(lowest_j, row.potential_j);
    worst_j = std::max(worst_j, std::abs(row.residual_j));
  }
  const rigid::EnergyLedger& start = motion.ledger.front();
  motion.energy_scale_j = std::max(start.kinetic_j + start.potential_j - lowest_j, least_j);
  if (motion.cracks || motion.contact_residual) {  // also what holds put in, and what was in the bodies
    double most_j = 0.0;
    for (const rigid::EnergyLedger& row : motion.ledger)
      most_j = std::max({most_j, row.strain_j, std::abs(row.work_j - start.work_j)});
    motion.energy_scale_j += most_j;
  }
  if (motion.cracks && worst_j <= motion.cracks->round_off_j) worst_j = 0.0;  // bodies at rest
  motion.residual_relative = worst_j > 0.0 ? worst_j / motion.energy_scale_j : 0.0;
}

/// Says where pushes between rigid and cracking bodies gave more than they took: they store and give back, and make nothing but by their steps.
void warn_of_made_energy(SceneMotion& motion) {
  double least_j = 0.0;
  for (const rigid::EnergyLedger& row : motion.ledger) least_j = std::min(least_j, row.contact_j);
  if (motion.cracks && -least_j > kMadeByContacts * motion.energy_scale_j)
    motion.cracks->warnings.push_back("contacts of cracking bodies made " + to_text(-least_j) + " J of " +
                                      to_text(motion.energy_scale_j) +
                                      " J: steps of the motion are long for what touches; a higher solver.rate_hz");
}

FinalState final_of(const rigid::RigidWorld& world, int body) {
  FinalState state;
  state.position_m = world.centre_m(body);
  state.orientation_wxyz = world.pose(body).orientation_wxyz;
  state.velocity_m_s = world.velocity_m_s(body);
  state.angular_velocity_rad_s = world.angular_velocity_rad_s(body);
  return state;
}

}  // namespace

void add_ledger(SceneMotion& motion, const std::vector<rigid::EnergyLedger>& rows) {
  const std::size_t n = std::min(motion.ledger.size(), rows.size());
  for (std::size_t i = 0; i < n; ++i) {
    rigid::EnergyLedger& row = motion.ledger[i];
    const rigid::EnergyLedger& add = rows[i];
    for (double rigid::EnergyLedger::*entry :
         {&rigid::EnergyLedger::kinetic_j, &rigid::EnergyLedger::potential_j, &rigid::EnergyLedger::strain_j,
          &rigid::EnergyLedger::viscous_j, &rigid::EnergyLedger::plastic_j, &rigid::EnergyLedger::contact_j,
          &rigid::EnergyLedger::friction_j, &rigid::EnergyLedger::correction_j, &rigid::EnergyLedger::work_j,
          &rigid::EnergyLedger::residual_j})
      row.*entry += add.*entry;
  }
}

SceneMotion move(const Scene& scene, std::optional<double> until_s, std::uint64_t seed, const SceneNotes& notes,
                 Monitor& monitor) {
  rigid::RigidWorld world = world_of(scene, notes, monitor);
  rigid::RecordingOptions recording_options;
  recording_options.pose_rate_hz = scene.pose_rate_hz;
  CrackingBodies cracking(scene, world, seed, notes, monitor);
  ModalBodies modal(scene, world, notes, monitor);
  rigid::Recording recording(world, recording_options);
  rigid::RunOptions options;
  options.end_s = scene.duration_s;
  if (until_s) options.end_s = std::min(*until_s, scene.duration_s.value_or(*until_s));
  options.longest_s = scene.longest_s;
  Breaking breaking(scene, seed);
  if (breaking.has_bodies() || cracking.any() || modal.any())
    options.after_step = [&](rigid::RigidWorld& w, rigid::StepRecord& step) {
      monitor.throw_if_stopped();
      cracking.after_step(w);
      modal.after_step(w);
      modal.refuse_meeting(cracking);
      return breaking.has_bodies() ? breaking.after_step(w, step) : std::vector<rigid::Breakage>();
    };
  SceneMotion motion;
  located(scene.file.filename().string(), [&] {
    rigid::run(world, recording, options, monitor);
    return 0;
  });
  motion.log = recording.log();
  motion.ledger = recording.ledger();
  motion.n_steps = static_cast<int>(motion.ledger.size()) - 1;
  motion.end_s = world.time_s();
  motion.solver_residual_m_s = recording.worst_solver_residual_m_s();
  motion.deepest_m = recording.deepest_m();
  for (int i = 0; i < world.n_bodies(); ++i) {
    motion.mass_kg.push_back(world.spec(i).mass_kg);
    motion.final.push_back(final_of(world, i));
  }
  motion.breaks = breaking.events();
  if (notes.warning)
    for (const std::string& warning : breaking.warnings()) notes.warning(warning);
  motion.pieces = breaking.take_pieces();
  motion.n_stress_solves = breaking.n_stress_solves();
  if (cracking.any()) cracking.add_to(motion);
  if (modal.any()) modal.add_to(motion);
  judge_ledger(motion, lift_j(world, scene.solver.gravity_m_s2));
  warn_of_made_energy(motion);
  motion.status = MotionStatus::kDone;
  return motion;
}

}  // namespace klang::scene
