#include "core/physics/modal/expected_modes.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
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

void check_expected_modes(std::string_view place, const mesh::TetMesh& mesh, const solid::Material& material,
                          double frequency_hz, bool by_mesh, double most) {
  if (mesh.n_elements() == 0) return;
  double expected = expected_modes(mesh, material, frequency_hz);
  if (by_mesh) expected = std::min(expected, 3.0 * mesh.n_nodes());
  if (expected <= most) return;
  throw InputError(place, "has too many modes up to " + to_text(std::round(frequency_hz)) + " Hz",
                   "some " + to_text(std::pow(10.0, std::round(std::log10(expected)))),
                   "up to " + to_text(most) + ": a lower band, a count, or lengths in m and moduli in Pa");
}

}  // namespace klang::modal
