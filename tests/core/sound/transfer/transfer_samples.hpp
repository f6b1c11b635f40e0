#pragma once
// Transfer models of random coefficients, seeded.
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::acoustics {

// Modes of the given orders n at ka = max(n - 2, 0.2) of a body of radius 0.1 m; all of them about one centre, or each about its own.
// Coefficients of degree n are those of a wave of size about 1 on the body: 1 / |h_n(ka)| is what keeps the high ones from
// deciding all (here min(1, (ka / n)^n)).
inline TransferModel random_transfer(const std::vector<int>& orders, std::uint64_t seed, bool one_centre = true) {
  TransferModel model;
  RandomStream random(seed, 0);
  for (std::size_t i = 0; i < orders.size(); ++i) {
    ModeTransfer mode;
    mode.mode = static_cast<int>(i);
    const double ka = std::max(0.2, orders[i] - 2.0 + random.uniform(-0.1, 0.1));
    mode.multipole.wavenumber_per_m = ka / 0.1;
    mode.frequency_hz = ka / 0.1 * model.medium.sound_speed_m_s / (2 * kPi);
    mode.multipole.order = orders[i];
    mode.multipole.centre_m = {0.01, -0.02, 0.03};
    if (!one_centre)
      mode.multipole.centre_m +=
          0.01 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    mode.multipole.coefficients_pa.resize(basis_size(orders[i]));
    for (int n = 0; n <= orders[i]; ++n) {
      const double size = n > ka ? std::pow(ka / n, n) : 1.0;
      for (int m = -n; m <= n; ++m)
        mode.multipole.coefficients_pa[basis_index(n, m)] = {size * random.normal(), size * random.normal()};
    }
    mode.radiated_power_w = random.uniform(0.0, 1.0);
    mode.decay_radiation_per_s = mode.radiated_power_w;
    mode.kept_power_fraction = random.uniform(0.999, 1.0);
    mode.n_bem_elements = 100 + static_cast<int>(i);
    model.modes.push_back(mode);
  }
  return model;
}

}  // namespace klang::acoustics
