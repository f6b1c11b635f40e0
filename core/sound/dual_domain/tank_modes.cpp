#include "core/sound/dual_domain/tank_modes.hpp"

#include <algorithm>
#include <cmath>

namespace klang::bubble {

std::vector<TankMode> tank_modes(const LiquidBoundary& boundary, double sound_speed_m_s, double low_hz,
                                 double high_hz) {
  constexpr int kMost = 60;
  constexpr std::size_t kMostListed = 200;
  std::vector<TankMode> modes;
  if (!(boundary.rigid_area_m2() > boundary.free_area_m2())) return modes;  // a layer, or no vessel at all
  const mesh::Points& x = boundary.surface().vertices_m;
  const Eigen::RowVector3d size = x.colwise().maxCoeff() - x.colwise().minCoeff();
  const double depth = std::min(size.z(), boundary.volume_m3() / (size.x() * size.y()));
  for (int m = 0; m < kMost; ++m)
    for (int n = 0; n < kMost; ++n)
      for (int p = 0; p < kMost; ++p) {
        const double f =
            0.5 * sound_speed_m_s *
            std::sqrt(std::pow(m / size.x(), 2) + std::pow(n / size.y(), 2) + std::pow((p + 0.5) / depth, 2));
        if (f > high_hz) break;
        if (f >= low_hz) modes.push_back({f, m, n, p});
      }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const TankMode& a, const TankMode& b) { return a.frequency_hz < b.frequency_hz; });
  if (modes.size() > kMostListed) modes.resize(kMostListed);
  return modes;
}

}  // namespace klang::bubble
