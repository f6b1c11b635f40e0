#pragma once
#include <vector>

#include "fit/fit.hpp"

namespace klang::fit {

/// One measured decay.
struct DecayPoint {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
  double decay_std_per_s = 0.0;  ///< 0: unknown, then scatter alone weighs
  double radiation_per_s = 0.0;  ///< the part that is known to be sound leaving the body; 0: not computed
};

/// Fits the five damping models to decays, best first by AICc.
///   residual_i = ln(decay_i / model(omega_i)),  variance = (std_i / decay_i)^2 + scatter^2
/// The scatter (support losses and whatever else no material model has) is estimated for each model so that the
/// reduced chi-squared is one (Paule-Mandel), never below zero; it enters weights and intervals. Intervals are Student's,
/// cut at zero. AICc counts the scatter as a parameter and is left out with fewer partials than it needs (k + 2).
/// Where radiation is known each model comes twice, alone and beside it (model + radiation_i), so that AICc says whether
/// the split into material and air is borne out.
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

}  // namespace klang::fit
