#pragma once
#include <Eigen/Core>
#include <complex>
#include <utility>
#include <vector>

namespace klang::soundbank::detail {

/// Directions cos(phi) sin(theta), sin(phi) sin(theta), cos(theta) of one octant, theta slow; weights of the sphere (sum pi/2).
struct Octant {
  Eigen::VectorXd theta, phi, theta_weights, phi_weights;
  Eigen::Index size() const { return theta.size() * phi.size(); }
  Eigen::Vector3d direction(Eigen::Index i) const;
  double weight(Eigen::Index i) const { return theta_weights[i / phi.size()] * phi_weights[i % phi.size()]; }
};

/// Gauss in cos(theta), even steps in phi: exact for harmonics whose degrees add up to below 4 n_theta and 4 n_phi.
Octant even_octant(int n_theta, int n_phi);

/// Gauss points of a variable s on [0, pi/2] with ds/dx = 1 / sqrt((x - centre)^2 + near^2) + 1 / far: crowded at the centre, where
/// the integrand nearly is singular, and nowhere further apart than `far` wants. `density` points a unit of s, 4 to 200 in all.
void crowded_rule(double centre, double near, double far, double density, Eigen::VectorXd& points,
                  Eigen::VectorXd& weights);

/// Real spherical harmonics of a class: P_n^m(cos theta) times cos or sin(m phi), m and n - m of one parity each. P_n^m > 0 near
/// theta = 0, normalised so that P_n^m e^{i m phi} is orthonormal on the sphere.
class ClassHarmonics {
 public:
  /// @param mode_class  bit d: odd in axis d
  ClassHarmonics(int mode_class, int degree);

  int degree() const { return degree_; }
  Eigen::Index size() const { return first_.back(); }
  bool sine() const { return sine_; }
  Eigen::Index n_orders() const { return static_cast<Eigen::Index>(orders_.size()); }
  /// m of the i-th block of columns, and the first column of it; n rises by 2 from `lowest_degree` within it.
  int order(Eigen::Index i) const { return orders_[static_cast<std::size_t>(i)]; }
  Eigen::Index first(Eigen::Index i) const { return first_[static_cast<std::size_t>(i)]; }
  Eigen::Index count(Eigen::Index i) const { return first(i + 1) - first(i); }
  int lowest_degree(Eigen::Index i) const { return order(i) + step_; }

  /// P_n^m at an angle, all columns.
  void legendre(double theta, double* values) const;
  /// cos or sin(m phi) of all blocks.
  void around(double phi, double* values) const;

 private:
  int degree_, step_;
  bool sine_;
  std::vector<int> orders_;
  std::vector<Eigen::Index> first_;
  std::vector<std::pair<double, double>> recurrence_;  // by m, then n
};

}  // namespace klang::soundbank::detail
