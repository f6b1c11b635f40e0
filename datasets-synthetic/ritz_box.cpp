#include "datasets-synthetic/ritz_box.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "datasets-synthetic/detail/legendre.hpp"

namespace klang::datasets {
namespace {

struct BasisFunction {
  int axis;                    // displacement component
  std::array<int, 3> degrees;  // of the Legendre polynomials in x, y, z
};

std::vector<BasisFunction> block_basis(const std::array<int, 3>& parity, const std::array<int, 3>& orders) {
  std::vector<BasisFunction> basis;
  for (int axis = 0; axis < 3; ++axis) {
    // Strains mix d(u_x)/dx with d(u_y)/dy: each component is odd in its own direction where u_x is even in
    // x, ...
    std::array<int, 3> odd = parity;
    if (axis != 0) {
      odd[0] ^= 1;
      odd[static_cast<std::size_t>(axis)] ^= 1;
    }
    for (int i = odd[0]; i <= orders[0]; i += 2) {
      for (int j = odd[1]; j <= orders[1]; j += 2) {
        for (int k = odd[2]; k <= orders[2]; k += 2) basis.push_back({axis, {i, j, k}});
      }
    }
  }
  return basis;
}

// Each block but two holds one rigid motion: translations (000), (110), (101), rotations (010), (001), (111).
int rigid_modes_in_block(const std::array<int, 3>& p) {
  const bool none = (p[0] == 1 && p[1] == 0 && p[2] == 0) || (p[0] == 0 && p[1] == 1 && p[2] == 1);
  return none ? 0 : 1;
}

Eigen::MatrixXd block_stiffness(const std::vector<BasisFunction>& basis,
                                const std::array<detail::LegendreIntegrals, 3>& integrals,
                                const solid::Material& material) {
  const auto n = static_cast<Eigen::Index>(basis.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(n, n);
  // int d_a(phi) d_b(psi), the basis being orthonormal: each direction gives its integral of values and
  // slopes.
  const auto integral = [&](const BasisFunction& phi, const BasisFunction& psi, int a, int b) {
    double product = 1.0;
    for (int d = 0; d < 3; ++d) {
      const auto e = static_cast<std::size_t>(d);
      const int i = phi.degrees[e], k = psi.degrees[e];
      if (d == a && d == b) {
        product *= integrals[e].slope_slope(i, k);
      } else if (d == a) {
        product *= integrals[e].value_slope(k, i);
      } else if (d == b) {
        product *= integrals[e].value_slope(i, k);
      } else if (i != k) {
        return 0.0;
      }
    }
    return product;
  };
  for (Eigen::Index col = 0; col < n; ++col) {
    const BasisFunction& psi = basis[static_cast<std::size_t>(col)];
    for (Eigen::Index row = col; row < n; ++row) {
      const BasisFunction& phi = basis[static_cast<std::size_t>(row)];
      const int a = phi.axis, b = psi.axis;
      double value =
          material.lame_lambda_pa * integral(phi, psi, a, b) + material.lame_mu_pa * integral(phi, psi, b, a);
      if (a == b) {
        for (int c = 0; c < 3; ++c) value += material.lame_mu_pa * integral(phi, psi, c, c);
      }
      stiffness(row, col) = value;
    }
  }
  return stiffness;
}

constexpr int kHighestOrder = 40;
constexpr std::size_t kLargestBlock = 8000;  // half a GB a matrix, minutes to solve

/// @throws InputError where the band holds waves too short for kHighestOrder: the frequencies would be too high
void check_resolvable(double highest_hz, double order) {
  if (order <= kHighestOrder) return;
  throw InputError("box", "has waves too short for its polynomials up to " + to_text(highest_hz) + " Hz",
                   "degree " + to_text(order), "up to " + std::to_string(kHighestOrder) + ": a lower highest_hz");
}

// Degrees that resolve the shortest wave of the band to about 1e-7: pi/2 a half-wave, and some for the edges.
std::array<int, 3> default_orders(const Eigen::Vector3d& size_m, const solid::Material& material, double highest_hz) {
  const double thickness = size_m.minCoeff();
  const double nu = material.poissons_ratio();
  const double plate = std::sqrt(material.youngs_modulus_pa() * thickness * thickness /
                                 (12.0 * material.density_kg_m3 * (1.0 - nu * nu)));
  const double bending_m = std::sqrt(2.0 * kPi * plate / highest_hz);
  const double shear_m = 0.9 * material.shear_speed_m_s() / highest_hz;
  std::array<int, 3> orders{};
  for (int d = 0; d < 3; ++d) {
    const bool thin = size_m[d] < 0.5 * size_m.maxCoeff() && size_m[d] <= thickness * 1.5;
    const double wave_m = thin ? shear_m : std::min(bending_m, shear_m);
    const double half_waves = 2.0 * size_m[d] / wave_m;
    const double order = std::ceil((thin ? 7.0 : 10.0) + 1.6 * half_waves);
    check_resolvable(highest_hz, order);
    orders[static_cast<std::size_t>(d)] = std::max(static_cast<int>(order), 3);
  }
  return orders;
}

}  // namespace

RitzBox::RitzBox(const Eigen::Vector3d& size_m, const solid::Material& material, const RitzBoxOptions& options)
    : size_m_(size_m), orders_(options.orders) {
  validate(material);
  const std::array<const char*, 3> names = {"length_m", "width_m", "height_m"};
  for (int d = 0; d < 3; ++d) checked_open("box", names[static_cast<std::size_t>(d)], size_m[d], 0.0, 1e3);
  checked_open("box", "highest_hz", options.highest_hz, 0.0, 1e9);
  const std::array<int, 3> automatic = default_orders(size_m, material, options.highest_hz);
  for (std::size_t d = 0; d < 3; ++d) {
    if (orders_[d] == 0) orders_[d] = automatic[d];
    checked("box", "order", orders_[d], 3, kHighestOrder);
  }
  const std::size_t largest = block_basis({0, 0, 0}, orders_).size();
  checked("box", "number of products of one parity", static_cast<double>(largest), 1, kLargestBlock);
  std::array<detail::LegendreIntegrals, 3> integrals = {detail::LegendreIntegrals(orders_[0], size_m[0]),
                                                        detail::LegendreIntegrals(orders_[1], size_m[1]),
                                                        detail::LegendreIntegrals(orders_[2], size_m[2])};
  const double highest_sq = std::pow(2.0 * kPi * options.highest_hz, 2);

  std::array<std::vector<std::pair<double, Mode>>, 8> blocks;
  for_each_job(8, [&](std::size_t b) {
    const BlasThreads one_thread(1);
    const std::array<int, 3> parity = {static_cast<int>(b >> 2), static_cast<int>(b >> 1 & 1), static_cast<int>(b & 1)};
    const auto basis = block_basis(parity, orders_);
    const Eigen::MatrixXd stiffness = block_stiffness(basis, integrals, material);
    // Rather more than a block of this body can hold in the band; doubled in the rare case that they are not
    // enough.
    for (int count = 24;; count *= 2) {
      const auto pairs = detail::lowest_eigenpairs(stiffness, count);
      const Eigen::VectorXd omega_sq = pairs.values / material.density_kg_m3;
      if (omega_sq[omega_sq.size() - 1] <= highest_sq && omega_sq.size() < stiffness.rows()) continue;
      for (Eigen::Index k = rigid_modes_in_block(parity); k < omega_sq.size() && omega_sq[k] <= highest_sq; ++k) {
        const Eigen::VectorXd c = pairs.vectors.col(k) / std::sqrt(material.density_kg_m3);
        blocks[b].push_back({std::sqrt(omega_sq[k]), {parity, {c.data(), c.data() + c.size()}}});
      }
      break;
    }
  });
  std::vector<std::pair<double, Mode>> all;
  for (auto& block : blocks) std::move(block.begin(), block.end(), std::back_inserter(all));
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  omega_.resize(static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    omega_[static_cast<Eigen::Index>(i)] = all[i].first;
    modes_.push_back(std::move(all[i].second));
  }
}

Eigen::MatrixXd RitzBox::shapes_at(const Eigen::Vector3d& point_m) const {
  std::array<Eigen::VectorXd, 3> values;
  for (int d = 0; d < 3; ++d) {
    values[static_cast<std::size_t>(d)] =
        detail::legendre_values(orders_[static_cast<std::size_t>(d)], size_m_[d], point_m[d]);
  }
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(3, n_modes());
  for (Eigen::Index m = 0; m < n_modes(); ++m) {
    const Mode& mode = modes_[static_cast<std::size_t>(m)];
    std::size_t i = 0;
    for (const BasisFunction& f : block_basis(mode.parity, orders_)) {
      shapes(f.axis, m) +=
          mode.coefficients[i++] * values[0][f.degrees[0]] * values[1][f.degrees[1]] * values[2][f.degrees[2]];
    }
  }
  return shapes;
}

}  // namespace klang::datasets
