#pragma once
#include <optional>
#include <vector>

#include "core/sound/liquid_scene/flow_stage.hpp"

/// Tables of a run that its page shows.
namespace klang::liquid_scene {

/// A row of energy.csv.
struct EnergyRow {
  double time_s = 0.0, volume_m3 = 0.0, potential_j = 0.0;
  std::optional<double> kinetic_j;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "of a frame"}, self.time_s);
    visit({"volume_m3", "of its liquid"}, self.volume_m3);
    visit({"kinetic_j", "1/2 rho u^2 over its cells; empty where the frames have no velocity"}, self.kinetic_j);
    visit({"potential_j", "rho g z over them, from the box's floor"}, self.potential_j);
  }
};

/// A row of radii.csv: bubbles between two radii.
struct RadiusRow {
  double low_m = 0.0, high_m = 0.0;
  std::optional<double> asked, made, recorded;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"low_m", "from this radius"}, self.low_m);
    visit({"high_m", "to this one"}, self.high_m);
    visit({"asked", "share by the scene's distribution; empty where it has none"}, self.asked);
    visit({"made", "share of the run's bubbles"}, self.made);
    visit({"recorded", "share of the recording's, where radii come from one"}, self.recorded);
  }
};

/// By how much of its kinetic energy the liquid gained energy in the rows' last quarter, against the quarter before in which it had least:
/// the smaller of the gains of kinetic energy and of the sum. Means over quarters, since single frames are off by what planes through cells
/// are. None where that is not to be seen: fewer than 16 rows, no velocities.
std::optional<double> energy_gain(const std::vector<EnergyRow>& rows);

/// energy.csv of 200 frames at most, and, where there are bubbles, radii.csv. Warns of energy that came from nowhere: in a scene without
/// inlets, outlets and solids that move.
void write_run_tables(const StageRun& run);

}  // namespace klang::liquid_scene
