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
  double elements_per_wavelength = 6.0;  ///< of the sound
  double elements_per_pattern = 6.0;     ///< of the wavelength of the mode on the surface
  int min_elements = 300;                ///< at most max_elements, where the modal mesh allows
  int max_elements = 12000;              ///< bounds memory to 24 (max_elements / 2)^2 bytes per solve
  bool allow_coarse = false;
  bool leave_out_coarse = false;  ///< modes that max_elements do not resolve are left out instead of refused
  OrderOptions order;
  opencl::DeviceChoice device;  ///< of the boundary elements
  void validate() const;        ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"medium", "The fluid around"}, self.medium);
    visit({"elements_per_wavelength", "Boundary elements per wavelength of sound", between(2.0, 40.0)},
          self.elements_per_wavelength);
    visit({"elements_per_pattern", "Boundary elements per wavelength of the mode on the surface", between(2.0, 40.0)},
          self.elements_per_pattern);
    visit({"min_elements", "Boundary elements at least", between(20.0, 40000.0)}, self.min_elements);
    visit({"max_elements", "Boundary elements at most", between(20.0, 40000.0)}, self.max_elements);
    visit({"allow_coarse", "Accept fewer than 4 elements per wavelength"}, self.allow_coarse);
    visit({"leave_out_coarse", "Leave out modes with fewer than 4 elements per wavelength"}, self.leave_out_coarse);
    visit({"order", "How far the multipoles go"}, self.order);
  }
};

struct RadiateResult {
  RadiateStatus status = RadiateStatus::kNotRun;
  std::string message;
  TransferModel transfer;                            ///< modes in order of frequency
  int n_left_out = 0;                                ///< leave_out_coarse
  std::vector<int> n_elements_of_level;              ///< boundary-element meshes used, coarse to fine
  std::string device = "processor", device_message;  ///< BemResult, of the last new mode
  std::map<std::string, double> wall_time_s;         ///< "surface", "coarsen", "static", "solve", "total"
  bool usable() const { return status == RadiateStatus::kDone; }
};

/// Radiation of every mode. Frequencies share meshes: the surface is coarsened to sizes a factor 2^(1/4) apart, each
/// mode takes the coarsest that has elements_per_wavelength and elements_per_pattern, and all that does not depend on the
/// frequency is done once a mesh. Modes run in parallel, each on one thread.
/// @param known  modes of an earlier run of the same model and options that was stopped: taken as they are
/// @param done   told each new mode as it is finished, one at a time, in no certain order
/// @throws InputError for a surface that does not close, and for a frequency that the finest mesh does not resolve
///   (unless leave_out_coarse)
RadiateResult radiate(const modal::ModalModel& model, const RadiateOptions& options = {},
                      Monitor& monitor = silent_monitor(), const std::vector<ModeTransfer>& known = {},
                      const std::function<void(const ModeTransfer&)>& done = {});

}  // namespace klang::acoustics
