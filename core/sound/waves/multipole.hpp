#pragma once
#include <Eigen/Core>
#include <complex>
#include <optional>
#include <string>

#include "core/sound/waves/medium.hpp"

namespace klang::acoustics {

/// Outgoing field around one point:
///   p(x) = sum_{n=0}^{order} sum_{m=-n}^{n} M_n^m h_n^(2)(k r) Y_n^m(theta, phi),  (r, theta, phi) of x - centre_m,
/// with orthonormal complex Y_n^m. M_n^m stands at row n (n + 1) + m, (order + 1)^2 rows, in Pa.
struct Multipole {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double wavenumber_per_m = 0.0;
  int order = 0;
  Eigen::VectorXcd coefficients_pa;
};

/// Pressure and outward normal velocity at the points of a quadrature rule on a closed surface, n_points each.
struct SurfaceField {
  Eigen::Matrix3Xd points_m;
  Eigen::Matrix3Xd normals;    ///< outward, length 1
  Eigen::VectorXd weights_m2;  ///< sum = area
  Eigen::VectorXcd pressure_pa;
  Eigen::VectorXcd normal_velocity_m_s;
};

/// How far the series goes.
struct OrderOptions {
  /// Smallest order whose multipoles radiate this fraction of the power of the whole series, and never below ceil(ka) + 2
  /// (a: largest distance of the surface from the centre; errata 46). 0 < fraction < 1.
  double kept_power_fraction = 0.999;
  /// SB section 4 instead: ceil(max(k L / 4, 4)) with L = 2 a. Loses most of the power of some sources at ka >= 10.
  bool paper_rule = false;
  std::optional<int> fixed_order;  ///< neither rule
  int max_order = 120;             ///< a rule that asks for more ends here, and the result says so
  void validate() const;           ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"kept_power_fraction", "Part of the radiated power that the multipoles keep", inside(0.0, 1.0)},
          self.kept_power_fraction);
    visit({"paper_rule", "Order max(kL/4, 4) instead (loses power)"}, self.paper_rule);
    visit({"fixed_order", "This order, by no rule", between(0.0, 200.0)}, self.fixed_order);
    visit({"max_order", "Highest order", between(2.0, 200.0)}, self.max_order);
  }
};

struct MultipoleResult {
  enum class Status { kNotRun, kDone, kOrderLimited };
  Status status = Status::kNotRun;
  Multipole multipole;
  double surface_power_w = 0.0;      ///< 1/2 Re integral p conj(v_n), the power that leaves the surface
  double series_power_w = 0.0;       ///< of the series carried to convergence
  double kept_power_fraction = 0.0;  ///< power of multipole / series_power_w
  Eigen::VectorXd power_by_order_w;  ///< power of degree n alone, n = 0 ... converged order
  double radius_m = 0.0;             ///< a: the series holds outside this sphere around the centre
};

/// M_n^m = ik integral( conj(R_n^m) dp/dn - p d conj(R_n^m)/dn ) dS over the closed surface, with R about the centre, outward n
/// and dp/dn = -i omega rho v_n. SB eq. 22 with the conjugate (errata 38); it follows from p = integral(p dG/dn - G dp/dn) and
/// G = -ik sum S conj(R). Cost O(n_points order^2), parallel over points, the same bits on any number of threads.
MultipoleResult multipole_from_surface(const SurfaceField& field, double wavenumber_per_m, const Medium& medium,
                                       const Eigen::Vector3d& centre_m, const OrderOptions& options = {});

/// Coefficients M_n^m to the given order alone: no rule, no power.
Eigen::VectorXcd multipole_coefficients(const SurfaceField& field, double wavenumber_per_m, const Medium& medium,
                                        const Eigen::Vector3d& centre_m, int order);

/// 1/2 Re sum weight p conj(v_n) [W], time average.
double surface_power_w(const SurfaceField& field);

/// Smallest order either rule allows before power is looked at: ceil(ka) + 2, or ceil(max(ka / 2, 4)) with paper_rule.
int lowest_order(double ka, const OrderOptions& options);

/// Power through any sphere around the multipole: sum |M_n^m|^2 / (2 rho c k^2) [W].
double radiated_power_w(const Multipole& multipole, const Medium& medium);
/// The same of degree n alone, n = 0 ... order.
Eigen::VectorXd power_by_order_w(const Multipole& multipole, const Medium& medium);

/// p(x) = sum M_n^m S_n^m(x - centre) [Pa], x != centre.
std::complex<double> pressure_pa(const Multipole& multipole, const Eigen::Vector3d& x_m);
/// p and its gradient [Pa/m]; the particle velocity is gradient i / (omega rho).
std::complex<double> pressure_pa(const Multipole& multipole, const Eigen::Vector3d& x_m,
                                 Eigen::Vector3cd& gradient_pa_m);

/// D(s) in p(r s) -> D(s) e^{-ikr} / r for r -> infinity [Pa m], direction of length 1:
///   D = (1/k) sum i^{n+1} M_n^m Y_n^m(s)
std::complex<double> far_field_pa_m(const Multipole& multipole, const Eigen::Vector3d& direction);

/// The first (order + 1)^2 coefficients.
Multipole truncated(const Multipole& multipole, int order);

}  // namespace klang::acoustics
