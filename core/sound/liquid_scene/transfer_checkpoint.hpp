#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/bubble/time_series.hpp"
#include "core/sound/dual_domain/transfer_series.hpp"
#include "core/sound/liquid_scene/cell_ear_state.hpp"

namespace klang::liquid_scene {

/// Error estimate of one solve, by what it comes from.
struct TransferError {
  double frequency_hz = 0.0;
  double relative = 0.0;  ///< all of it
  /// Bins of frequency, elements of the air, cells of the liquid, the air's age; 0: not told apart.
  double bins = 0.0, air = 0.0, cells = 0.0, age = 0.0;
};

struct LiquidTransfer {
  std::vector<std::vector<bubble::TransferSeries::Row>> rows;  ///< of each path; empty: it is not heard
  std::int64_t n_solves = 0;
  std::int64_t n_iterations = 0;                 ///< of the liquid's cells, all solves
  std::int64_t n_airs = 0;                       ///< how often the air's elements were made
  std::vector<TransferError> errors;             ///< of samples of the solves
  std::size_t n_half_space = 0;                  ///< bubbles that were never in the main body: by half_space_transfer
  std::int64_t n_not_converged = 0;              ///< solves of the liquid's cells: by half_space_transfer instead
  std::size_t n_bad_frames = 0;                  ///< left out: their surface is no closed boundary
  std::string bad_frame;                         ///< why, of the first
  std::vector<double> modes_hz;                  ///< of the tank, in the first frame that was solved, up to 20 kHz
  std::optional<double> error_estimate() const;  ///< median of the errors
  /// In which the median of all solves lies with 90 % at least: two of the sorted errors, by the binomial law (whatever their own law is). None
  /// where fewer than 5 were checked.
  std::optional<std::array<double, 2>> error_interval() const;
};

/// All that the rest of a transfer depends on, between two frames.
struct TransferCheckpoint {
  std::uint64_t next_frame = 0;
  double wall_s = 0.0, cpu_s = 0.0;  ///< of all runs so far
  LiquidTransfer found;
  bool by_cells = true;                    ///< until a surface is none for cells
  std::optional<std::uint64_t> air_frame;  ///< from whose surface the air's elements are
  CellEarState cells;
};

/// @param key  of the run; of 64 characters
void write_transfer_checkpoint(const std::filesystem::path& path, const std::string& key,
                               TransferCheckpoint checkpoint);
/// None: there is none, or it is another run's. @throws InputError where it is damaged
std::optional<TransferCheckpoint> read_transfer_checkpoint(const std::filesystem::path& path, const std::string& key);

}  // namespace klang::liquid_scene
