#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace klang::solid {

/// Isotropic linear elastic solid. The Lame parameters are what is stored; E and nu are views.
struct Material {
  double lame_lambda_pa = 0.0;
  double lame_mu_pa = 0.0;
  double density_kg_m3 = 0.0;
  std::string name;    ///< "aluminium", "" for a custom one
  std::string source;  ///< where the numbers come from

  double youngs_modulus_pa() const;  ///< mu (3 lambda + 2 mu) / (lambda + mu)
  double poissons_ratio() const;     ///< lambda / (2 (lambda + mu))
  double bulk_modulus_pa() const;    ///< lambda + 2 mu / 3
  double shear_speed_m_s() const;    ///< sqrt(mu / rho)
};

/// E > 0, -1 < nu < 0.5, rho > 0; InputError otherwise.
Material from_youngs_modulus(double youngs_modulus_pa, double poissons_ratio, double density_kg_m3);

/// Throws InputError unless mu > 0, lambda + 2 mu / 3 > 0 (the energy is positive), rho > 0, all finite.
void validate(const Material& material);

/// Labelled presets; InputError for an unknown name (lists the known ones). S02's Table 1 values carry names
/// that begin with "s02_" and are no physical truth (errata 7).
Material material_preset(std::string_view name);
std::vector<std::string> material_preset_names();

}  // namespace klang::solid
