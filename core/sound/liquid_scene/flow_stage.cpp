#include "core/sound/liquid_scene/flow_stage.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/sealed_file.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/physics/liquid/surface.hpp"
#include "core/sound/liquid_scene/stage_watch.hpp"

namespace klang::liquid_scene {
namespace {

constexpr std::uint64_t kCheckpointMagic = 0x3350434c474e4c4bULL;  // "KLNGLCP3"

/// What a checkpoint holds besides the liquid.
struct Progress {
  std::uint64_t n_frames = 0;  ///< written
  double wall_s = 0.0, cpu_s = 0.0, max_drift = 0.0, max_divergence = 0.0;
  std::int64_t iterations = 0, n_particles = 0;
};

struct CheckpointHead {
  std::uint64_t magic = kCheckpointMagic;
  char key[64] = {};
  double time_s = 0.0;
  Progress progress;
  std::uint64_t n_rows = 0, n_places = 0;
};

/// Where a solid was: a row of solids.csv without its name.
struct SolidPlace {
  double time_s;
  std::int64_t solid;  ///< of the liquid's list
  Eigen::Vector3d position_m, velocity_m_s;
};

class Flow {
 public:
  explicit Flow(StageRun& run) : run_(run), liquid_(run.scene.setup), key_(run_key(run.scene)) {
    solid_ = centres_of_solids();
    if (run_.resume) load();
    if (places_.empty()) note_solids();
  }

  FlowResult go() {
    const LiquidScene& scene = run_.scene;
    std::filesystem::create_directories(run_.folder.file("frames"));
    std::filesystem::create_directories(run_.folder.file("fields"));
    std::filesystem::create_directories(run_.folder.file("checkpoint"));
    if (progress_.n_frames == 0) {
      warn_of_small_drops();
      write_frame();
    }
    note(StageStatus::kRunning);
    FlowResult result = FlowResult::kDone;
    try {
      while (result == FlowResult::kDone && liquid_.time_s() < run_.until_s * (1.0 - 1e-12)) {
        const double next = std::min(scene.frame_s(progress_.n_frames), run_.until_s);
        liquid_.advance_to(next, [&](const liquid::LiquidStep& step) {
          take(step);
          if (result == FlowResult::kDone && !step.pressure.converged) result = FlowResult::kNotConverged;
          if (result == FlowResult::kDone && !(step.drift_relative <= kMostDrift)) result = FlowResult::kVolumeLost;
          run_.monitor.throw_if_stopped();
          if (since_checkpoint_.seconds() >= run_.checkpoint_s) save();
        });
        if (liquid_.time_s() >= scene.frame_s(progress_.n_frames) * (1.0 - 1e-12)) write_frame();
        if (since_note_.seconds() >= 1.0) note(StageStatus::kRunning);
      }
    } catch (const Interrupted&) {
      note(StageStatus::kInterrupted);
      save();
      throw;
    }
    save();
    run_.folder.write_collection(scene, progress_.n_frames);
    note(result == FlowResult::kDone ? StageStatus::kDone : StageStatus::kInterrupted);
    return result;
  }

 private:
  void take(const liquid::LiquidStep& step) {
    rows_.push_back({step.time_s, step.volume_m3, step.inflow_m3, step.outflow_m3, step.max_speed_m_s});
    note_solids();
    progress_.max_drift = std::max(progress_.max_drift, step.drift_relative);
    progress_.max_divergence = std::max(progress_.max_divergence, step.pressure.max_divergence);
    progress_.iterations += step.pressure.iterations;
    progress_.n_particles = static_cast<std::int64_t>(step.n_particles);
    run_.monitor.progress("flow", step.time_s / run_.until_s);
  }

  void warn_of_small_drops() {
    constexpr double kFewestCells = 1.5;
    const liquid::LiquidSetup& setup = run_.scene.setup;
    for (std::size_t d = 0; d < setup.drops.size(); ++d)
      if (run_.warn && setup.drops[d].radius_m < kFewestCells * setup.shape.cell_m)
        run_.warn("[[drop]] " + std::to_string(d + 1) +
                  " has a radius below 1.5 cells: its volume is up to a fifth too large (0.1 % from 1.5 cells on)");
  }

  void note_solids() {
    for (std::size_t s = 0; s < run_.scene.setup.solids.size(); ++s) {
      const liquid::Solid& solid = liquid_.solids()[s];
      if (solid.moves())
        places_.push_back({liquid_.time_s(), static_cast<std::int64_t>(s), solid.position_m, solid.velocity_m_s});
    }
  }

  std::vector<SolidRow> solid_rows() const {
    std::vector<SolidRow> rows;
    for (const SolidPlace& place : places_) {
      const Eigen::Vector3d &x = place.position_m, &v = place.velocity_m_s;
      rows.push_back({place.time_s, place.solid + 1, liquid_.solids()[static_cast<std::size_t>(place.solid)].name,
                      x.x(), x.y(), x.z(), v.x(), v.y(), v.z()});
    }
    return rows;
  }

  /// Distance to the solids at centres, the inlets' mouthpieces among them.
  liquid::Field centres_of_solids() const {
    const liquid::GridShape& shape = liquid_.shape();
    if (liquid_.solids().empty()) return {};
    liquid::Field field(shape.nx, shape.ny, shape.nz, HUGE_VAL);
    for (int k = 0; k < shape.nz; ++k)
      for (int j = 0; j < shape.ny; ++j)
        for (int i = 0; i < shape.nx; ++i)
          for (const liquid::Solid& solid : liquid_.solids())
            field(i, j, k) = std::min(field(i, j, k), solid.distance_m(shape.centre_m(i, j, k)));
    return field;
  }

  void write_frame() {
    const std::size_t frame = progress_.n_frames;
    if (std::any_of(liquid_.solids().begin(), liquid_.solids().end(), [](const auto& solid) { return solid.moves(); }))
      solid_ = centres_of_solids();
    write_surface(run_.folder.frame_file(frame), liquid::liquid_surface(liquid_.shape(), liquid_.phi_m(), solid_));
    write_fields(run_.folder.field_file(frame), liquid_.shape(), liquid_.distance_m(), liquid_.velocity_m_s());
    ++progress_.n_frames;
  }

  /// run.json and the tables, as they stand.
  void note(StageStatus status) {
    RunDocument& d = run_.document;
    const double wall = wall_.lap(), cpu = cpu_seconds();
    progress_.wall_s += wall;
    progress_.cpu_s += cpu - cpu_before_;
    cpu_before_ = cpu;
    d.stages.flow = StageRecord{status, progress_.wall_s, progress_.cpu_s, static_cast<std::int64_t>(rows_.size())};
    d.end_s = liquid_.time_s();
    d.n_frames = static_cast<std::int64_t>(progress_.n_frames);
    d.volume = {liquid_.start_volume_m3(), liquid_.volume_m3(), progress_.max_drift};
    d.n_particles = static_cast<std::int64_t>(liquid_.particles().size());
    d.n_cells = static_cast<std::int64_t>(liquid_.shape().n_cells());
    d.pressure = {progress_.max_divergence, progress_.iterations};
    run_.folder.write_document(d);
    if (since_tables_.seconds() >= 10.0 || status != StageStatus::kRunning || rows_.empty()) {
      write_file(run_.folder.file("flow.csv"), csv_table(rows_));
      if (!places_.empty()) write_file(run_.folder.file("solids.csv"), csv_table(solid_rows()));
      run_.folder.write_collection(run_.scene, progress_.n_frames);
      since_tables_.restart();
    }
    since_note_.restart();
  }

  std::filesystem::path checkpoint(int slot) const {
    return run_.folder.file(slot == 0 ? "checkpoint/a" : "checkpoint/b");
  }

  void save() {
    note(run_.document.stages.flow->status);
    CheckpointHead head;
    std::memcpy(head.key, key_.data(), std::min(key_.size(), sizeof head.key));
    head.time_s = liquid_.time_s();
    head.progress = progress_;
    head.n_rows = rows_.size();
    head.n_places = places_.size();
    slot_ = 1 - slot_;
    write_file_with(checkpoint(slot_), [&](const std::filesystem::path& temporary) {
      std::ofstream out(temporary, std::ios::binary);
      out.write(reinterpret_cast<const char*>(&head), sizeof head);
      out.write(reinterpret_cast<const char*>(rows_.data()),
                static_cast<std::streamsize>(rows_.size() * sizeof(FlowRow)));
      out.write(reinterpret_cast<const char*>(places_.data()),
                static_cast<std::streamsize>(places_.size() * sizeof(SolidPlace)));
      liquid_.save(out);
      if (!out.flush()) throw InputError(checkpoint(slot_).string(), "cannot be written", "", "room on the disk");
      out.close();
      seal_file(temporary);
    });
    since_checkpoint_.restart();
  }

  std::optional<CheckpointHead> head_of(int slot) const {
    std::ifstream in(checkpoint(slot), std::ios::binary);
    CheckpointHead head;
    if (!in || !in.read(reinterpret_cast<char*>(&head), sizeof head) || head.magic != kCheckpointMagic)
      return std::nullopt;
    if (std::string(head.key, sizeof head.key) != key_) return std::nullopt;
    return head;
  }

  /// From the later state that is whole.
  void load() {
    const std::optional<CheckpointHead> heads[2] = {head_of(0), head_of(1)};
    if (!heads[0] && !heads[1]) return;  // killed before the first one: from the start
    const int later = heads[1] && (!heads[0] || heads[1]->time_s > heads[0]->time_s) ? 1 : 0;
    slot_ = is_sealed(checkpoint(later)) ? later : 1 - later;
    if (!heads[slot_] || (slot_ != later && !is_sealed(checkpoint(slot_))))
      throw InputError(checkpoint(later).string(), "is damaged", "", "a run without --resume in another folder");
    std::ifstream in(checkpoint(slot_), std::ios::binary);
    in.seekg(sizeof(CheckpointHead));
    progress_ = heads[slot_]->progress;
    read_list(in, rows_, heads[slot_]->n_rows, checkpoint(slot_).string());
    read_list(in, places_, heads[slot_]->n_places, checkpoint(slot_).string());
    liquid_.load(in);
  }

  StageRun& run_;
  liquid::Liquid liquid_;
  std::string key_;
  liquid::Field solid_;
  Progress progress_;
  std::vector<FlowRow> rows_;
  std::vector<SolidPlace> places_;
  int slot_ = 1;
  Stopwatch wall_, since_checkpoint_, since_note_, since_tables_;
  double cpu_before_ = cpu_seconds();
};

}  // namespace

FlowResult run_flow(StageRun& run) { return Flow(run).go(); }

}  // namespace klang::liquid_scene
