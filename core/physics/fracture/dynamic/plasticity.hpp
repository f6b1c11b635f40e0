#pragma once
#include <array>
#include <optional>

#include "core/physics/solid/material.hpp"

namespace klang::fracture {

/// Symmetric 3 x 3: xx, yy, zz, xy, yz, zx.
using Sym = std::array<double, 6>;

/// No rest shape exists for every traceless plastic strain beyond this norm: the rest metric I + eps_p loses an eigenvalue
/// (erratum 68). Green's measure: half of it.
inline constexpr double kLargestGamma2 = 1.2247448713915890;  // sqrt(3/2)
/// Where only a yield stress is given: the largest limit of D02's figures.
inline constexpr double kDefaultGamma2 = 0.486;
/// Above this norm the loss of rest volume (gamma2^2/4) is more than 2 %.
inline constexpr double kDoubtfulGamma2 = 0.3;

/// Additive plasticity (D02 section 3). Strain is B99's, eps = F^T F - I, twice Green's (erratum 17); norms are Frobenius'.
/// Zero limits (gamma2 = 0): elastic, whatever gamma1.
struct Plasticity {
  double gamma1 = 0.0;  ///< norm of the deviator of elastic strain at which it flows, >= 0
  double gamma2 = 0.0;  ///< largest norm of plastic strain, 0 <= gamma2 < sqrt(3/2)
  bool flows() const { return gamma2 > 0.0; }
  void validate() const;  ///< InputError
};

/// gamma1 = sqrt(2/3) sigma_y / mu, gamma2 = 2 limit.
/// @param yield_stress_pa  von Mises', true stress (half of B99's sigma, erratum 69), small strains
/// @param plastic_strain_limit  Frobenius norm of Green's plastic strain, below 0.6124
/// @throws InputError
Plasticity plasticity_from_yield(double yield_stress_pa, double plastic_strain_limit, const solid::Material& material);

/// What a user may say of it: by D02's thresholds or in engineering terms.
struct PlasticityInput {
  std::optional<double> gamma1, gamma2, yield_stress_pa, plastic_strain_limit;
};
/// None of the keys: elastic. A threshold without a limit: D02's largest, gamma2 = 0.486 (0 for a yield stress of 0).
/// @param name_of  how the user calls "gamma1", "gamma2", "yield_stress_pa", "plastic_strain_limit"
/// @throws InputError where both ways are mixed, a limit has no threshold, or a limit is too large
Plasticity read_plasticity(const PlasticityInput& input, const solid::Material& material,
                           std::array<const char*, 4> name_of);

/// One element's state under a strain that is given.
struct PlasticState {
  Sym plastic_strain{};              ///< eps_p, doubled measure
  Sym stress{};                      ///< sigma = lambda tr(eps_e) I + 2 mu eps_e = 2 PK2 [Pa]
  double elastic_energy_j_m3 = 0.0;  ///< sigma : eps_e / 8, per rest volume
  double dissipated_j_m3 = 0.0;      ///< since the start: sigma : d eps_p / 4, stress after the step; never falls
};

/// D02 (3)-(5): the deviator of eps - eps_p beyond gamma1 becomes plastic, then eps_p is cut to norm gamma2. 0/0 in (5) is 0.
void plastic_update(const Sym& strain, const solid::Material& material, const Plasticity& plasticity,
                    PlasticState& state);

/// Trace and inner product of symmetric tensors.
inline double trace(const Sym& a) { return a[0] + a[1] + a[2]; }
inline double inner(const Sym& a, const Sym& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

}  // namespace klang::fracture
