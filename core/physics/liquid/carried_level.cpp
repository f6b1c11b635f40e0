#include "core/physics/liquid/carried_level.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.hpp"

namespace klang::liquid {

using Eigen::Vector3d;

void correct_by_carried(const GridShape& shape, const Particles& particles, const CarriedLevel& options, Field& phi) {
  const double h = shape.cell_m, near = options.near_cells * h, most = options.most_cells * h,
               least = options.least_cells * h;
  std::vector<std::array<double, 2>> sums(phi.size(), {0.0, 0.0});  // weight, weight times difference
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const double carried = particles.phi_m[p];
    if (!(std::abs(carried) < near)) continue;
    const Vector3d g = particles.x_m[p] / h - Vector3d::Constant(0.5);
    const double difference = carried - trilinear(phi, g.x(), g.y(), g.z());
    const double off = std::copysign(std::clamp(std::abs(difference) - least, 0.0, most), difference);
    const GridPlace at(phi, g.x(), g.y(), g.z());
    for (int corner = 0; corner < 8; ++corner) {
      const int a = corner & 1, b = (corner >> 1) & 1, c = corner >> 2;
      const double weight = (a != 0 ? at.x : 1.0 - at.x) * (b != 0 ? at.y : 1.0 - at.y) * (c != 0 ? at.z : 1.0 - at.z);
      if (!(weight > 0.0)) continue;
      std::array<double, 2>& sum = sums[phi.index(at.i + a, at.j + b, at.k + c)];
      sum[0] += weight;
      sum[1] += weight * off;
    }
  }
  for (std::size_t c = 0; c < phi.size(); ++c)
    if (sums[c][0] > 0.0 && std::abs(phi[c]) < options.band_cells * h)
      phi[c] += sums[c][1] / std::max(sums[c][0], options.full_weight);
}

void update_carried(const GridShape& shape, const Field& before, const Field& now, const CarriedLevel& options,
                    Particles& particles) {
  const double h = shape.cell_m, near = options.near_cells * h;
  parallel_for(particles.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const Vector3d& x = particles.x_m[p];
      double& carried = particles.phi_m[p];
      const double there = at_centres(now, x, h);
      carried = std::abs(carried) < near ? std::clamp(carried + there - at_centres(before, x, h), there - h, there + h)
                                         : there;
    }
  });
}

}  // namespace klang::liquid
