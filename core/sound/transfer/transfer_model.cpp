#include "core/sound/transfer/transfer_model.hpp"

#include "core/sound/waves/multipole_transforms.hpp"

namespace klang::acoustics {

ModeTransfer with_size_factor(const ModeTransfer& mode, double gamma) {
  ModeTransfer result = mode;
  result.multipole = with_size_factor(mode.multipole, gamma, ModalUnit::kVelocity);
  result.frequency_hz /= gamma;
  result.radiated_power_w /= gamma;  // |M|^2 / k^2 ~ gamma^-3 gamma^2
  result.decay_radiation_per_s /= gamma;
  return result;
}

TransferModel with_size_factor(const TransferModel& model, double gamma) {
  TransferModel result = model;
  for (ModeTransfer& mode : result.modes) mode = with_size_factor(mode, gamma);
  return result;
}

}  // namespace klang::acoustics
