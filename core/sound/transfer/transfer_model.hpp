#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/sound/waves/medium.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

/// How one mode sounds outside: the pressure for a modal velocity of amplitude 1 (kg^1/2 m/s, mass-normalised shapes), so
/// that the vibrating energy is 1/2 J.
struct ModeTransfer {
  int mode = 0;  ///< index in the modal model
  double frequency_hz = 0.0;
  Multipole multipole;
  double radiated_power_w = 0.0;       ///< time average at unit modal velocity, far away (order without limit)
  double decay_radiation_per_s = 0.0;  ///< power / (2 energy) = radiated_power_w / (1 J)
  double kept_power_fraction = 0.0;    ///< power of the multipole / radiated_power_w
  int n_bem_elements = 0;
  std::optional<double> residual;  ///< relative residual of the boundary-element solve
};

/// Radiation of a modal model (architecture: acoustics::TransferModel); modes in order of frequency.
struct TransferModel {
  Medium medium;
  std::vector<ModeTransfer> modes;
};

/// The same body gamma times as large, of the same material: multipole by with_size_factor(multipole, gamma, unit velocity),
/// frequency / gamma, power (unit velocity) and decay / gamma.
ModeTransfer with_size_factor(const ModeTransfer& mode, double gamma);
TransferModel with_size_factor(const TransferModel& model, double gamma);

}  // namespace klang::acoustics
