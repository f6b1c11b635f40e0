#include "core/sound/waves/multipole.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};
constexpr int kHighestOrder = 200;

void check_field(const SurfaceField& field, double k) {
  const Eigen::Index n = field.points_m.cols();
  KLANG_CHECK(n > 0 && field.normals.cols() == n && field.weights_m2.size() == n && field.pressure_pa.size() == n &&
                  field.normal_velocity_m_s.size() == n,
              "a surface field has one normal, weight, pressure and velocity per point");
  checked_open("multipole", "wavenumber_per_m", k, 0.0, 1e6);
}

double radius_about(const SurfaceField& field, const Eigen::Vector3d& centre) {
  return (field.points_m.colwise() - centre).colwise().norm().maxCoeff();
}

}  // namespace

void OrderOptions::validate() const { validate_fields("multipole order", *this); }

Eigen::VectorXcd multipole_coefficients(const SurfaceField& field, double wavenumber_per_m, const Medium& medium,
                                        const Eigen::Vector3d& centre_m, int order) {
  check_field(field, wavenumber_per_m);
  const double k = wavenumber_per_m;
  const Complex by_velocity = -kI * (k * medium.sound_speed_m_s * medium.density_kg_m3);  // dp/dn = -i omega rho v_n
  const HelmholtzBasis basis(order + 1);
  const Eigen::Index n_points = field.points_m.cols();

  // Moments with conj(R): of dp/dn, and of p times the three parts of the normal that the ladder needs. The gradient of R
  // at each point is then never formed. A fixed number of chunks keeps the sum the same on any number of threads.
  constexpr Eigen::Index kChunks = 32, kBlock = 64;
  const Eigen::Index chunk = std::max<Eigen::Index>(kBlock, (n_points + kChunks - 1) / kChunks);
  const auto n_chunks = static_cast<std::size_t>((n_points + chunk - 1) / chunk);
  std::vector<Eigen::MatrixXcd> partial(n_chunks);
  parallel_for(n_chunks, 1, [&](std::size_t begin, std::size_t end) {
    Eigen::VectorXcd values;
    Eigen::MatrixXcd functions(basis.size(), kBlock), weights(kBlock, 4);
    for (std::size_t c = begin; c < end; ++c) {
      const Eigen::Index first = static_cast<Eigen::Index>(c) * chunk, last = std::min(n_points, first + chunk);
      Eigen::MatrixXcd sum = Eigen::MatrixXcd::Zero(basis.size(), 4);
      for (Eigen::Index block = first; block < last; block += kBlock) {
        const Eigen::Index n = std::min(kBlock, last - block);
        for (Eigen::Index q = 0; q < n; ++q) {
          const Eigen::Index i = block + q;
          basis.values(Wave::kRegular, k, field.points_m.col(i) - centre_m, values);
          functions.col(q) = values.conjugate();
          const Complex p = field.weights_m2[i] * field.pressure_pa[i];
          const Eigen::Vector3d normal = field.normals.col(i);
          weights(q, 0) = field.weights_m2[i] * by_velocity * field.normal_velocity_m_s[i];
          weights(q, 1) = p * normal.z();
          weights(q, 2) = p * Complex(0.5 * normal.x(), 0.5 * normal.y());   // goes with conj(d+ R)
          weights(q, 3) = p * Complex(0.5 * normal.x(), -0.5 * normal.y());  // goes with conj(d- R)
        }
        sum.noalias() += functions.leftCols(n) * weights.topRows(n);
      }
      partial[c] = std::move(sum);
    }
  });
  Eigen::MatrixXcd moments = partial[0];
  for (std::size_t c = 1; c < n_chunks; ++c) moments += partial[c];

  Eigen::VectorXcd coefficients(basis_size(order));
  for (int n = 0; n <= order; ++n) {
    for (int m = -n; m <= n; ++m) {
      const Ladder ladder(n, m);
      Complex slope = -ladder.z_up * moments(basis_index(n + 1, m), 1) +
                      ladder.plus_up * moments(basis_index(n + 1, m + 1), 2) -
                      ladder.minus_up * moments(basis_index(n + 1, m - 1), 3);
      if (std::abs(m) <= n - 1) slope += ladder.z_down * moments(basis_index(n - 1, m), 1);
      if (std::abs(m + 1) <= n - 1) slope += ladder.plus_down * moments(basis_index(n - 1, m + 1), 2);
      if (std::abs(m - 1) <= n - 1) slope -= ladder.minus_down * moments(basis_index(n - 1, m - 1), 3);
      coefficients[basis_index(n, m)] = kI * k * (moments(basis_index(n, m), 0) - k * slope);
    }
  }
  return coefficients;
}

double surface_power_w(const SurfaceField& field) {
  return 0.5 *
         (field.weights_m2.array() * (field.pressure_pa.array() * field.normal_velocity_m_s.array().conjugate()).real())
             .sum();
}

int lowest_order(double ka, const OrderOptions& options) {
  if (options.paper_rule) return static_cast<int>(std::ceil(std::max(0.5 * ka, 4.0)));
  return static_cast<int>(std::ceil(ka)) + 2;
}

MultipoleResult multipole_from_surface(const SurfaceField& field, double wavenumber_per_m, const Medium& medium,
                                       const Eigen::Vector3d& centre_m, const OrderOptions& options) {
  options.validate();
  medium.validate();
  check_field(field, wavenumber_per_m);
  MultipoleResult result;
  result.radius_m = radius_about(field, centre_m);
  result.surface_power_w = surface_power_w(field);
  const double ka = wavenumber_per_m * result.radius_m;
  const int floor_order = options.fixed_order.value_or(lowest_order(ka, options));
  // j_n(ka)^2, and with it the power of degree n, falls below 1e-12 of the whole within 6 (ka)^(1/3) + 6 orders above ka.
  const int converged_order = static_cast<int>(std::ceil(ka + 6.0 * std::cbrt(ka) + 6.0));
  const int limit = options.fixed_order.value_or(options.max_order);
  const int highest =
      std::max(std::min(std::max(converged_order, floor_order), limit), options.fixed_order.value_or(0));

  Multipole whole{centre_m, wavenumber_per_m, highest, {}};
  whole.coefficients_pa = multipole_coefficients(field, wavenumber_per_m, medium, centre_m, highest);
  result.power_by_order_w = power_by_order_w(whole, medium);
  result.series_power_w = result.power_by_order_w.sum();
  int order = std::min(floor_order, highest);
  double kept = result.power_by_order_w.head(order + 1).sum();
  if (!options.paper_rule && !options.fixed_order) {
    while (order < highest && !(kept >= options.kept_power_fraction * result.series_power_w)) {
      kept += result.power_by_order_w[++order];
    }
  }
  result.multipole = truncated(whole, order);
  result.kept_power_fraction = result.series_power_w > 0.0 ? kept / result.series_power_w : 1.0;
  const bool cut = !options.fixed_order && std::max(converged_order, floor_order) > limit && order == limit;
  result.status = cut ? MultipoleResult::Status::kOrderLimited : MultipoleResult::Status::kDone;
  return result;
}

Eigen::VectorXd power_by_order_w(const Multipole& multipole, const Medium& medium) {
  Eigen::VectorXd power(multipole.order + 1);
  const double k = multipole.wavenumber_per_m;
  const double scale = 1.0 / (2.0 * medium.density_kg_m3 * medium.sound_speed_m_s * k * k);
  for (int n = 0; n <= multipole.order; ++n) {
    power[n] = scale * multipole.coefficients_pa.segment(basis_index(n, -n), 2 * n + 1).squaredNorm();
  }
  return power;
}

double radiated_power_w(const Multipole& multipole, const Medium& medium) {
  return power_by_order_w(multipole, medium).sum();
}

Complex pressure_pa(const Multipole& multipole, const Eigen::Vector3d& x_m) {
  Eigen::VectorXcd values;
  HelmholtzBasis(multipole.order).values(Wave::kSingular, multipole.wavenumber_per_m, x_m - multipole.centre_m, values);
  return values.cwiseProduct(multipole.coefficients_pa).sum();
}

Complex pressure_pa(const Multipole& multipole, const Eigen::Vector3d& x_m, Eigen::Vector3cd& gradient_pa_m) {
  Eigen::VectorXcd values;
  Eigen::MatrixX3cd gradients;
  HelmholtzBasis(multipole.order)
      .values_and_gradients(Wave::kSingular, multipole.wavenumber_per_m, x_m - multipole.centre_m, values, gradients);
  gradient_pa_m = gradients.transpose() * multipole.coefficients_pa;
  return values.cwiseProduct(multipole.coefficients_pa).sum();
}

Complex far_field_pa_m(const Multipole& multipole, const Eigen::Vector3d& direction) {
  Eigen::VectorXcd y(basis_size(multipole.order));
  SphericalHarmonics(multipole.order).evaluate(direction, y.data());
  Complex sum = 0.0, phase = kI;
  for (int n = 0; n <= multipole.order; ++n, phase *= kI) {
    const Eigen::Index first = basis_index(n, -n), size = 2 * n + 1;
    sum += phase * y.segment(first, size).cwiseProduct(multipole.coefficients_pa.segment(first, size)).sum();
  }
  return sum / multipole.wavenumber_per_m;
}

Multipole truncated(const Multipole& multipole, int order) {
  KLANG_CHECK(order >= 0 && order <= multipole.order, "truncation order");
  Multipole shorter = multipole;
  shorter.order = order;
  shorter.coefficients_pa = multipole.coefficients_pa.head(basis_size(order)).eval();
  return shorter;
}

}  // namespace klang::acoustics
