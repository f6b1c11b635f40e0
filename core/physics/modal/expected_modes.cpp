#include "core/physics/modal/expected_modes.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"

namespace klang::modal {

BodySize size_of(const mesh::TetMesh& mesh) {
  if (mesh.n_elements() == 0) return {};
  return {mesh::mesh_volume_m3(mesh), mesh::surface_area_m2(mesh::boundary_surface(mesh))};
}

double expected_modes(const BodySize& size, const solid::Material& material, double frequency_hz) {
  if (!(size.volume_m3 > 0.0)) return 0.0;
  const double omega = 2.0 * kPi * frequency_hz, shear = material.shear_speed_m_s();
  const double pressure = std::sqrt((material.lame_lambda_pa + 2.0 * material.lame_mu_pa) / material.density_kg_m3);
  const double bulk =
      size.volume_m3 * std::pow(omega, 3) * (std::pow(pressure, -3) + 2.0 * std::pow(shear, -3)) / (6.0 * kPi * kPi);
  const double nu = material.poissons_ratio(), thickness = 2.0 * size.volume_m3 / size.surface_m2;
  const double slowness =
      std::sqrt(12.0 * material.density_kg_m3 * (1.0 - nu * nu) / material.youngs_modulus_pa()) / thickness;
  return std::max(bulk, 0.5 * size.surface_m2 * omega * slowness / (4.0 * kPi));
}

void check_expected_modes(std::string_view place, double expected, double frequency_hz, double most) {
  if (expected <= most) return;
  throw InputError(place, "has too many modes up to " + to_text(std::round(frequency_hz)) + " Hz",
                   "some " + to_text(std::pow(10.0, std::round(std::log10(expected)))),
                   "up to " + to_text(most) + ": a lower band, a count, or lengths in m and moduli in Pa");
}

}  // namespace klang::modal
