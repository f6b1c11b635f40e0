// First bending frequency of a free steel bar against the Euler-Bernoulli beam, through the installed headers.
#include <cmath>
#include <core/geometry/shapes/shape.hpp>
#include <core/physics/modal/eigen_solver.hpp>
#include <core/physics/solid/assembly.hpp>
#include <cstdio>

int main() {
  const klang::mesh::ShapeSpec bar{"box", {{"length_m", 0.2}, {"width_m", 0.02}, {"height_m", 0.002}}, {}};
  const auto material = klang::solid::from_youngs_modulus(210e9, 0.3, 7850.0);
  const auto mesh = klang::mesh::mesh_shape(bar);
  klang::modal::EigenOptions options;
  options.count = 1;
  const auto result = klang::modal::solve_modes(mesh, klang::solid::assemble(mesh), material, {}, options);
  if (!result.usable()) return 1;
  const double beam_hz = 22.3732854 / (2.0 * M_PI * 0.2 * 0.2) * std::sqrt(210e9 / 7850.0) * 0.002 / std::sqrt(12.0);
  const double found_hz = result.model.frequency_hz()[0];
  std::printf("found %.3f Hz, beam %.3f Hz\n", found_hz, beam_hz);
  return std::abs(found_hz / beam_hz - 1.0) <= 0.01 ? 0 : 1;  // the plate is a little stiffer than the beam
}
