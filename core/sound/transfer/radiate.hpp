#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/physics/modal/modal_model.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

enum class RadiateStatus { kNotRun, kDone, kFailed };

struct RadiateOptions {
  Medium medium;
  double elements_per_wavelength = 6.0;  ///< of the sound, 2 to 40
  double elements_per_pattern = 6.0;     ///< of the wavelength of the mode on the surface, 2 to 40
  int min_elements = 300;                ///< 20 to max_elements, where the modal mesh allows
  int max_elements = 12000;              ///< to 40000: bounds memory to 24 (max_elements / 2)^2 bytes a solve
  bool allow_coarse = false;             ///< fewer than 4 elements a wavelength are accepted
  OrderOptions order;
  void validate() const;  ///< InputError
};

struct RadiateResult {
  RadiateStatus status = RadiateStatus::kNotRun;
  std::string message;
  TransferModel transfer;                     ///< modes in order of frequency
  std::vector<int> n_elements_of_level;       ///< boundary-element meshes used, coarse to fine
  std::map<std::string, double> wall_time_s;  ///< "surface", "coarsen", "static", "solve", "total"
  bool usable() const { return status == RadiateStatus::kDone; }
};

/// Radiation of every mode. Frequencies share meshes: the surface is coarsened to sizes a factor 2^(1/4) apart, each
/// mode takes the coarsest that has elements_per_wavelength and elements_per_pattern, and all that does not depend on the
/// frequency is done once a mesh. Modes run in parallel, each on one thread.
/// @param known  modes of an earlier run of the same model and options that was stopped: taken as they are
/// @param done   told each new mode as it is finished, one at a time, in no certain order
/// @throws InputError for a surface that does not close, and for a frequency that the finest mesh does not resolve
RadiateResult radiate(const modal::ModalModel& model, const RadiateOptions& options = {},
                      Monitor& monitor = silent_monitor(), const std::vector<ModeTransfer>& known = {},
                      const std::function<void(const ModeTransfer&)>& done = {});

}  // namespace klang::acoustics
