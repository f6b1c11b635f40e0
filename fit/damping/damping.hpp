#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/modal/damping/damping_law.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "fit/specimen/fit_parameter.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {

/// A damping law with its fitted parameters, and what acts beside the material.
struct DampingCandidate {
  const damping::DampingLaw* law = nullptr;
  std::string model;  ///< the law's name; "rayleigh_and_radiation", "..._and_mount" where these are added
  bool with_radiation = false, with_mount = false;
  std::vector<FitParameter> parameters;
  std::optional<double> aicc, aicc_weight;  ///< empty when there are too few partials
  double rms_relative_residual = 0.0;       ///< of decays
  /// Of the material, on top with_radiation the mode's radiation and with_mount the mounts' dampers.
  double decay_per_s(double angular_frequency_rad_s, double radiation_per_s = 0.0, double mount_per_kg = 0.0) const;
};

struct DampingResult {
  std::string model;                         ///< best by AICc, "" when no decay was measured
  std::vector<DampingCandidate> candidates;  ///< best first
};

/// One measured decay.
struct DecayPoint {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
  double decay_std_per_s = 0.0;  ///< 0: unknown, then scatter alone weighs
  double radiation_per_s = 0.0;  ///< the part that is known to be sound leaving the body; 0: not computed
  double mount_per_kg = 0.0;     ///< decay by a damper of 1 N s/m at each of the mounts (mount_decay_per_kg); 0: none
};

/// Decay of each mode by viscous dampers (wire, foam) at a body's mounts, for a coefficient of 1 N s/m:
///   g_i = sum over mounts of |u_i|^2 / 2, of (d . u_i)^2 / 2 where the mount has a direction d,
/// with u_i the mass-normalised shape at the surface point nearest to the mount [1/sqrt(kg)]. First order in the damper: from
/// u_i^T C u_i = 2 decay_i of a free damped oscillator; right as long as it couples no neighbours.
Eigen::VectorXd mount_decay_per_kg(const modal::ModalModel& model, const std::vector<Mount>& mounts);

/// Fits every damping law to decays, best first by AICc.
///   residual_i = ln(decay_i / model(omega_i)),  variance = (std_i / decay_i)^2 + scatter^2
/// The scatter (support losses and whatever else no material model has) is estimated for each model so that the
/// reduced chi-squared is one (Paule-Mandel), never below zero; it enters weights and intervals. Intervals are Student's,
/// cut at zero. AICc counts the scatter as a parameter and is left out with fewer partials than it needs (k + 2).
/// Where radiation is known each model comes twice, alone and beside it (model + radiation_i), so that AICc says whether
/// the split into material and air is borne out; and where there are mounts again with and without these
/// (model + c mount_i, c fitted).
/// A parameter whose relative standard deviation exceeds one half is reported as not identifiable.
/// @param points  frequency_hz and decay_per_s > 0; points whose own relative std is above 0.7 are left out
/// @param warnings  what the caller should hear, appended
DampingResult fit_damping(const std::vector<DecayPoint>& points, std::vector<std::string>& warnings);

/// The best candidate of a law, or nullptr.
const DampingCandidate* find_candidate(const DampingResult& damping, const damping::DampingLaw& law);

/// What acts on a mode beside the material.
struct OtherDecay {
  double radiation_per_s = 0.0;
  double mount_per_kg = 0.0;  ///< times the mounts' coefficient, the parameter after the law's own
};

/// ln(decay + radiation + c mount) of a law, and its derivatives: what Ceres minimises over, exposed for the gradient
/// checker.
/// @param parameters  the law's, and c where mount_per_kg > 0
/// @param gradient    by each of these
double log_total_decay(const damping::DampingLaw& law, const double* parameters, double angular_frequency_rad_s,
                       const OtherDecay& other, double* gradient);

}  // namespace klang::fit
