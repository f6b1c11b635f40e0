#include "core/physics/fracture/quasistatic/strength_energy.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"

namespace klang::fracture {
namespace {

constexpr double kRoundOff = 1e-9;

double uniaxial_strain_modulus_pa(const solid::Material& material) {
  return material.lame_lambda_pa + 2.0 * material.lame_mu_pa;
}

}  // namespace

double principal_stress_bound_pa(const solid::Material& material, double energy_density_j_m3) {
  return std::sqrt(2.0 * uniaxial_strain_modulus_pa(material) * std::max(0.0, energy_density_j_m3));
}

double strength_energy_j(const solid::Material& material, const Eigen::VectorXd& volume_m3,
                         const Eigen::VectorXd& strength_pa) {
  KLANG_CHECK(volume_m3.size() > 0 && volume_m3.size() == strength_pa.size(), "a strength per element");
  const double least = (strength_pa.array().square() * volume_m3.array()).minCoeff();
  return (1.0 - kRoundOff) * least / (2.0 * uniaxial_strain_modulus_pa(material));
}

}  // namespace klang::fracture
