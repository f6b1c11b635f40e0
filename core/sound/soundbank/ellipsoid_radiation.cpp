#include "core/sound/soundbank/ellipsoid_radiation.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/lapack.hpp"
#include "core/sound/soundbank/detail/octant.hpp"
#include "core/sound/soundbank/detail/shell_kernel.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::soundbank {
namespace {

using Complex = std::complex<double>;
using detail::even_octant;
using detail::Octant;

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

/// Points on an ellipsoid over directions of an octant.
struct EllipsoidPoints {
  Eigen::Index n_theta, n_phi;
  Eigen::Matrix3Xd xi, points_m, normals;
  Eigen::VectorXd areas_m2;
  EllipsoidPoints(const Eigen::Vector3d& axes, const Octant& octant)
      : n_theta(octant.theta.size()),
        n_phi(octant.phi.size()),
        xi(3, octant.size()),
        points_m(3, octant.size()),
        normals(3, octant.size()),
        areas_m2(octant.size()) {
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
      : modes_(modes),
        mode_(mode),
        k_(k),
        resolution_(resolution),
        frame_(modes.axes_m(), mode.mode_class),
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
    const int side = (46 * resolution_.degree + 99) / 100 + 2;  // twice as many equations as unknowns
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
  double significant =
      1.0;  ///< below 1 where the surface hardly moves along its normal: torsion of nearly round bodies
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
    for (Eigen::Index i = 0; i < xi.cols(); ++i)
      velocity[i] = u.col(i).dot(frame_.to_body(at.normals.col(i))) * std::sqrt(at.areas_m2[i]);
    return velocity;
  }

  Eigen::MatrixXcd system_matrix(const EllipsoidPoints& boundary) const;
  detail::SourceColumns source_columns(const Octant& octant) const;

  const EllipsoidModes& modes_;
  const ModeId mode_;
  const double k_;
  const Resolution resolution_;
  const Frame frame_;
  const detail::ClassHarmonics harmonics_;
  Eigen::Vector3d inner_;
  double eta_ = 0.0;
  Eigen::VectorXcd coefficients_;
};

/// Points of the shell over an octant's directions; nu is longest, 1, where the shell is thinnest.
detail::SourceColumns Shell::source_columns(const Octant& octant) const {
  detail::SourceColumns sources;
  const auto n_phi = static_cast<std::size_t>(octant.phi.size()), size = static_cast<std::size_t>(octant.size());
  sources.n_padded = (size + 7) / 8 * 8;
  for (int d = 0; d < 3; ++d) {
    sources.points_m[d].resize(sources.n_padded);
    sources.normals[d].resize(sources.n_padded);
  }
  const double thin = inner_.minCoeff();
  std::array<Eigen::ArrayXd, 3> along{octant.phi.array().cos(), octant.phi.array().sin(),
                                      Eigen::ArrayXd::Ones(octant.phi.size())};
  for (Eigen::Index i = 0; i < octant.theta.size(); ++i) {
    const double s = std::sin(octant.theta[i]), z = std::cos(octant.theta[i]);
    for (int d = 0; d < 3; ++d) {
      const double across = d == 2 ? z : s;
      double* point = sources.points_m[d].data() + static_cast<std::size_t>(i) * n_phi;
      double* normal = sources.normals[d].data() + static_cast<std::size_t>(i) * n_phi;
      for (std::size_t j = 0; j < n_phi; ++j) {
        const double direction = across * along[static_cast<std::size_t>(d)][static_cast<Eigen::Index>(j)];
        point[j] = inner_[d] * direction;
        normal[j] = thin / inner_[d] * direction;
      }
    }
  }
  for (int d = 0; d < 3; ++d)
    for (std::size_t at = size; at < sources.n_padded; ++at) {
      sources.points_m[d][at] = sources.points_m[d][size - 1];
      sources.normals[d][at] = sources.normals[d][size - 1];
    }
  return sources;
}

/// Row: a point of the boundary; column: a harmonic. All points of one theta share the quadrature over theta, so that its Legendre
/// functions are made once and the sums over theta are products of matrices.
Eigen::MatrixXcd Shell::system_matrix(const EllipsoidPoints& boundary) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::MatrixXcd matrix(boundary.xi.cols(), harmonics_.size());
  const Eigen::Index n_orders = harmonics_.n_orders();
  const double far = 3.0 / resolution_.degree;
  Octant around;
  std::vector<double> re, im;
  RowMajor legendre, cosines;
  std::vector<RowMajor> sums(
      static_cast<std::size_t>(n_orders));  // by order: real parts over imaginary parts of the points x n_theta
  for (Eigen::Index row = 0; row < boundary.n_theta; ++row) {
    const Eigen::Index first = row * boundary.n_phi;
    double near_theta = HUGE_VAL;
    std::vector<double> near_phi(static_cast<std::size_t>(boundary.n_phi));
    for (Eigen::Index j = 0; j < boundary.n_phi; ++j) {
      const Eigen::Vector3d xi = boundary.xi.col(first + j);
      const double s = std::hypot(xi[0], xi[1]),
                   gap = (boundary.points_m.col(first + j) - inner_.cwiseProduct(xi)).norm();
      const Eigen::Vector3d by_theta(xi[2] * xi[0] / s, xi[2] * xi[1] / s, -s), by_phi(-xi[1], xi[0], 0.0);
      near_theta = std::min(near_theta, gap / inner_.cwiseProduct(by_theta).norm());
      near_phi[static_cast<std::size_t>(j)] = gap / inner_.cwiseProduct(by_phi).norm();
    }
    detail::crowded_rule(std::acos(boundary.xi(2, first)), near_theta, far, resolution_.density, around.theta,
                         around.theta_weights);
    const Eigen::Index n_theta = around.theta.size();
    legendre.resize(n_theta, harmonics_.size());
    for (Eigen::Index i = 0; i < n_theta; ++i) {
      harmonics_.legendre(around.theta[i], legendre.row(i).data());
      legendre.row(i) *= around.theta_weights[i] * std::sin(around.theta[i]);
    }
    for (RowMajor& sum : sums) sum.resize(2 * boundary.n_phi, n_theta);
    for (Eigen::Index j = 0; j < boundary.n_phi; ++j) {
      const Eigen::Index at = first + j;
      const double phi = std::atan2(boundary.xi(1, at), boundary.xi(0, at));
      detail::crowded_rule(phi, near_phi[static_cast<std::size_t>(j)], far, resolution_.density, around.phi,
                           around.phi_weights);
      const Eigen::Index n_phi = around.phi.size();
      const detail::SourceColumns sources = source_columns(around);
      re.resize(sources.n_padded);
      im.resize(sources.n_padded);
      const auto x = boundary.points_m.col(at), n = boundary.normals.col(at);
      detail::mirrored_normal_derivative(sources, {{x[0], x[1], x[2]}, {n[0], n[1], n[2]}}, frame_.mode_class, k_, eta_,
                                         re.data(), im.data());
      cosines.resize(n_phi, n_orders);
      for (Eigen::Index i = 0; i < n_phi; ++i) {
        harmonics_.around(around.phi[i], cosines.row(i).data());
        cosines.row(i) *= around.phi_weights[i] * std::sqrt(boundary.areas_m2[at]);
      }
      const Eigen::Map<const RowMajor> kernel_re(re.data(), n_theta, n_phi), kernel_im(im.data(), n_theta, n_phi);
      const Eigen::MatrixXd sum_re = kernel_re * cosines, sum_im = kernel_im * cosines;  // n_theta x n_orders
      for (Eigen::Index m = 0; m < n_orders; ++m) {
        sums[static_cast<std::size_t>(m)].row(j) = sum_re.col(m).transpose();
        sums[static_cast<std::size_t>(m)].row(boundary.n_phi + j) = sum_im.col(m).transpose();
      }
    }
    for (Eigen::Index m = 0; m < n_orders; ++m) {
      const Eigen::MatrixXd block =
          sums[static_cast<std::size_t>(m)] * legendre.middleCols(harmonics_.first(m), harmonics_.count(m));
      auto target = matrix.block(first, harmonics_.first(m), boundary.n_phi, harmonics_.count(m));
      target.real() = block.topRows(boundary.n_phi);
      target.imag() = block.bottomRows(boundary.n_phi);
    }
  }
  return matrix;
}

/// By the field far away: with q = sigma dS, int q (d/dnu + i eta) e^{ik d.y} = 4 pi sum_nm i^n Y_n^m(d) int q (d/dnu + i eta) conj(R_n^m).
Eigen::VectorXcd Shell::multipole(int order) const {
  const int side = (resolution_.degree + order) / 4 +
                   6;  // the sources are smooth on the shell: their degree and that of the wave decide
  const Octant octant = even_octant(side, side);
  const detail::SourceColumns sources = source_columns(octant);
  std::vector<double> q_re(sources.n_padded, 0.0), q_im(sources.n_padded, 0.0);
  Eigen::VectorXd legendre(harmonics_.size()), around(harmonics_.n_orders());
  for (Eigen::Index i = 0; i < octant.theta.size(); ++i) {
    harmonics_.legendre(octant.theta[i], legendre.data());
    Eigen::VectorXcd by_order(harmonics_.n_orders());
    for (Eigen::Index m = 0; m < by_order.size(); ++m)
      by_order[m] = coefficients_.segment(harmonics_.first(m), harmonics_.count(m))
                        .cwiseProduct(legendre.segment(harmonics_.first(m), harmonics_.count(m)).cast<Complex>())
                        .sum();
    for (Eigen::Index j = 0; j < octant.phi.size(); ++j) {
      harmonics_.around(octant.phi[j], around.data());
      const Eigen::Index at = i * octant.phi.size() + j;
      const Complex q = octant.weight(at) * by_order.cwiseProduct(around.cast<Complex>()).sum();
      q_re[static_cast<std::size_t>(at)] = q.real();
      q_im[static_cast<std::size_t>(at)] = q.imag();
    }
  }
  // Directions and harmonics in the body's own axes.
  const int mode_class = mode_.mode_class, n_odd = (mode_class & 1) + (mode_class >> 1 & 1) + (mode_class >> 2 & 1);
  const bool odd_y = (mode_class & 2) != 0;
  const detail::ClassHarmonics harmonics(mode_class, order);
  const Octant directions = even_octant(order / 2 + 1, order / 2 + 1);
  Eigen::VectorXcd projected = Eigen::VectorXcd::Zero(harmonics.size());
  legendre.resize(harmonics.size());
  around.resize(harmonics.n_orders());
  for (Eigen::Index i = 0; i < directions.theta.size(); ++i) {
    Eigen::VectorXcd by_order = Eigen::VectorXcd::Zero(harmonics.n_orders());
    for (Eigen::Index j = 0; j < directions.phi.size(); ++j) {
      const Eigen::Index at = i * directions.phi.size() + j;
      const Eigen::Vector3d body = directions.direction(at);
      std::array<double, 3> here{};
      for (std::size_t d = 0; d < 3; ++d) here[d] = body[frame_.axis[d]];
      const auto [re, im] =
          detail::mirrored_far_field(sources, here, frame_.mode_class, k_, eta_, q_re.data(), q_im.data());
      harmonics.around(directions.phi[j], around.data());
      by_order += directions.weight(at) * Complex(re, im) * around.cast<Complex>();
    }
    harmonics.legendre(directions.theta[i], legendre.data());
    for (Eigen::Index m = 0; m < by_order.size(); ++m)
      projected.segment(harmonics.first(m), harmonics.count(m)) +=
          by_order[m] * legendre.segment(harmonics.first(m), harmonics.count(m)).cast<Complex>();
  }
  // M = -ik / (4 pi i^n) x 8 octants of d x 8 i^n_odd, the images of y. conj(Y_n^m) leaves cos, or -i sin where odd in y, times (-1)^m.
  constexpr std::array<Complex, 4> kPowerOfI{Complex(1.0, 0.0), Complex(0.0, 1.0), Complex(-1.0, 0.0),
                                             Complex(0.0, -1.0)};
  Eigen::VectorXcd out = Eigen::VectorXcd::Zero(acoustics::basis_size(order));
  for (Eigen::Index i = 0; i < harmonics.n_orders(); ++i) {
    const int m = harmonics.order(i);
    const double sign = m % 2 == 0 ? 1.0 : -1.0;
    for (Eigen::Index f = 0; f < harmonics.count(i); ++f) {
      const int n = harmonics.lowest_degree(i) + 2 * static_cast<int>(f);
      const Complex power = kPowerOfI[static_cast<std::size_t>((n_odd - n) % 4 + 4) % 4];
      const Complex part = Complex(0.0, -16.0 * k_ / kPi) * power * sign * projected[harmonics.first(i) + f] *
                           (odd_y ? Complex(0.0, -1.0) : Complex(1.0, 0.0));
      out[acoustics::basis_index(n, m)] = part;  // Y_n^-m = (-1)^m conj(Y_n^m)
      if (m > 0) out[acoustics::basis_index(n, -m)] = (odd_y ? -sign : sign) * part;
    }
  }
  return out;
}

}  // namespace

void EllipsoidRadiationOptions::validate() const { validate_fields("ellipsoid radiation", *this); }

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
  Resolution resolution{static_cast<int>(std::ceil(0.8 * ka)) + 6, 1.7};
  auto shell = std::make_unique<Shell>(modes, mode, k, resolution);
  shell->solve();
  for (int step = 0;
       step < options.max_refinements && !(shell->error * shell->significant <= options.boundary_tolerance); ++step) {
    resolution.degree += std::max(4, resolution.degree / 6);
    resolution.density *= 1.15;
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
  while (order < multipole.order && !(kept >= options.order.kept_power_fraction * result.radiated_power_w))
    kept += power[++order];
  if (options.order.fixed_order) order = std::min(*options.order.fixed_order, multipole.order);
  multipole = acoustics::truncated(multipole, order);
  result.kept_power_fraction = power.head(order + 1).sum() / result.radiated_power_w;
  return result;
}

}  // namespace klang::soundbank
