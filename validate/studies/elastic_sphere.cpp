#include "validate/studies/elastic_sphere.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::validate {
namespace {

constexpr double kScanStep = 0.005;

double bessel(int l, double x) { return std::sph_bessel(static_cast<unsigned>(l), x); }

/// x j_l'(x) = l j_l(x) - x j_{l+1}(x)
double x_slope(int l, double x) { return l * bessel(l, x) - x * bessel(l + 1, x); }

double torsional_traction(int l, double x) { return (l - 1) * bessel(l, x) - x * bessel(l + 1, x); }

/// u = grad(A j_l(y r) Y) + curl curl(r B j_l(x r) Y) at r = 1; rows: sigma_rr, sigma_r theta, over mu.
double spheroidal_determinant(int l, double x, double y_over_x) {
  const double y = x * y_over_x, big_l = l * (l + 1.0);
  const double radial_p = (2.0 * big_l - x * x) * bessel(l, y) - 4.0 * x_slope(l, y);
  if (l == 0) return radial_p;
  const double radial_s = 2.0 * big_l * (x_slope(l, x) - bessel(l, x));
  const double tangential_p = 2.0 * (x_slope(l, y) - bessel(l, y));
  const double tangential_s = (2.0 * big_l - 2.0 - x * x) * bessel(l, x) - 2.0 * x_slope(l, x);
  return radial_p * tangential_s - radial_s * tangential_p;
}

template <class Function>
void add_roots(const Function& function, double highest, SphereModeKind kind, int l, std::vector<SphereMode>& modes) {
  const auto n_steps = static_cast<int>(std::ceil(highest / kScanStep));
  double left = 20.0 * kScanStep, at_left = function(left);  // no elastic root lies below x = 0.1
  for (int i = 21; i <= n_steps; ++i) {
    const double right = i * kScanStep, at_right = function(right);
    if (at_left * at_right < 0.0) {
      double low = left, high = right;
      while (true) {
        const double middle = 0.5 * (low + high);
        if (!(low < middle && middle < high)) break;
        ((function(middle) < 0.0) == (at_left < 0.0) ? low : high) = middle;
      }
      if (low <= highest) modes.push_back({kind, l, low});
    }
    left = right, at_left = at_right;
  }
}

}  // namespace

std::vector<SphereMode> elastic_sphere_modes(double poissons_ratio, double highest) {
  checked_open("elastic sphere", "poissons_ratio", poissons_ratio, -1.0, 0.5);
  checked_open("elastic sphere", "highest", highest, 0.0, 40.0 + 1e-12);
  const double y_over_x = std::sqrt((1.0 - 2.0 * poissons_ratio) / (2.0 - 2.0 * poissons_ratio));
  std::vector<SphereMode> modes;
  const int highest_degree = static_cast<int>(std::ceil(1.3 * highest)) + 2;  // the first root of degree l lies near l
  for (int l = 0; l <= highest_degree; ++l) {
    add_roots([&](double x) { return spheroidal_determinant(l, x, y_over_x); }, highest, SphereModeKind::kSpheroidal, l,
              modes);
    if (l > 0) {
      add_roots([&](double x) { return torsional_traction(l, x); }, highest, SphereModeKind::kTorsional, l, modes);
    }
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const SphereMode& a, const SphereMode& b) { return a.wavenumber_a < b.wavenumber_a; });
  return modes;
}

Eigen::VectorXd elastic_sphere_frequency_hz(double radius_m, const solid::Material& material, int count) {
  checked("elastic sphere", "radius_m", radius_m, 1e-9, 1e9);
  solid::validate(material);
  if (count < 1 || count > 2000) throw InputError("elastic sphere", "count", std::to_string(count), "1 to 2000");
  const double hz = material.shear_speed_m_s() / (2.0 * kPi * radius_m);
  for (double highest = 5.0;; highest = std::min(40.0, 1.5 * highest)) {
    std::vector<double> list;
    for (const SphereMode& mode : elastic_sphere_modes(material.poissons_ratio(), highest))
      list.insert(list.end(), static_cast<std::size_t>(mode.multiplicity()), hz * mode.wavenumber_a);
    if (static_cast<int>(list.size()) >= count) return Eigen::Map<Eigen::VectorXd>(list.data(), count);
    if (highest >= 40.0) throw InputError("elastic sphere", "count", std::to_string(count), "modes up to x = 40");
  }
}

Eigen::Vector3d torsional_displacement(int degree, double wavenumber_a, double radius_m,
                                       const Eigen::Vector3d& point_m) {
  const double r = point_m.norm(), rho = std::hypot(point_m.x(), point_m.y());
  if (!(rho > 0.0)) return Eigen::Vector3d::Zero();
  // dP_l(cos theta)/dtheta = -sin theta P_l'(cos theta), (t^2 - 1) P_l' = l (t P_l - P_{l-1})
  const double t = point_m.z() / r, sin_theta = rho / r;
  const double slope = degree == 0 ? 0.0
                                   : degree *
                                         (t * std::legendre(static_cast<unsigned>(degree), t) -
                                          std::legendre(static_cast<unsigned>(degree - 1), t)) /
                                         sin_theta;
  return bessel(degree, wavenumber_a * r / radius_m) * slope * Eigen::Vector3d(-point_m.y(), point_m.x(), 0.0) / rho;
}

}  // namespace klang::validate
