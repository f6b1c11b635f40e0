#include "core/sound/liquid_scene/transfer_stage.hpp"
#include "core/sound/liquid_scene/stage_watch.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"

namespace klang::liquid_scene {

void run_transfer(StageRun& run) {
  const StageWatch watch;
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
  LiquidTransfer found;
  if (!paths.empty()) found = find_transfer(frames.get(), paths, run.scene, 1, run.monitor);
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
  constexpr double kDoubtful = 0.2;
  if (found.error_estimate && !(*found.error_estimate <= kDoubtful))
    run.warn("the transfer is off by an estimated " + std::to_string(std::lround(100.0 * *found.error_estimate)) +
             " % (median of samples): elements of the air, cells or waves of the liquid are too coarse for its surface "
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
  run.document.transfer = TransferRecord{to_text(method), found.error_estimate, found.modes_hz};
  run.document.stages.transfer = StageRecord{StageStatus::kDone, watch.seconds(), watch.cpu_s(), found.n_solves};
  run.folder.write_document(run.document);
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
