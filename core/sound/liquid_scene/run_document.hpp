#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// run.json of `klang scene run` with a liquid.
namespace klang::liquid_scene {

enum class StageStatus { kRunning, kDone, kInterrupted };
constexpr auto words_of(StageStatus) {
  return std::array{Word{StageStatus::kRunning, "running"}, Word{StageStatus::kDone, "done"},
                    Word{StageStatus::kInterrupted, "interrupted"}};
}

struct StageRecord {
  StageStatus status = StageStatus::kRunning;
  double wall_time_s = 0.0, cpu_time_s = 0.0;
  std::int64_t n_steps = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"status", "done, running (or killed), interrupted"}, self.status);
    visit({"wall_time_s", "of all its runs"}, self.wall_time_s);
    visit({"cpu_time_s", "of all threads"}, self.cpu_time_s);
    visit({"n_steps", "time steps, or pieces of work"}, self.n_steps);
  }
};

struct StagesRecord {
  std::optional<StageRecord> flow, bubbles, transfer, sound;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(absent_if_empty({"flow", "the liquid moves"}), self.flow);
    visit(absent_if_empty({"bubbles", "it makes bubbles, which move"}), self.bubbles);
    visit(absent_if_empty({"transfer", "how they are heard"}), self.transfer);
    visit(absent_if_empty({"sound", "sound.wav"}), self.sound);
  }
};

struct VolumeRecord {
  double start_m3 = 0.0, end_m3 = 0.0, max_drift_relative = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"start_m3", "of the liquid at the start"}, self.start_m3);
    visit({"end_m3", "now"}, self.end_m3);
    visit({"max_drift_relative", "largest difference to start + inflow - outflow, over that (64 cells at least)"},
          self.max_drift_relative);
  }
};

struct PressureRecord {
  double max_divergence = 0.0;
  std::int64_t iterations = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"max_divergence", "largest |div u| times step of any cell and step"}, self.max_divergence);
    visit({"iterations", "of conjugate gradients, all steps"}, self.iterations);
  }
};

/// Errors of the solves that were checked, of one octave of pitch.
struct TransferErrorRecord {
  double low_hz = 0.0, high_hz = 0.0;
  std::int64_t n = 0;
  double relative = 0.0, bins = 0.0, air = 0.0, cells = 0.0, age = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"low_hz", "of the octave"}, self.low_hz);
    visit({"high_hz", "of the octave"}, self.high_hz);
    visit({"n", "solves that were checked"}, self.n);
    visit({"relative", "median of their error estimates"}, self.relative);
    visit({"bins", "median of what the air's bins of frequency have in it; 0 where not told apart"}, self.bins);
    visit({"air", "of the part of the air's elements"}, self.air);
    visit({"cells", "of the part of the liquid's cells"}, self.cells);
    visit({"age", "of the part of the air's age"}, self.age);
  }
};

struct TransferRecord {
  std::string method;
  std::optional<double> error_estimate;
  std::int64_t n_checked = 0;
  std::optional<std::array<double, 2>> error_interval;
  std::vector<TransferErrorRecord> errors;
  std::int64_t n_iterations = 0, n_not_converged = 0, n_airs = 0;
  std::vector<double> tank_modes_hz;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"method", "reciprocal, forward, half_space or unit"}, self.method);
    visit(null_if_empty({"error_estimate", "relative, median of the solves that were checked; null: none was"}),
          self.error_estimate);
    visit({"n_checked", "solves that were checked"}, self.n_checked);
    visit(null_if_empty(
              {"error_interval",
               "between these two the median lies (90 %); null: fewer than 5 were checked, it is not determined"}),
          self.error_interval);
    visit({"errors", "the same octave by octave, and where it comes from"}, self.errors);
    visit({"n_iterations", "of the liquid's cells, summed over the solves"}, self.n_iterations);
    visit({"n_not_converged", "solves of the liquid's cells that did not: the half space's value stands there"},
          self.n_not_converged);
    visit({"n_airs", "how often the air's elements were made"}, self.n_airs);
    visit({"tank_modes_hz", "of the first frame's liquid with free surface and rigid walls, up to the highest pitch"},
          self.tank_modes_hz);
  }
};

struct HeardLiquidRecord {
  std::string file = "sound.wav";
  double duration_s = 0.0, sample_rate_hz = 0.0, peak_pressure_pa = 0.0, gain = 1.0;
  int n_channels = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"file", "beside run.json"}, self.file);
    visit({"duration_s", "its length"}, self.duration_s);
    visit({"sample_rate_hz", "its rate"}, self.sample_rate_hz);
    visit({"n_channels", "1, or 2 ears"}, self.n_channels);
    visit({"peak_pressure_pa", "largest at the listener; 0: silent"}, self.peak_pressure_pa);
    visit({"gain", "full scale of the file per Pa; a sound below 0 dB re 20 uPa is not raised to the peak asked for"},
          self.gain);
  }
};

/// What became of the liquid's surface that went under.
struct EntrainmentRecord {
  std::int64_t n_seeds = 0, n_attempts = 0, n_refused = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_seeds", "markers that fell fast enough for long enough"}, self.n_seeds);
    visit({"n_attempts", "to make a bubble at one, and in patches"}, self.n_attempts);
    visit({"n_refused", "of these, for want of coverage by seeds"}, self.n_refused);
  }
};

struct ImportRecord {
  std::string kind;
  bool has_velocity = false;
  std::vector<double> low_m;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"kind", "vdb, vtp or openfoam"}, self.kind);
    visit({"has_velocity", "the frames say how the liquid moves: it can entrain bubbles"}, self.has_velocity);
    visit({"low_m", "where the box's low corner lies in the files (z up, metres)"}, self.low_m);
  }
};

struct RunDocument {
  ResultHeader header;
  std::string name, run, flow_run, bubbles_run;
  double end_s = 0.0;
  std::int64_t n_frames = 0;
  StagesRecord stages;
  VolumeRecord volume;
  std::int64_t n_particles = 0, n_cells = 0;
  PressureRecord pressure;
  std::int64_t n_bubbles = 0, n_solves = 0;
  double births_per_s = 0.0;
  std::optional<std::uint64_t> bubbles_seed;
  std::optional<EntrainmentRecord> entrainment;
  std::optional<TransferRecord> transfer;
  std::optional<HeardLiquidRecord> sound;
  std::optional<ImportRecord> imported;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the scene"}, self.name);
    visit({"run", "SHA-256 of the program's version, the scene and its files: whose folder this is"}, self.run);
    visit({"flow_run", "the same of the tables that move the liquid alone"}, self.flow_run);
    visit({"bubbles_run", "the same of these and those that make bubbles"}, self.bubbles_run);
    visit({"end_s", "how far the flow has come"}, self.end_s);
    visit({"n_frames", "that are written"}, self.n_frames);
    visit({"stages", "what is done"}, self.stages);
    visit({"volume", "of the liquid"}, self.volume);
    visit({"n_particles", "now"}, self.n_particles);
    visit({"n_cells", "of the box"}, self.n_cells);
    visit({"pressure", "what its solver left"}, self.pressure);
    visit({"n_bubbles", "born"}, self.n_bubbles);
    visit({"n_solves", "of the transfer"}, self.n_solves);
    visit({"births_per_s", "n_bubbles over the length"}, self.births_per_s);
    visit(absent_if_empty({"bubbles_seed", "of the bubbles; later stages may have another"}), self.bubbles_seed);
    visit({"entrainment", "what became of seeds, where any are asked for"}, self.entrainment);
    visit(null_if_empty({"transfer", "how bubbles are heard; null: not done"}), self.transfer);
    visit(null_if_empty({"sound", "what was heard; null: not done"}), self.sound);
    visit(absent_if_empty({"imported", "from another program's files"}), self.imported);
  }
};

/// A row of solids.csv: one per step, and one at the start, of each solid that moves.
struct SolidRow {
  double time_s = 0.0;
  std::int64_t solid = 0;
  std::string name;
  double x_m = 0.0, y_m = 0.0, z_m = 0.0, velocity_x_m_s = 0.0, velocity_y_m_s = 0.0, velocity_z_m_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "end of the step"}, self.time_s);
    visit({"solid", "which [[solid]] of the scene, from 1"}, self.solid);
    visit({"name", "its name"}, self.name);
    visit({"x_m", "centre"}, self.x_m);
    visit({"y_m", "centre"}, self.y_m);
    visit({"z_m", "centre"}, self.z_m);
    visit({"velocity_x_m_s", "that moved it in this step"}, self.velocity_x_m_s);
    visit({"velocity_y_m_s", "that moved it in this step"}, self.velocity_y_m_s);
    visit({"velocity_z_m_s", "that moved it in this step"}, self.velocity_z_m_s);
  }
};

/// A row of flow.csv, one per step.
struct FlowRow {
  double time_s = 0.0, volume_m3 = 0.0, inflow_m3 = 0.0, outflow_m3 = 0.0, max_speed_m_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "end of the step"}, self.time_s);
    visit({"volume_m3", "of the liquid"}, self.volume_m3);
    visit({"inflow_m3", "since the start"}, self.inflow_m3);
    visit({"outflow_m3", "since the start"}, self.outflow_m3);
    visit({"max_speed_m_s", "of the liquid"}, self.max_speed_m_s);
  }
};

}  // namespace klang::liquid_scene
