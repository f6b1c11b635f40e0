#include "core/physics/fracture/dynamic/plasticity.hpp"

#include <cmath>
#include <string>

#include "core/foundation/base/errors.hpp"

namespace klang::fracture {

void Plasticity::validate() const {
  checked("plasticity", "gamma1", gamma1, 0.0, 10.0);
  if (!(gamma2 >= 0.0 && gamma2 < kLargestGamma2))
    throw InputError("plasticity", "gamma2 is out of range", to_text(gamma2),
                     "0 to below sqrt(3/2) = 1.2247, where every rest shape exists");
}

Plasticity plasticity_from_yield(double yield_stress_pa, double plastic_strain_limit, const solid::Material& material) {
  checked("plasticity", "yield_stress_pa", yield_stress_pa, 0.0, 10.0 * material.lame_mu_pa);
  Plasticity plasticity{std::sqrt(2.0 / 3.0) * yield_stress_pa / material.lame_mu_pa, 2.0 * plastic_strain_limit};
  if (!(plasticity.gamma2 >= 0.0 && plasticity.gamma2 < kLargestGamma2))
    throw InputError("plasticity", "plastic_strain_limit is out of range", to_text(plastic_strain_limit),
                     "0 to below sqrt(3/8) = 0.61237, where every rest shape exists");
  return plasticity;
}

Plasticity read_plasticity(const PlasticityInput& input, const solid::Material& material,
                           std::array<const char*, 4> name_of) {
  const bool thresholds = input.gamma1 || input.gamma2,
             engineering = input.yield_stress_pa || input.plastic_strain_limit;
  if (thresholds && engineering)
    throw InputError(name_of[input.gamma1 ? 0 : 1], "says plasticity twice", "",
                     std::string(name_of[0]) + " and " + name_of[1] + ", or " + name_of[2] + " and " + name_of[3]);
  if (!thresholds && !engineering) return {};
  const auto& threshold = thresholds ? input.gamma1 : input.yield_stress_pa;
  const auto& limit = thresholds ? input.gamma2 : input.plastic_strain_limit;
  if (!threshold) throw InputError(name_of[thresholds ? 1 : 3], "needs a threshold", "", name_of[thresholds ? 0 : 2]);
  Plasticity plasticity;
  if (thresholds) {
    plasticity = {*threshold, limit.value_or(kDefaultGamma2)};
  } else {
    plasticity =
        plasticity_from_yield(*threshold, limit.value_or(*threshold > 0.0 ? kDefaultGamma2 / 2 : 0.0), material);
  }
  plasticity.validate();
  return plasticity;
}

void plastic_update(const Sym& strain, const solid::Material& material, const Plasticity& plasticity,
                    PlasticState& state) {
  Sym elastic;
  for (std::size_t i = 0; i < 6; ++i) elastic[i] = strain[i] - state.plastic_strain[i];
  Sym flow{};
  if (plasticity.flows()) {
    Sym deviator = elastic;
    const double mean = trace(elastic) / 3.0;
    for (std::size_t i = 0; i < 3; ++i) deviator[i] -= mean;
    const double norm = std::sqrt(inner(deviator, deviator));
    if (norm > plasticity.gamma1) {
      const double excess = (norm - plasticity.gamma1) / norm;
      Sym grown;
      for (std::size_t i = 0; i < 6; ++i) grown[i] = state.plastic_strain[i] + excess * deviator[i];
      const double size = std::sqrt(inner(grown, grown));
      const double cut = size > plasticity.gamma2 ? plasticity.gamma2 / size : 1.0;
      for (std::size_t i = 0; i < 6; ++i) {
        flow[i] = cut * grown[i] - state.plastic_strain[i];
        state.plastic_strain[i] = cut * grown[i];
        elastic[i] = strain[i] - state.plastic_strain[i];
      }
    }
  }
  const double pressure = material.lame_lambda_pa * trace(elastic);
  for (std::size_t i = 0; i < 6; ++i)
    state.stress[i] = 2.0 * material.lame_mu_pa * elastic[i] + (i < 3 ? pressure : 0.0);
  state.elastic_energy_j_m3 = inner(state.stress, elastic) / 8.0;
  state.dissipated_j_m3 += inner(state.stress, flow) / 4.0;
}

}  // namespace klang::fracture
