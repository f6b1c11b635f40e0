#include "core/physics/modal/expected_modes.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/mesh/quality.hpp"

namespace klang::modal {

double expected_modes(const mesh::TetMesh& mesh, const solid::Material& material, double frequency_hz) {
  const double omega = 2.0 * kPi * frequency_hz, volume = mesh::mesh_volume_m3(mesh);
  const double surface = mesh::surface_area_m2(mesh::boundary_surface(mesh));
  const double shear = material.shear_speed_m_s();
  const double pressure = std::sqrt((material.lame_lambda_pa + 2.0 * material.lame_mu_pa) / material.density_kg_m3);
  const double bulk =
      volume * std::pow(omega, 3) * (std::pow(pressure, -3) + 2.0 * std::pow(shear, -3)) / (6.0 * kPi * kPi);
  const double nu = material.poissons_ratio(), thickness = 2.0 * volume / surface;
  const double slowness =
      std::sqrt(12.0 * material.density_kg_m3 * (1.0 - nu * nu) / material.youngs_modulus_pa()) / thickness;
  return std::max(bulk, 0.5 * surface * omega * slowness / (4.0 * kPi));
}

}  // namespace klang::modal
