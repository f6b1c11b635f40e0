#pragma once
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/events/event_log.hpp"
#include "core/physics/rigid/rigid_world.hpp"

namespace klang::rigid {

struct RecordingOptions {
  double pose_rate_hz =
      1000.0;  ///< of the poses that are kept; a step that pushes a body keeps one of it at its end beside them

  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"pose_rate_hz", "poses per second that are kept of each body that moves", between(1.0, 1e6)},
          self.pose_rate_hz);
  }
};

/// A body that broke at the end of a step.
struct Breakage {
  int body = 0;
  std::vector<int> pieces;                ///< numbers in the world, each above all that were there before
  std::vector<events::Impulse> impulses;  ///< that the cracks gave the pieces, in their frames
  std::optional<double> time_s;           ///< when it broke; else at the step's end, from which on the pieces are there
};

/// The row of a log for one of the two bodies of a contact, in that body's frame. @param pose  of the body
/// at the end of the step, before which the row's time lies
events::Impulse impulse_on(const ContactImpulse& contact, int body, const events::Pose& pose);

/// Writes down what a world does, for those who make sound, pictures and tables of it: bodies, their poses, and every impulse
/// as a row for each body that it pushes (a pair gives two, opposite), in that body's own frame at the end of the
/// step, whose pose is kept (where cords or hinges tie bodies that are struck, poses of all that hang together before and after the step,
/// since poses that are far apart do not tell a taut cord from a slack one): events::world_impulses() turns them back to the last bits.
class Recording {
 public:
  /// Of a world at its start.
  explicit Recording(const RigidWorld& world, const RecordingOptions& options = {});
  /// After each step of the world, with what it returned.
  /// @param broken  what broke in it; the world already holds the pieces
  void add(const RigidWorld& world, const StepRecord& step, const std::vector<Breakage>& broken = {});
  const events::EventLog& log() const { return log_; }
  const std::vector<EnergyLedger>& ledger() const { return ledger_; }              ///< one row per step, and the start
  double worst_solver_residual_m_s() const { return worst_solver_residual_m_s_; }  ///< of all steps
  double deepest_m() const { return deepest_m_; }                                  ///< of all steps

 private:
  void keep(const events::Pose& pose);
  void keep_poses(const RigidWorld& world);

  RecordingOptions options_;
  events::EventLog log_;
  std::vector<EnergyLedger> ledger_;
  std::map<int, double> kept_s_;        ///< of bodies: the latest pose that is kept
  std::map<int, events::Pose> before_;  ///< of bodies that are tied, at the end of the step before
  double next_pose_s_ = 0.0, worst_solver_residual_m_s_ = 0.0, deepest_m_ = 0.0;
};

/// Steps the world until end_s, or until all bodies rest where end_s is not given: for a tenth of a second no speed above
/// rest_speed_m_s. Stops cleanly on the monitor's wish (Interrupted). @throws InputError where it does not rest within longest_s
struct RunOptions {
  std::optional<double> end_s;
  double longest_s = 60.0;
  double rest_speed_m_s = 1e-3;
  /// Called after each step before it is written down; may change velocities, contacts' impulses, and replace bodies by pieces.
  std::function<std::vector<Breakage>(RigidWorld&, StepRecord&)> after_step = {};
};
void run(RigidWorld& world, Recording& recording, const RunOptions& options, Monitor& monitor = silent_monitor());

}  // namespace klang::rigid
