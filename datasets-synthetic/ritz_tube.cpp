#include "datasets-synthetic/ritz_tube.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "datasets-synthetic/detail/legendre.hpp"

namespace klang::datasets {
namespace {

// Integrals through the wall of f_i f_k, the functions being orthonormal with weight r.
struct WallIntegrals {
  Eigen::MatrixXd slope_slope_r;  // f_i' f_k' r
  Eigen::MatrixXd slope_value;    // f_i' f_k
  Eigen::MatrixXd slope_value_r;  // f_i' f_k r
  Eigen::MatrixXd value_value;    // f_i f_k
  Eigen::MatrixXd value_value_over_r;
};

// Lower-triangular combinations of the wall's Legendre polynomials that are orthonormal with weight r.
Eigen::MatrixXd orthonormal_wall_basis(int order, double inner_m, double outer_m) {
  const double wall = outer_m - inner_m, middle = 0.5 * (inner_m + outer_m);
  const detail::GaussRule rule(order + 2, inner_m, outer_m);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(order + 1, order + 1);
  for (Eigen::Index q = 0; q < rule.points.size(); ++q) {
    const Eigen::VectorXd p = detail::legendre_values(order, wall, rule.points[q] - middle);
    gram += rule.weights[q] * rule.points[q] * p * p.transpose();
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(gram);
  return llt.matrixL().solve(Eigen::MatrixXd::Identity(order + 1, order + 1));
}

WallIntegrals wall_integrals(const Eigen::MatrixXd& basis, double inner_m, double outer_m) {
  const auto order = static_cast<int>(basis.rows()) - 1;
  const double wall = outer_m - inner_m, middle = 0.5 * (inner_m + outer_m);
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(order + 1, order + 1);
  WallIntegrals w{zero, zero, zero, zero, zero};
  const detail::GaussRule rule(order + 40, inner_m, outer_m);  // 1/r is no polynomial
  for (Eigen::Index q = 0; q < rule.points.size(); ++q) {
    const double r = rule.points[q], weight = rule.weights[q];
    const Eigen::VectorXd f = basis * detail::legendre_values(order, wall, r - middle);
    const Eigen::VectorXd s = basis * detail::legendre_slopes(order, wall, r - middle);
    w.slope_slope_r += weight * r * s * s.transpose();
    w.slope_value += weight * s * f.transpose();
    w.slope_value_r += weight * r * s * f.transpose();
    w.value_value += weight * f * f.transpose();
    w.value_value_over_r += weight / r * f * f.transpose();
  }
  return w;
}

std::vector<int> degrees(int order, bool odd) {
  std::vector<int> list;
  for (int k = odd ? 1 : 0; k <= order; k += 2) list.push_back(k);
  return list;
}

// Rows and columns (wall function i, axial function k) of wall (i, j) times axial (k, l).
void add_product(Eigen::Ref<Eigen::MatrixXd> block, const Eigen::MatrixXd& wall, const Eigen::MatrixXd& axial) {
  const Eigen::Index n = axial.rows(), m = axial.cols();
  for (Eigen::Index i = 0; i < wall.rows(); ++i) {
    for (Eigen::Index j = 0; j < wall.cols(); ++j) block.block(i * n, j * m, n, m) += wall(i, j) * axial;
  }
}

Eigen::MatrixXd picked(const Eigen::MatrixXd& matrix, const std::vector<int>& rows, const std::vector<int>& cols) {
  return matrix(rows, cols);
}

constexpr int kHighestAxialOrder = 120;

int default_axial_order(double length_m, double outer_m, double wall_m, const solid::Material& material,
                        double highest_hz) {
  // The shortest waves are those of bending as a beam or of the wall as a plate.
  const double bar = std::sqrt(material.youngs_modulus_pa() / material.density_kg_m3);
  const double gyration = outer_m / std::sqrt(2.0);
  const double beam_m = std::sqrt(2.0 * kPi * bar * gyration / highest_hz);
  const double plate_m = std::sqrt(2.0 * kPi * bar * wall_m / std::sqrt(12.0) / highest_hz);
  const double shear_m = 0.6 * material.shear_speed_m_s() / highest_hz;
  // Plate waves of the wall run alone only above the ring frequency.
  const double ring_hz = bar / (2.0 * kPi * outer_m);
  const double wave_m = highest_hz > ring_hz ? std::min({beam_m, plate_m, shear_m}) : std::min(beam_m, shear_m);
  // Shell edge layers of about sqrt(radius wall) at the ends, where polynomials are dense as 1 / degree^2.
  const double ends = 6.5 * std::sqrt(length_m / std::sqrt(outer_m * wall_m));
  const double waves = 16.0 + 1.6 * 2.0 * length_m / wave_m;
  const double order = std::ceil(std::max(ends, waves));
  if (!(order <= kHighestAxialOrder))
    throw InputError("tube", "has waves too short for its polynomials up to " + to_text(highest_hz) + " Hz",
                     "degree " + to_text(order),
                     "up to " + std::to_string(kHighestAxialOrder) + ": a lower highest_hz");
  return std::max(static_cast<int>(order), 4);
}

}  // namespace

void RitzTube::solve(int n, bool odd, bool torsion, const solid::Material& material, double highest_hz,
                     std::vector<std::pair<double, Mode>>& found) const {
  const WallIntegrals w = wall_integrals(wall_basis_, inner_m_, outer_m_);
  const detail::LegendreIntegrals axial(axial_order_, length_m_);
  const double lambda = material.lame_lambda_pa, mu = material.lame_mu_pa, stiff = lambda + 2.0 * mu;
  const double waves = n, waves_sq = waves * waves;
  const bool has_around = n > 0 || torsion, has_plane = !torsion;
  // odd: parity of u_r and u_theta in z; u_z has the other.
  const std::vector<int> across = degrees(axial_order_, odd), along = degrees(axial_order_, !odd);
  const auto n_wall = static_cast<Eigen::Index>(wall_order_ + 1);
  const auto n_across = static_cast<Eigen::Index>(across.size()), n_along = static_cast<Eigen::Index>(along.size());
  const Eigen::Index size_r = has_plane ? n_wall * n_across : 0, size_t = has_around ? n_wall * n_across : 0,
                     size_z = has_plane ? n_wall * n_along : 0;
  const Eigen::Index at_t = size_r, at_z = size_r + size_t, size = at_z + size_z;

  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n_wall, n_wall);
  const Eigen::MatrixXd same = Eigen::MatrixXd::Identity(n_across, n_across);
  const Eigen::MatrixXd same_z = Eigen::MatrixXd::Identity(n_along, n_along);
  const Eigen::MatrixXd bend = picked(axial.slope_slope, across, across);
  const Eigen::MatrixXd bend_z = picked(axial.slope_slope, along, along);
  const Eigen::MatrixXd value_slope = picked(axial.value_slope, across, along);              // g_k h_l'
  const Eigen::MatrixXd slope_value = picked(axial.value_slope, along, across).transpose();  // g_k' h_l
  const Eigen::MatrixXd sym = w.slope_value + w.slope_value.transpose();

  // Strains of u = (R cos, T sin, Z cos): e_rr = R', e_tt = (R + n T)/r, e_zz = Z_z, g_rt = T' - (T + n R)/r,
  // g_tz = T_z - n Z/r, g_rz = R_z + Z'. cos^2 and sin^2 integrate to the same, which drops out (n = 0: no
  // sin).
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(size, size);
  if (has_plane) {
    auto rr = stiffness.block(0, 0, size_r, size_r);
    add_product(rr,
                stiff * (w.slope_slope_r + w.value_value_over_r) + lambda * sym + mu * waves_sq * w.value_value_over_r,
                same);
    add_product(rr, mu * one, bend);
    auto zz = stiffness.block(at_z, at_z, size_z, size_z);
    add_product(zz, stiff * one, bend_z);
    add_product(zz, mu * w.slope_slope_r + mu * waves_sq * w.value_value_over_r, same_z);
    Eigen::MatrixXd rz = Eigen::MatrixXd::Zero(size_r, size_z);
    add_product(rz, lambda * (w.slope_value_r + w.value_value), value_slope);
    add_product(rz, mu * w.slope_value_r.transpose(), slope_value);
    stiffness.block(at_z, 0, size_z, size_r) = rz.transpose();
  }
  if (has_around) {
    auto tt = stiffness.block(at_t, at_t, size_t, size_t);
    add_product(tt, stiff * waves_sq * w.value_value_over_r + mu * (w.slope_slope_r - sym + w.value_value_over_r),
                same);
    add_product(tt, mu * one, bend);
  }
  if (has_plane && has_around) {
    Eigen::MatrixXd rt = Eigen::MatrixXd::Zero(size_r, size_t);
    add_product(rt,
                waves * (stiff * w.value_value_over_r + lambda * w.slope_value -
                         mu * (w.slope_value.transpose() - w.value_value_over_r)),
                same);
    stiffness.block(at_t, 0, size_t, size_r) = rt.transpose();
    Eigen::MatrixXd tz = Eigen::MatrixXd::Zero(size_t, size_z);
    add_product(tz, lambda * waves * w.value_value, value_slope);
    add_product(tz, -mu * waves * w.value_value, slope_value);
    stiffness.block(at_z, at_t, size_z, size_t) = tz.transpose();
  }

  // One rigid motion a block: along the axis (n = 0, u_r odd), about it (torsion, even), across and tilting
  // (n = 1).
  const int rigid = n == 1 || (n == 0 && (torsion ? !odd : odd)) ? 1 : 0;
  const double highest_sq = std::pow(2.0 * kPi * highest_hz, 2) * material.density_kg_m3;
  const double angle = n > 0 ? kPi : 2.0 * kPi;
  for (int count = 24;; count *= 2) {
    const auto pairs = detail::lowest_eigenpairs(stiffness, count);
    if (pairs.values[pairs.values.size() - 1] <= highest_sq && pairs.values.size() < size) continue;
    for (Eigen::Index k = rigid; k < pairs.values.size() && pairs.values[k] <= highest_sq; ++k) {
      const Eigen::VectorXd c = pairs.vectors.col(k) / std::sqrt(material.density_kg_m3 * angle);
      Mode mode{{n, odd, torsion, 0}, {}, {}, {}};
      if (has_plane) {
        mode.radial = c.head(size_r).reshaped(n_across, n_wall).transpose();
        mode.axial = c.tail(size_z).reshaped(n_along, n_wall).transpose();
      }
      if (has_around) mode.around = c.segment(at_t, size_t).reshaped(n_across, n_wall).transpose();
      found.push_back({std::sqrt(pairs.values[k] / material.density_kg_m3), std::move(mode)});
    }
    break;
  }
}

RitzTube::RitzTube(double length_m, double outer_radius_m, double wall_m, const solid::Material& material,
                   const RitzTubeOptions& options)
    : length_m_(length_m),
      inner_m_(outer_radius_m - wall_m),
      outer_m_(outer_radius_m),
      axial_order_(options.axial_order),
      wall_order_(options.wall_order) {
  validate(material);
  checked_open("tube", "length_m", length_m, 0.0, 1e3);
  checked_open("tube", "outer_radius_m", outer_radius_m, 0.0, 1e3);
  checked_open("tube", "wall_m", wall_m, 0.0, outer_radius_m);
  checked_open("tube", "highest_hz", options.highest_hz, 0.0, 1e9);
  if (axial_order_ == 0) {
    axial_order_ = default_axial_order(length_m, outer_radius_m, wall_m, material, options.highest_hz);
  }
  checked("tube", "axial_order", axial_order_, 4, kHighestAxialOrder);
  checked("tube", "wall_order", wall_order_, 1, 12);
  wall_basis_ = orthonormal_wall_basis(wall_order_, inner_m_, outer_m_);

  const BlasThreads one_thread(1);
  std::vector<std::pair<double, Mode>> all;
  for (bool odd : {false, true}) {
    solve(0, odd, true, material, options.highest_hz, all);
    solve(0, odd, false, material, options.highest_hz, all);
  }
  for (int n = 1; n <= 60; ++n) {
    const std::size_t before = all.size();
    for (bool odd : {false, true}) solve(n, odd, false, material, options.highest_hz, all);
    if (n >= 2 && all.size() == before) break;  // the lowest frequency of each n rises with n from 2 on
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> omega;
  for (auto& [value, mode] : all) {
    omega.push_back(value);
    modes_.push_back(mode);
    if (mode.label.circumferential == 0) continue;
    omega.push_back(value);
    modes_.push_back(std::move(mode));
    modes_.back().label.orientation = 1;
  }
  omega_ = Eigen::Map<const Eigen::VectorXd>(omega.data(), static_cast<Eigen::Index>(omega.size()));
}

Eigen::MatrixXd RitzTube::shapes_at(const Eigen::Vector3d& point_m) const {
  const double r = std::hypot(point_m[0], point_m[1]), theta = std::atan2(point_m[1], point_m[0]);
  const Eigen::VectorXd wall =
      wall_basis_ * detail::legendre_values(wall_order_, outer_m_ - inner_m_, r - 0.5 * (inner_m_ + outer_m_));
  const Eigen::VectorXd along = detail::legendre_values(axial_order_, length_m_, point_m[2]);
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(3, n_modes());
  for (Eigen::Index m = 0; m < n_modes(); ++m) {
    const Mode& mode = modes_[static_cast<std::size_t>(m)];
    const auto value = [&](const Eigen::MatrixXd& coefficients, bool odd) {
      if (coefficients.size() == 0) return 0.0;
      const Eigen::VectorXd g = along(degrees(axial_order_, odd));
      return wall.dot(coefficients * g);
    };
    const double angle = mode.label.circumferential * theta - (mode.label.orientation == 1 ? 0.5 * kPi : 0.0);
    const double u_r = value(mode.radial, mode.label.odd_in_z) * std::cos(angle);
    const double u_t = value(mode.around, mode.label.odd_in_z) * (mode.label.torsion ? 1.0 : std::sin(angle));
    shapes(0, m) = u_r * std::cos(theta) - u_t * std::sin(theta);
    shapes(1, m) = u_r * std::sin(theta) + u_t * std::cos(theta);
    shapes(2, m) = value(mode.axial, !mode.label.odd_in_z) * std::cos(angle);
  }
  return shapes;
}

}  // namespace klang::datasets
