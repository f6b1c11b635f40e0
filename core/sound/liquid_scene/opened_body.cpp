#include "core/sound/liquid_scene/opened_body.hpp"

#include <algorithm>

#include "core/physics/liquid/distance_grid.hpp"
#include "core/physics/liquid/surface.hpp"

namespace klang::liquid_scene {

liquid::LiquidSurface opened_surface(const liquid::LiquidFrames& frames, std::size_t frame,
                                     const liquid::GridShape& shape, double radius_m, const liquid::Field& solid_m) {
  liquid::Field phi(shape.nx, shape.ny, shape.nz), deep(shape.nx, shape.ny, shape.nz);
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        phi(i, j, k) = frames.phi_m(frame, shape.centre_m(i, j, k));
        deep(i, j, k) = phi(i, j, k) + radius_m;
      }
  liquid::distance_from_zero_set(shape, deep);
  for (std::size_t c = 0; c < phi.size(); ++c) phi[c] = std::max(phi[c], deep[c] - radius_m);
  return liquid::liquid_surface(shape, phi, solid_m);
}

}  // namespace klang::liquid_scene
