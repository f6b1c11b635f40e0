#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/modal/modal_model.hpp"
#include "fit/specimen/fit_parameter.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {

enum class DampingKind { kRayleigh, kLossFactor, kMassOnly, kStiffnessOnly, kZener };

/// decay_per_s(omega) of a candidate: Rayleigh (a omega^2 + b)/2; loss factor eta omega/2; mass b/2; stiffness a omega^2/2;
/// Zener (D/2) omega (omega tau)/(1 + (omega tau)^2).
struct DampingCandidate {
  DampingKind kind = DampingKind::kRayleigh;
  std::string model;  ///< "rayleigh", "loss_factor", "mass_only", "stiffness_only", "zener";
                      ///< "rayleigh_and_radiation", "..._and_mount" where these are added
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

/// Fits the five damping models to decays, best first by AICc.
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

/// "rayleigh", "loss_factor", "mass_only", "stiffness_only", "zener".
std::string to_text(DampingKind kind);

/// The candidate of a kind, or nullptr.
const DampingCandidate* find_candidate(const DampingResult& damping, DampingKind kind);

/// ln decay of a candidate and its derivatives by the solver's scaled parameters: what Ceres minimises over, exposed
/// for the gradient checker. parameters: the candidate's parameters in the order of DampingCandidate::parameters.
/// @return ln decay; gradient (n_parameters) by each parameter
double log_decay(DampingKind kind, const double* parameters, double angular_frequency_rad_s, double* gradient);

/// The same with what acts beside the material: ln(decay + radiation + c mount), c the parameter after the material's own
/// (read, and its derivative written, only where mount_per_kg > 0).
double log_total_decay(DampingKind kind, const double* parameters, double angular_frequency_rad_s,
                       double radiation_per_s, double mount_per_kg, double* gradient);

}  // namespace klang::fit
