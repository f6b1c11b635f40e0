#include "core/physics/modal/ellipsoid_modes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/lapack.hpp"
#include "core/physics/modal/detail/ball_basis.hpp"

namespace klang::modal {
namespace {

/// Stiffness of a class over mu, divided by the volume factor abc; lower half. Strain energy
///   lambda (div u)^2 / 2 + mu e:e with d/dx_i = (1/a_i) d/dxi_i.
Eigen::MatrixXd class_stiffness(int mode_class, const Eigen::Vector3d& axes, double lambda, double mu,
                                const detail::BallBasis& basis) {
  std::array<Eigen::Index, 4> start{};
  for (int i = 0; i < 3; ++i) start[i + 1] = start[i] + basis.size(mode_class ^ (1 << i));
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(start[3], start[3]);
  const auto slope = [&](int component, int axis) -> const Eigen::MatrixXd& {
    return basis.slope(mode_class ^ (1 << component), axis);
  };
  for (int j = 0; j < 3; ++j)
    for (int i = j; i < 3; ++i) {
      auto block = stiffness.block(start[i], start[j], start[i + 1] - start[i], start[j + 1] - start[j]);
      const double scale = 1.0 / (axes[i] * axes[j]);
      block.noalias() += lambda * scale * slope(i, i).transpose() * slope(j, j);
      block.noalias() += mu * scale * slope(i, j).transpose() * slope(j, i);
      if (i != j) continue;
      for (int d = 0; d < 3; ++d) block.noalias() += mu / (axes[d] * axes[d]) * slope(i, d).transpose() * slope(i, d);
    }
  return stiffness;
}

/// Twice the strain energy of a coefficient vector over abc, as a sum of squares of strains. As a Rayleigh quotient it keeps the
/// digits that the eigensolver loses in thin bodies, where the largest eigenvalue is 1e9 times the lowest.
double twice_energy(int mode_class, const Eigen::VectorXd& u, const Eigen::Vector3d& axes, double lambda, double mu,
                    const detail::BallBasis& basis) {
  std::array<Eigen::VectorXd, 3> component;
  Eigen::Index start = 0;
  for (int i = 0; i < 3; ++i) {
    component[i] = u.segment(start, basis.size(mode_class ^ (1 << i)));
    start += component[i].size();
  }
  const auto slope = [&](int i, int axis) -> Eigen::VectorXd {
    return basis.slope(mode_class ^ (1 << i), axis) * component[i] / axes[axis];
  };
  double energy = 0.0;
  Eigen::VectorXd divergence = Eigen::VectorXd::Zero(basis.size(mode_class));
  for (int i = 0; i < 3; ++i) {
    const Eigen::VectorXd stretch = slope(i, i);
    divergence += stretch;
    energy += 2.0 * mu * stretch.squaredNorm();
    for (int j = 0; j < i; ++j) energy += mu * (slope(i, j) + slope(j, i)).squaredNorm();
  }
  return energy + lambda * divergence.squaredNorm();
}

void lowest_eigenpairs(Eigen::MatrixXd& matrix, int count, Eigen::VectorXd& values, Eigen::MatrixXd& vectors) {
  const int n = static_cast<int>(matrix.rows());
  values.resize(n);
  vectors.resize(n, count);
  const int first = 1;
  const double unused = 0.0, tolerance = 0.0;
  std::vector<int> support(2 * static_cast<std::size_t>(n)), iwork(10 * static_cast<std::size_t>(n));
  std::vector<double> work(static_cast<std::size_t>(n) * 64 + 1024);
  const int lwork = static_cast<int>(work.size()), liwork = static_cast<int>(iwork.size());
  int found = 0, info = 0;
  dsyevr_("V", "I", "L", &n, matrix.data(), &n, &unused, &unused, &first, &count, &tolerance, &found, values.data(),
          vectors.data(), &n, support.data(), work.data(), &lwork, iwork.data(), &liwork, &info);
  KLANG_CHECK(info == 0 && found == count, "dsyevr failed on a finite symmetric matrix");
  values.conservativeResize(count);
}

}  // namespace

void EllipsoidModeOptions::validate() const { validate_fields("ellipsoid", *this); }

int rigid_motions(int mode_class) {
  const int odd = std::popcount(static_cast<unsigned>(mode_class));
  return odd == 1 || odd == 2 ? 1 : 0;
}

EllipsoidModes::EllipsoidModes(const Eigen::Vector3d& axes_m, const solid::Material& material,
                               const EllipsoidModeOptions& options)
    : axes_m_(axes_m), degree_(options.degree) {
  const BlasThreads one(1);  // a few hundred unknowns: threads only wait for each other
  options.validate();
  solid::validate(material);
  const std::array<const char*, 3> names{"a_m", "b_m", "c_m"};
  for (int d = 0; d < 3; ++d) checked_open("ellipsoid", names[d], axes_m[d], 0.0, 1e6);
  const detail::BallBasis& basis = detail::ball_basis(degree_);
  const double mass_factor = material.density_kg_m3 * axes_m.prod();
  for (int c = 0; c < kModeClasses; ++c) {
    Eigen::MatrixXd stiffness = class_stiffness(c, axes_m, material.lame_lambda_pa, material.lame_mu_pa, basis);
    const int rigid = rigid_motions(c);
    const int count = std::min(options.per_class + rigid, static_cast<int>(stiffness.rows()));
    Eigen::VectorXd values;
    Eigen::MatrixXd vectors, kept;
    if (options.residuals) kept = stiffness.selfadjointView<Eigen::Lower>();
    lowest_eigenpairs(stiffness, count, values, vectors);
    omega_[c].resize(count - rigid);
    for (int k = 0; k < count - rigid; ++k) {
      const Eigen::VectorXd u = vectors.col(rigid + k);
      const double energy = twice_energy(c, u, axes_m, material.lame_lambda_pa, material.lame_mu_pa, basis);
      omega_[c][k] = std::sqrt(energy / (u.squaredNorm() * material.density_kg_m3));
    }
    if (options.residuals) {
      const Eigen::MatrixXd elastic = vectors.rightCols(count - rigid);
      const Eigen::VectorXd value = material.density_kg_m3 * omega_[c].cwiseAbs2();
      residual_[c] = (kept * elastic - elastic * value.asDiagonal()).colwise().norm().transpose().cwiseQuotient(value);
    }
    coefficients_[c] = vectors.rightCols(count - rigid) / std::sqrt(mass_factor);
    for (auto column : coefficients_[c].colwise()) {  // a sign that does not depend on the eigensolver
      Eigen::Index at = 0;
      column.cwiseAbs().maxCoeff(&at);
      if (column[at] < 0.0) column *= -1.0;
    }
  }
}

EllipsoidModes::EllipsoidModes(const Eigen::Vector3d& axes_m, int degree,
                               std::array<Eigen::VectorXd, kModeClasses> omega,
                               std::array<Eigen::MatrixXd, kModeClasses> coefficients)
    : axes_m_(axes_m), degree_(degree), omega_(std::move(omega)), coefficients_(std::move(coefficients)) {}

std::vector<ModeId> lowest_modes(const std::array<Eigen::VectorXd, kModeClasses>& by_class, int count) {
  std::vector<ModeId> ids;
  std::array<int, kModeClasses> next{};
  while (static_cast<int>(ids.size()) < count) {
    int best = -1;
    for (int c = 0; c < kModeClasses; ++c) {
      if (next[c] >= by_class[c].size()) return ids;  // what this class would offer next is not known
      if (best < 0 || by_class[c][next[c]] < by_class[best][next[best]]) best = c;
    }
    ids.push_back({best, next[best]++});
  }
  return ids;
}

Eigen::Index mode_shape_size(int degree, int mode_class) {
  std::array<Eigen::Index, kModeClasses> of_parity{};  // products x^i y^j z^k with i + j + k <= degree
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      for (int k = 0; i + j + k <= degree; ++k) ++of_parity[(i & 1) | (j & 1) << 1 | (k & 1) << 2];
  return of_parity[mode_class ^ 1] + of_parity[mode_class ^ 2] + of_parity[mode_class ^ 4];
}

std::vector<ModeId> EllipsoidModes::lowest(int count) const { return lowest_modes(omega_, count); }

Eigen::Matrix3Xd EllipsoidModes::shape_at(const ModeId& mode, const Eigen::Matrix3Xd& xi) const {
  const detail::BallBasis& basis = detail::ball_basis(degree_);
  const auto c = coefficients(mode);
  Eigen::Matrix3Xd u(3, xi.cols());
  Eigen::Index start = 0;
  for (int i = 0; i < 3; ++i) {
    const detail::Parity parity = mode.mode_class ^ (1 << i);
    u.row(i) = (basis.values(parity, xi) * c.segment(start, basis.size(parity))).transpose();
    start += basis.size(parity);
  }
  return u;
}

Eigen::MatrixXd EllipsoidModes::shapes_at(const std::vector<ModeId>& modes, const Eigen::Matrix3Xd& xi) const {
  const detail::BallBasis& basis = detail::ball_basis(degree_);
  std::array<Eigen::MatrixXd, detail::kParities> values;
  Eigen::MatrixXd shapes(3 * xi.cols(), static_cast<Eigen::Index>(modes.size()));
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const auto c = coefficients(modes[k]);
    Eigen::Map<Eigen::Matrix3Xd> u(shapes.col(static_cast<Eigen::Index>(k)).data(), 3, xi.cols());
    Eigen::Index start = 0;
    for (int i = 0; i < 3; ++i) {
      const detail::Parity parity = modes[k].mode_class ^ (1 << i);
      Eigen::MatrixXd& at = values[static_cast<std::size_t>(parity)];
      if (at.size() == 0) at = basis.values(parity, xi);
      u.row(i) = (at * c.segment(start, basis.size(parity))).transpose();
      start += basis.size(parity);
    }
  }
  return shapes;
}

}  // namespace klang::modal
