#include "core/soundbank/ellipsoid_radiation.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>

#include "core/acoustics/helmholtz_basis.hpp"
#include "core/base/conventions.hpp"
#include "core/base/errors.hpp"
#include "core/base/parallel.hpp"
#include "core/base/quadrature.hpp"
#include "core/soundbank/detail/shell_kernel.hpp"

extern "C" {
void zgels_(const char* trans, const int* m, const int* n, const int* n_rhs, std::complex<double>* a, const int* lda,
            std::complex<double>* b, const int* ldb, std::complex<double>* work, const int* lwork, int* info);
}

namespace klang::soundbank {
namespace {

using Complex = std::complex<double>;

/// Directions cos(phi) sin(theta), sin(phi) sin(theta), cos(theta) of one octant; weights of the sphere.
struct Octant {
  Eigen::VectorXd theta, phi, theta_weights, phi_weights;
  Eigen::Index size() const { return theta.size() * phi.size(); }
  Eigen::Vector3d direction(Eigen::Index i) const {
    const double t = theta[i / phi.size()], p = phi[i % phi.size()];
    return {std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
  }
  double weight(Eigen::Index i) const { return theta_weights[i / phi.size()] * phi_weights[i % phi.size()]; }
};

/// Gauss in cos(theta), even steps in phi.
Octant even_octant(int n_theta, int n_phi) {
  const QuadratureRule rule = gauss_rule(2 * n_theta);
  Octant octant{rule.points.tail(n_theta).array().acos(), Eigen::VectorXd(n_phi), rule.weights.tail(n_theta),
                Eigen::VectorXd::Constant(n_phi, 0.5 * kPi / n_phi)};
  for (int j = 0; j < n_phi; ++j) octant.phi[j] = (j + 0.5) * 0.5 * kPi / n_phi;
  return octant;
}

const QuadratureRule& cached_gauss_rule(int n) {
  thread_local std::vector<QuadratureRule> rules(201);
  if (rules[n].points.size() == 0) rules[n] = gauss_rule(n);
  return rules[n];
}

/// Gauss points of a variable s on [0, pi/2] with ds/dx = 1 / sqrt((x - centre)^2 + near^2) + 1 / far: crowded at the centre, where
/// the integrand nearly is singular, and nowhere further apart than `far` wants.
void crowded_rule(double centre, double near, double far, double density, Eigen::VectorXd& points, Eigen::VectorXd& weights) {
  const auto s_of = [&](double x) { return std::asinh((x - centre) / near) + (x - centre) / far; };
  const auto slope = [&](double x) { return 1.0 / std::hypot(x - centre, near) + 1.0 / far; };
  const double first = s_of(0.0), last = s_of(0.5 * kPi);
  const int n = std::clamp(static_cast<int>(std::ceil(density * (last - first))), 4, 200);
  const QuadratureRule& rule = cached_gauss_rule(n);
  points.resize(n);
  weights.resize(n);
  double low = 0.0;
  for (int i = 0; i < n; ++i) {
    const double s = first + 0.5 * (1.0 + rule.points[i]) * (last - first);
    double high = 0.5 * kPi, x = 0.5 * (low + high);
    for (int step = 0; step < 100; ++step) {  // Newton between bounds
      const double wrong = s_of(x) - s;
      (wrong > 0.0 ? high : low) = x;
      double next = x - wrong / slope(x);
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (std::abs(next - x) <= 1e-15) break;
      x = next;
    }
    points[i] = x;
    weights[i] = rule.weights[i] * 0.5 * (last - first) / slope(x);
    low = x;
  }
}

/// The problem with the axes turned so that the polar axis of theta is the one about which the body is rounder.
struct Frame {
  std::array<int, 3> axis;  ///< body's axis of each axis here
  Eigen::Vector3d axes;
  int mode_class = 0;
  Frame(const Eigen::Vector3d& body_axes, int body_class) {
    Eigen::Index thin = 0, thick = 0;
    body_axes.minCoeff(&thin);
    body_axes.maxCoeff(&thick);
    if (thin == thick) thick = (thin + 2) % 3;
    const Eigen::Index middle = 3 - thin - thick;
    const bool about_thin = body_axes[middle] / body_axes[thick] > body_axes[thin] / body_axes[middle];
    const int polar = static_cast<int>(about_thin ? thin : thick);
    axis = {(polar + 1) % 3, (polar + 2) % 3, polar};
    for (int d = 0; d < 3; ++d) {
      axes[d] = body_axes[axis[d]];
      mode_class |= (body_class >> axis[d] & 1) << d;
    }
  }
  Eigen::Vector3d to_body(const Eigen::Vector3d& here) const {
    Eigen::Vector3d there;
    for (int d = 0; d < 3; ++d) there[axis[d]] = here[d];
    return there;
  }
};

/// Real spherical harmonics of a class: P_n^m(cos theta) times cos or sin(m phi), m and n - m of one parity each.
struct ClassHarmonics {
  int degree;
  bool sine;
  std::vector<int> orders;          ///< m
  std::vector<Eigen::Index> first;  ///< column of the lowest n of each m; and the number of columns
  ClassHarmonics(int mode_class, int highest) : degree(highest), sine((mode_class & 2) != 0) {
    const int m_parity = (mode_class & 1) ^ (mode_class >> 1 & 1), n_parity = mode_class >> 2 & 1;
    Eigen::Index columns = 0;
    for (int m = m_parity; m + n_parity <= degree; m += 2) {
      if (sine && m == 0) continue;
      orders.push_back(m);
      first.push_back(columns);
      columns += (degree - m - n_parity) / 2 + 1;
    }
    first.push_back(columns);
    step_ = n_parity;
    for (const int m : orders)
      for (int n = m; n <= degree; ++n) {
        const double square = static_cast<double>(n + 1) * (n + 1) - static_cast<double>(m) * m;
        const double up = std::sqrt((4.0 * (n + 1) * (n + 1) - 1.0) / square);
        const double down = n > m ? std::sqrt((static_cast<double>(n) * n - static_cast<double>(m) * m) / (4.0 * n * n - 1.0)) : 0.0;
        recurrence_.push_back({up, up * down});
      }
  }
  Eigen::Index size() const { return first.back(); }

  /// Orthonormal P_n^m at an angle, all columns.
  void legendre(double theta, double* values) const {
    const double z = std::cos(theta), s = std::sin(theta);
    double diagonal = std::sqrt(0.25 / kPi);  // of m = 0
    const std::pair<double, double>* coefficient = recurrence_.data();
    int m = 0;
    for (std::size_t i = 0; i < orders.size(); ++i) {
      for (; m < orders[i]; ++m) diagonal *= s * std::sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0));
      double before = 0.0, now = diagonal;
      Eigen::Index at = first[i];
      for (int n = m; n <= degree; ++n) {
        if ((n - m) % 2 == step_) values[at++] = now;
        const double next = coefficient->first * z * now - coefficient->second * before;
        ++coefficient;
        before = now;
        now = next;
      }
    }
  }
  double around(std::size_t i, double phi) const { return sine ? std::sin(orders[i] * phi) : std::cos(orders[i] * phi); }

 private:
  int step_ = 0;
  std::vector<std::pair<double, double>> recurrence_;  // by m, then n
};

/// Points on an ellipsoid over directions of an octant.
struct EllipsoidPoints {
  Eigen::Matrix3Xd xi, points_m, normals;
  Eigen::VectorXd areas_m2;
  EllipsoidPoints(const Eigen::Vector3d& axes, const Octant& octant)
      : xi(3, octant.size()), points_m(3, octant.size()), normals(3, octant.size()), areas_m2(octant.size()) {
    for (Eigen::Index i = 0; i < octant.size(); ++i) {
      xi.col(i) = octant.direction(i);
      points_m.col(i) = axes.cwiseProduct(xi.col(i));
      normals.col(i) = xi.col(i).cwiseQuotient(axes);
      const double length = normals.col(i).norm();
      areas_m2[i] = axes.prod() * length * octant.weight(i);
      normals.col(i) /= length;
    }
  }
};

struct Resolution {
  int degree;      ///< of the density
  double density;  ///< quadrature points a unit of the crowded variable
};

class Shell {
 public:
  Shell(const EllipsoidModes& modes, const ModeId& mode, double k, const Resolution& resolution)
      : modes_(modes), mode_(mode), k_(k), resolution_(resolution), frame_(modes.axes_m(), mode.mode_class),
        harmonics_(frame_.mode_class, resolution.degree) {
    // A confocal ellipsoid: the field continues smoothly that far into the body.
    const double thin = frame_.axes.minCoeff();
    inner_ = (frame_.axes.array().square() - kDepth * thin * thin).sqrt();
    eta_ = std::max(k, 1.0 / frame_.axes.maxCoeff());
  }

  /// False where the normal displacement is rounding: torsion of bodies of revolution.
  static bool moves_normally(const EllipsoidModes& modes, const ModeId& mode) {
    const EllipsoidPoints at(modes.axes_m(), even_octant(16, 16));
    const Eigen::Matrix3Xd u = modes.shape_at(mode, at.xi);
    return u.cwiseProduct(at.normals).colwise().sum().norm() > 1e-7 * u.norm();
  }

  /// Least squares, and the relative error at other points.
  void solve() {
    const int side = resolution_.degree / 2 + 3;
    const EllipsoidPoints fit(frame_.axes, even_octant(side, side));
    const Eigen::MatrixXcd matrix = system_matrix(fit);
    const int rows = static_cast<int>(matrix.rows()), functions = static_cast<int>(matrix.cols()), one = 1;
    // Columns of length 1 and a ridge far below the tolerance: high degrees hardly reach the surface.
    const Eigen::VectorXd scale = matrix.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
    const int stacked = rows + functions;
    Eigen::MatrixXcd system = Eigen::MatrixXcd::Zero(stacked, functions);
    system.topRows(rows) = matrix * scale.asDiagonal();
    system.bottomRows(functions).diagonal().setConstant(1e-10);
    Eigen::VectorXcd x = Eigen::VectorXcd::Zero(stacked);
    x.head(rows) = weighted_velocity(fit).cast<Complex>();
    std::vector<Complex> work(static_cast<std::size_t>(functions) * 65 + 64);
    const int lwork = static_cast<int>(work.size());
    int info = 0;
    zgels_("N", &stacked, &functions, &one, system.data(), &stacked, x.data(), &stacked, work.data(), &lwork, &info);
    if (info != 0) throw NumericalError("ellipsoid radiation: least squares failed");
    coefficients_ = scale.asDiagonal() * x.head(functions);

    const EllipsoidPoints check(frame_.axes, even_octant(side / 2 + 1, side / 2 + 2));
    const Eigen::VectorXcd wanted = weighted_velocity(check).cast<Complex>();
    error = (system_matrix(check) * coefficients_ - wanted).norm() / wanted.norm();
    significant = std::min(1.0, wanted.norm() / (kHardlyNormal * displacement(check)));
    n_unknowns = functions;
    n_equations = rows;
  }

  /// M_n^m to an order from the density: -ik int sigma (d/dnu + i eta) conj(R_n^m), for normal velocity as right-hand side.
  Eigen::VectorXcd multipole(int order) const;

  double error = 0.0;
  double significant = 1.0;  ///< below 1 where the surface hardly moves along its normal: torsion of nearly round bodies
  int n_unknowns = 0, n_equations = 0;

 private:
  static constexpr double kDepth = 0.85;
  static constexpr double kHardlyNormal = 0.03;

  /// Root of the integral of the squared displacement over the boundary's octant.
  double displacement(const EllipsoidPoints& at) const {
    Eigen::Matrix3Xd xi(3, at.xi.cols());
    for (Eigen::Index i = 0; i < xi.cols(); ++i) xi.col(i) = frame_.to_body(at.xi.col(i));
    return std::sqrt(modes_.shape_at(mode_, xi).colwise().squaredNorm().dot(at.areas_m2));
  }

  /// sqrt(area) times the normal velocity at points of the boundary.
  Eigen::VectorXd weighted_velocity(const EllipsoidPoints& at) const {
    Eigen::Matrix3Xd xi(3, at.xi.cols());
    for (Eigen::Index i = 0; i < xi.cols(); ++i) xi.col(i) = frame_.to_body(at.xi.col(i));
    const Eigen::Matrix3Xd u = modes_.shape_at(mode_, xi);
    Eigen::VectorXd velocity(xi.cols());
    for (Eigen::Index i = 0; i < xi.cols(); ++i) velocity[i] = u.col(i).dot(frame_.to_body(at.normals.col(i))) * std::sqrt(at.areas_m2[i]);
    return velocity;
  }

  Eigen::MatrixXcd system_matrix(const EllipsoidPoints& boundary) const {
    Eigen::MatrixXcd matrix(boundary.areas_m2.size(), harmonics_.size());
    Octant around;
    detail::SourceColumns sources;
    std::vector<double> re, im, legendre(static_cast<std::size_t>(harmonics_.size()));
    Eigen::VectorXcd line(harmonics_.size());
    Eigen::MatrixXd cosines;
    const double far = 3.0 / resolution_.degree;
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
      const Eigen::Vector3d xi = boundary.xi.col(row), x = boundary.points_m.col(row), n = boundary.normals.col(row);
      const double theta = std::acos(xi[2]), phi = std::atan2(xi[1], xi[0]);
      const double gap = (x - inner_.cwiseProduct(xi)).norm();
      const Eigen::Vector3d by_theta(std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi), -std::sin(theta));
      const Eigen::Vector3d by_phi(-xi[1], xi[0], 0.0);
      crowded_rule(theta, gap / inner_.cwiseProduct(by_theta).norm(), far, resolution_.density, around.theta, around.theta_weights);
      crowded_rule(phi, gap / inner_.cwiseProduct(by_phi).norm(), far, resolution_.density, around.phi, around.phi_weights);
      const Eigen::Index n_theta = around.theta.size(), n_phi = around.phi.size(), size = n_theta * n_phi;
      sources.n_padded = static_cast<std::size_t>((size + 7) / 8 * 8);
      re.resize(sources.n_padded);
      im.resize(sources.n_padded);
      for (int d = 0; d < 3; ++d) {
        sources.points_m[d].resize(sources.n_padded);
        sources.normals[d].resize(sources.n_padded);
      }
      const Eigen::VectorXd cos_phi = around.phi.array().cos(), sin_phi = around.phi.array().sin();
      std::size_t at = 0;
      const auto put = [&](double s, double z, Eigen::Index j) {
        const Eigen::Vector3d direction(s * cos_phi[j], s * sin_phi[j], z);
        const Eigen::Vector3d nu = direction.cwiseQuotient(inner_) * inner_.minCoeff();
        for (int d = 0; d < 3; ++d) {
          sources.points_m[d][at] = inner_[d] * direction[d];
          sources.normals[d][at] = nu[d];
        }
        ++at;
      };
      for (Eigen::Index i = 0; i < n_theta; ++i) {
        const double s = std::sin(around.theta[i]), z = std::cos(around.theta[i]);
        for (Eigen::Index j = 0; j < n_phi; ++j) put(s, z, j);
      }
      while (at < sources.n_padded) put(std::sin(around.theta[n_theta - 1]), std::cos(around.theta[n_theta - 1]), n_phi - 1);
      detail::mirrored_normal_derivative(sources, {{x[0], x[1], x[2]}, {n[0], n[1], n[2]}}, frame_.mode_class, k_, eta_, re.data(), im.data());
      const auto n_orders = static_cast<Eigen::Index>(harmonics_.orders.size());
      cosines.resize(n_phi, n_orders);
      for (Eigen::Index m = 0; m < n_orders; ++m)
        for (Eigen::Index j = 0; j < n_phi; ++j)
          cosines(j, m) = around.phi_weights[j] * harmonics_.around(static_cast<std::size_t>(m), around.phi[j]);
      const Eigen::Map<const Eigen::MatrixXd> kernel_re(re.data(), n_phi, n_theta), kernel_im(im.data(), n_phi, n_theta);
      const Eigen::MatrixXd sum_re = cosines.transpose() * kernel_re, sum_im = cosines.transpose() * kernel_im;  // n_orders x n_theta
      line.setZero();
      for (Eigen::Index i = 0; i < n_theta; ++i) {
        harmonics_.legendre(around.theta[i], legendre.data());
        const double weight = around.theta_weights[i] * std::sin(around.theta[i]) * std::sqrt(boundary.areas_m2[row]);
        for (Eigen::Index m = 0; m < n_orders; ++m) {
          const Complex value = weight * Complex(sum_re(m, i), sum_im(m, i));
          for (Eigen::Index f = harmonics_.first[m]; f < harmonics_.first[m + 1]; ++f) line[f] += value * legendre[f];
        }
      }
      matrix.row(row) = line.transpose();
    }
    return matrix;
  }

  const EllipsoidModes& modes_;
  const ModeId mode_;
  const double k_;
  const Resolution resolution_;
  const Frame frame_;
  const ClassHarmonics harmonics_;
  Eigen::Vector3d inner_;
  double eta_ = 0.0;
  Eigen::VectorXcd coefficients_;
};

Eigen::VectorXcd Shell::multipole(int order) const {
  const acoustics::HelmholtzBasis basis(order);
  Eigen::VectorXcd value, sum = Eigen::VectorXcd::Zero(basis.size());
  Eigen::MatrixX3cd gradient;
  // The regular functions are smooth on the shell: the degrees of density and basis decide.
  const int side = (resolution_.degree + order) / 4 + 6;
  const Octant octant = even_octant(side, side);
  std::vector<double> legendre(static_cast<std::size_t>(harmonics_.size()));
  for (Eigen::Index j = 0; j < octant.size(); ++j) {
    const Eigen::Vector3d direction = octant.direction(j);
    harmonics_.legendre(octant.theta[j / octant.phi.size()], legendre.data());
    Complex density = 0.0;
    for (std::size_t m = 0; m < harmonics_.orders.size(); ++m) {
      const double around = harmonics_.around(m, octant.phi[j % octant.phi.size()]);
      for (Eigen::Index f = harmonics_.first[m]; f < harmonics_.first[m + 1]; ++f) density += coefficients_[f] * (around * legendre[f]);
    }
    const Eigen::Vector3d nu = frame_.to_body(direction.cwiseQuotient(inner_) * inner_.minCoeff());
    basis.values_and_gradients(acoustics::Wave::kRegular, k_, frame_.to_body(inner_.cwiseProduct(direction)), value, gradient);
    sum += octant.weight(j) * density * ((gradient * nu).conjugate() + Complex(0.0, eta_) * value.conjugate());
  }
  const int mode_class = mode_.mode_class;
  const bool odd_x = (mode_class & 1) != 0, odd_y = (mode_class & 2) != 0, odd_z = (mode_class & 4) != 0;
  // The octant's sum holds every class. Folding: cos(m phi) for even y, sin(m phi) for odd y.
  Eigen::VectorXcd folded = Eigen::VectorXcd::Zero(sum.size());
  for (int n = 0; n <= order; ++n)
    for (int m = 0; m <= n; ++m) {
      if ((m % 2 == 1) != (odd_x != odd_y) || ((n - m) % 2 == 1) != odd_z || (odd_y && m == 0)) continue;
      const Complex plus = sum[acoustics::basis_index(n, m)], minus = sum[acoustics::basis_index(n, -m)];
      const double sign = m % 2 == 0 ? 1.0 : -1.0;  // Y_n^-m = (-1)^m conj(Y_n^m)
      const Complex part = odd_y ? 0.5 * (plus - sign * minus) : 0.5 * (plus + sign * minus);
      folded[acoustics::basis_index(n, m)] = 8.0 * part;
      folded[acoustics::basis_index(n, -m)] = m == 0 ? 8.0 * part : (odd_y ? -sign : sign) * 8.0 * part;
    }
  return Complex(0.0, -k_) * folded;
}

}  // namespace

void EllipsoidRadiationOptions::validate() const {
  medium.validate();
  order.validate();
  checked("ellipsoid radiation", "boundary_tolerance", boundary_tolerance, 1e-8, 0.1);
  if (max_refinements < 0 || max_refinements > 8)
    throw InputError("ellipsoid radiation", "max_refinements", std::to_string(max_refinements), "0 to 8");
}

EllipsoidRadiation radiate(const EllipsoidModes& modes, const ModeId& mode, const EllipsoidRadiationOptions& options) {
  options.validate();
  const BlasThreads one(1);
  const double omega = modes.angular_frequency_rad_s(mode), k = omega / options.medium.sound_speed_m_s;
  const double ka = k * modes.axes_m().maxCoeff();
  EllipsoidRadiation result;
  acoustics::Multipole& multipole = result.multipole;
  multipole.wavenumber_per_m = k;
  result.moves_normally = Shell::moves_normally(modes, mode);
  if (!result.moves_normally) {  // the surface slides along itself: no sound
    multipole.order = std::min(acoustics::lowest_order(ka, options.order), 200);
    multipole.coefficients_pa = Eigen::VectorXcd::Zero(acoustics::basis_size(multipole.order));
    result.kept_power_fraction = 1.0;
    return result;
  }
  Resolution resolution{static_cast<int>(std::ceil(ka)) + 10, 2.2};
  auto shell = std::make_unique<Shell>(modes, mode, k, resolution);
  shell->solve();
  for (int step = 0; step < options.max_refinements && !(shell->error * shell->significant <= options.boundary_tolerance); ++step) {
    resolution.degree += 6;
    resolution.density *= 1.2;
    auto finer = std::make_unique<Shell>(modes, mode, k, resolution);
    finer->solve();
    if (finer->error <= shell->error) shell = std::move(finer);
  }
  const Complex source_factor(0.0, -omega * options.medium.density_kg_m3);  // dp/dn = -i omega rho v_n

  result.boundary_error = shell->error;
  result.n_unknowns = shell->n_unknowns;
  result.n_equations = shell->n_equations;
  multipole.order = std::min(static_cast<int>(std::ceil(ka)) + 10 + static_cast<int>(0.2 * ka), 200);
  multipole.coefficients_pa = source_factor * shell->multipole(multipole.order);
  const Eigen::VectorXd power = acoustics::power_by_order_w(multipole, options.medium);
  result.radiated_power_w = power.sum();
  int order = std::min(acoustics::lowest_order(ka, options.order), multipole.order);
  double kept = power.head(order + 1).sum();
  while (order < multipole.order && !(kept >= options.order.kept_power_fraction * result.radiated_power_w)) kept += power[++order];
  if (options.order.fixed_order) order = std::min(*options.order.fixed_order, multipole.order);
  multipole = acoustics::truncated(multipole, order);
  result.kept_power_fraction = power.head(order + 1).sum() / result.radiated_power_w;
  return result;
}

}  // namespace klang::soundbank
