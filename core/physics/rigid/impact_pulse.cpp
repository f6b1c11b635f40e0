#include "core/physics/rigid/impact_pulse.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace klang::rigid {

double contact_modulus_pa(const Skin& a, const Skin& b) {
  const auto compliance = [](const Skin& s) { return (1 - s.poissons_ratio * s.poissons_ratio) / s.youngs_modulus_pa; };
  return 1 / (compliance(a) + compliance(b));
}

double elliptic_radius_m(double larger_per_m, double smaller_per_m) {
  constexpr double kRound = 1e-6, kLongest = 1e6, kLongestAxes = 1e9;
  const double ratio = std::min(larger_per_m / smaller_per_m, kLongest);
  if (ratio <= 1 + kRound) return 2 / (larger_per_m + smaller_per_m);
  // B/A rises from 1 as the ellipse grows longer: bisection in the logarithm of its axes' ratio.
  const auto integrals = [](double axes) {
    const double e = std::sqrt((axes - 1) * (axes + 1)) / axes;
    return std::pair(std::comp_ellint_1(e), std::comp_ellint_2(e));
  };
  double low = 0, high = std::log(kLongestAxes);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high), axes = std::exp(middle);
    const auto [first, second] = integrals(axes);
    (((axes * axes * second - first) / (first - second) < ratio) ? low : high) = middle;
  }
  const double axes = std::exp(0.5 * (low + high)), e_sq = (axes - 1) * (axes + 1) / (axes * axes);
  const auto [first, second] = integrals(axes);
  return std::pow(std::acos(0.0), 2) * (first - second) / (0.5 * larger_per_m / ratio * e_sq * std::pow(first, 3));
}

double touch_radius_m(const RigidBodySpec& a, const RigidBodySpec* b, const ContactImpulse& touch) {
  const auto in_world = [](const Eigen::Quaterniond& turn, const Eigen::Matrix3d& k) -> Eigen::Matrix3d {
    return turn.toRotationMatrix() * k * turn.toRotationMatrix().transpose();
  };
  double size_m = a.size_m();
  Eigen::Matrix3d gap =
      in_world(touch.turn_a, a.curvature_at(touch.place_a_m, touch.turn_a.conjugate() * -touch.normal));
  if (b != nullptr) {
    gap += in_world(touch.turn_b, b->curvature_at(touch.place_b_m, touch.turn_b.conjugate() * touch.normal));
    size_m = std::min(size_m, b->size_m());
  }
  const Eigen::Vector3d t = touch.normal.unitOrthogonal();
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << t, touch.normal.cross(t);
  const Eigen::Vector2d k =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(tangents.transpose() * gap * tangents).eigenvalues();
  return elliptic_radius_m(std::max(k[1], 1 / size_m), std::max(k[0], 1 / size_m));
}

double hertz_duration_s(double mass_kg, double radius_m, double contact_modulus_pa, double approach_m_s) {
  static const double constant = 0.8 * std::beta(0.4, 0.5) * std::pow(15.0 / 16.0, 0.4);
  return constant *
         std::pow(mass_kg * mass_kg / (radius_m * contact_modulus_pa * contact_modulus_pa * approach_m_s), 0.2);
}

}  // namespace klang::rigid
