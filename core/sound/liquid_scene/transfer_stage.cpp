#include "core/sound/liquid_scene/transfer_stage.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"
#include "core/sound/liquid_scene/stage_watch.hpp"

namespace klang::liquid_scene {

namespace {

/// Time of the stage over all its runs, and the checkpoints between them.
class TransferWatch {
 public:
  explicit TransferWatch(StageRun& run) : run_(run), key_(run.document.run) {}
  std::filesystem::path file() const { return run_.folder.file("checkpoint/transfer"); }
  TransferKeep keep() {
    TransferKeep keep;
    if (run_.resume) keep.from = read_transfer_checkpoint(file(), key_);
    if (keep.from) {
      before_wall_s_ = keep.from->wall_s;
      before_cpu_s_ = keep.from->cpu_s;
    }
    keep.due = [this] { return since_.seconds() >= run_.checkpoint_s; };
    keep.keep = [this](TransferCheckpoint now) {
      now.wall_s = before_wall_s_ + watch_.seconds();
      now.cpu_s = before_cpu_s_ + watch_.cpu_s();
      note(StageStatus::kRunning, now.found);
      std::filesystem::create_directories(file().parent_path());
      write_transfer_checkpoint(file(), key_, std::move(now));
      since_.restart();
    };
    return keep;
  }
  void note(StageStatus status, const LiquidTransfer& found) {
    run_.document.n_solves = found.n_solves;
    run_.document.stages.transfer =
        StageRecord{status, before_wall_s_ + watch_.seconds(), before_cpu_s_ + watch_.cpu_s(), found.n_solves};
    run_.folder.write_document(run_.document);
  }

 private:
  StageRun& run_;
  const std::string key_;
  const StageWatch watch_;
  Stopwatch since_;
  double before_wall_s_ = 0.0, before_cpu_s_ = 0.0;
};

bool in_domain(const LiquidScene& scene, const Eigen::Vector3d& x_m) {
  return (x_m.array() > 0.0).all() && (x_m.array() < scene.setup.shape.size_m().array()).all();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TransferRecord transfer_record(TransferMethod method, const LiquidTransfer& found) {
  TransferRecord record{to_text(method),
                        found.error_estimate(),
                        static_cast<std::int64_t>(found.errors.size()),
                        found.error_interval(),
                        {},
                        found.n_iterations,
                        found.n_not_converged,
                        found.n_airs,
                        found.modes_hz};
  std::map<int, std::vector<const TransferError*>> of_octave;  // 500 Hz times a power of 2
  for (const TransferError& error : found.errors)
    of_octave[static_cast<int>(std::floor(std::log2(error.frequency_hz / 500.0)))].push_back(&error);
  for (const auto& [octave, errors] : of_octave) {
    const auto median_of = [&](double TransferError::*part) {
      std::vector<double> values;
      for (const TransferError* error : errors) values.push_back(error->*part);
      return median(std::move(values));
    };
    record.errors.push_back({500.0 * std::exp2(octave), 1000.0 * std::exp2(octave),
                             static_cast<std::int64_t>(errors.size()), median_of(&TransferError::relative),
                             median_of(&TransferError::bins), median_of(&TransferError::air),
                             median_of(&TransferError::cells), median_of(&TransferError::age)});
  }
  return record;
}

}  // namespace

void run_transfer(StageRun& run) {
  const std::vector<entrainment::BubblePath> paths =
      run.document.n_bubbles > 0 ? entrainment::read_tracked_bubbles(run.folder.file("bubbles.trk")).paths
                                 : std::vector<entrainment::BubblePath>{};
  const TransferMethod method = run.scene.transfer.method;
  const bool solved = method == TransferMethod::kReciprocal || method == TransferMethod::kForward;
  std::unique_ptr<liquid::LiquidFrames> frames;
  if (solved && !paths.empty()) {
    if (run.document.n_frames < 1)
      throw InputError("[transfer] method", "needs the liquid's frames, of which this folder has none", to_text(method),
                       "half_space or unit");
    frames = folder_frames(run.scene, run.folder, static_cast<std::size_t>(run.document.n_frames));
  }
  if (!solved && !paths.empty() && run.document.n_frames > 0) {
    const std::unique_ptr<liquid::LiquidFrames> all =
        folder_frames(run.scene, run.folder, static_cast<std::size_t>(run.document.n_frames));
    for (const std::size_t k : {std::size_t{0}, all->time_s().size() - 1})
      if (all->phi_m(k, run.scene.sound.listener.centre_m(all->time_s()[k])) < 0.0 &&
          in_domain(run.scene, run.scene.sound.listener.centre_m(all->time_s()[k])))
        throw InputError("listener", "is in the liquid at " + to_text(all->time_s()[k]) + " s");
  }
  LiquidTransfer found;
  TransferWatch watched(run);
  watched.note(StageStatus::kRunning, found);
  if (!paths.empty()) found = find_transfer(frames.get(), paths, run.scene, 1, run.monitor, watched.keep());
  std::string text = "bubble,time_s,frequency_hz,re,im\n";
  double lowest = HUGE_VAL, highest = 0.0;
  for (std::size_t i = 0; i < paths.size(); ++i)
    for (const bubble::TransferSeries::Row& row : found.rows[i]) {
      text += std::to_string(paths[i].id) + "," + to_text(row.time_s) + "," + to_text(row.frequency_hz) + "," +
              to_text(row.pressure_pa_per_m.real()) + "," + to_text(row.pressure_pa_per_m.imag()) + "\n";
      lowest = std::min(lowest, row.frequency_hz);
      highest = std::max(highest, row.frequency_hz);
    }
  write_file(run.folder.file("transfer.csv"), text);
  if (found.n_half_space > 0)
    run.warn(std::to_string(found.n_half_space) +
             " bubble(s) were never inside the largest body of liquid: they are heard as below a wide plane surface");
  if (found.n_not_converged > 0)
    run.warn(std::to_string(found.n_not_converged) + " of " + std::to_string(found.n_solves) +
             " solves of the liquid's cells did not converge: heard as below a wide plane surface there; a larger "
             "liquid_loss_factor helps");
  constexpr double kDoubtful = 0.2;
  const std::optional<double> off = found.error_estimate();
  const auto percent = [](double share) { return std::to_string(std::lround(100.0 * share)); };
  if (off && !found.error_interval())
    run.warn("how far the transfer is off is not determined: only " + std::to_string(found.errors.size()) +
             " solve(s) were checked (median " + percent(*off) + " %)");
  else if (off && !(*off <= kDoubtful))
    run.warn("the transfer is off by an estimated " + percent(*off) + " % (median of " +
             std::to_string(found.errors.size()) + " samples, 90 % interval " + percent((*found.error_interval())[0]) +
             " to " + percent((*found.error_interval())[1]) +
             " %): elements of the air, cells or waves of the liquid are too coarse for its surface "
             "or for "
             "pitches this high; method half_space is the one to compare with");
  if (found.n_bad_frames > 0)
    run.warn(std::to_string(found.n_bad_frames) + " frame(s) are left out of the transfer: " + found.bad_frame);
  std::erase_if(found.modes_hz, [&](double f) { return !(f <= highest); });
  if (solved && !found.modes_hz.empty())
    run.warn("the tank resonates from " + std::to_string(std::lround(found.modes_hz.front())) +
             " Hz on, within the bubbles' band; levels there are what liquid_loss_factor " +
             to_text(run.scene.transfer.liquid_loss_factor) + " and wall_admittance " +
             to_text(run.scene.transfer.wall_admittance) + " make them");
  run.document.n_solves = found.n_solves;
  run.document.transfer = transfer_record(method, found);
  watched.note(StageStatus::kDone, found);
  std::error_code gone;
  std::filesystem::remove(watched.file(), gone);
}

std::map<std::int64_t, std::vector<bubble::TransferSeries::Row>> read_transfers(const std::filesystem::path& path) {
  std::map<std::int64_t, std::vector<bubble::TransferSeries::Row>> rows;
  CsvFile file(path);
  file.next();  // the head
  while (file.next()) {
    const auto& cells = file.cells();
    if (cells.size() != 5)
      throw InputError(file.place(), "has a wrong number of columns", std::to_string(cells.size()), "5");
    const auto value = [&](std::size_t i) { return csv_number(cells[i], file.place()); };
    rows[static_cast<std::int64_t>(value(0))].push_back({value(1), value(2), {value(3), value(4)}});
  }
  return rows;
}

}  // namespace klang::liquid_scene
