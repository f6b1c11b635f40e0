#include "core/physics/modal/polynomial_modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/quadrature.hpp"
#include "core/geometry/mesh/mass_properties.hpp"

namespace klang::modal {
namespace {

using Powers = std::array<int, 3>;

/// All powers of total degree up to n, and where they stand.
struct PowerTable {
  explicit PowerTable(int n) : side(n + 1), place(static_cast<std::size_t>(side * side * side), -1) {
    for (int total = 0; total <= n; ++total)
      for (int i = total; i >= 0; --i)
        for (int j = total - i; j >= 0; --j) {
          place[at(i, j, total - i - j)] = static_cast<int>(list.size());
          list.push_back({i, j, total - i - j});
        }
  }
  std::size_t at(int i, int j, int k) const { return static_cast<std::size_t>((i * side + j) * side + k); }
  int side;
  std::vector<Powers> list;
  std::vector<int> place;
};

/// int xi^i eta^j zeta^k over the body, by the table; vertices 3 x n in the coordinates of the polynomials.
std::vector<double> moments(const PowerTable& powers, const Eigen::Matrix3Xd& vertices,
                            const mesh::IndexRows& triangles) {
  const int degree = powers.side - 1;
  const QuadratureRule rule = gauss_rule(degree / 2 + 1);
  std::vector<double> sums(powers.list.size(), 0.0);
  Eigen::Matrix3Xd power(3, degree + 1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Eigen::Vector3d a = vertices.col(triangles(t, 0)), ab = vertices.col(triangles(t, 1)) - a,
                          ac = vertices.col(triangles(t, 2)) - a;
    const double flux = a.dot(ab.cross(ac));  // x.n dS over the unit triangle's area element
    if (flux == 0.0) continue;
    for (Eigen::Index p = 0; p < rule.points.size(); ++p) {
      const double s = 0.5 * (1.0 + rule.points[p]);
      for (Eigen::Index q = 0; q < rule.points.size(); ++q) {
        const double r = 0.5 * (1.0 + rule.points[q]) * (1.0 - s);
        const double weight = 0.25 * rule.weights[p] * rule.weights[q] * (1.0 - s) * flux;
        const Eigen::Vector3d x = a + s * ab + r * ac;
        power.col(0).setOnes();
        for (int k = 1; k <= degree; ++k) power.col(k) = power.col(k - 1).cwiseProduct(x);
        for (std::size_t m = 0; m < sums.size(); ++m) {
          const Powers& e = powers.list[m];
          sums[m] += weight * power(0, e[0]) * power(1, e[1]) * power(2, e[2]);
        }
      }
    }
  }
  for (std::size_t m = 0; m < sums.size(); ++m)
    sums[m] /= powers.list[m][0] + powers.list[m][1] + powers.list[m][2] + 3;
  return sums;
}

struct Problem {
  Eigen::MatrixXd stiffness, mass, rigid;
};

/// With density 1 and mu = 1, coordinates in units of the half extents h: derivatives are divided by h, the factor h_x h_y h_z of all
/// integrals is left out of both matrices.
Problem assemble_polynomials(const PowerTable& basis, const PowerTable& powers, const std::vector<double>& integral,
                             const Eigen::Vector3d& h, double lambda_over_mu) {
  const auto n = static_cast<Eigen::Index>(basis.list.size());
  const auto value = [&](const Powers& p, const Powers& q, int dp, int dq) {  // int d_dp P d_dq Q; -1: no derivative
    Powers e{p[0] + q[0], p[1] + q[1], p[2] + q[2]};
    double factor = 1.0;
    if (dp >= 0) {
      factor *= p[static_cast<std::size_t>(dp)] / h[dp];
      --e[static_cast<std::size_t>(dp)];
    }
    if (dq >= 0) {
      factor *= q[static_cast<std::size_t>(dq)] / h[dq];
      --e[static_cast<std::size_t>(dq)];
    }
    return factor == 0.0 ? 0.0 : factor * integral[static_cast<std::size_t>(powers.place[powers.at(e[0], e[1], e[2])])];
  };
  Problem problem{Eigen::MatrixXd(3 * n, 3 * n), Eigen::MatrixXd::Zero(3 * n, 3 * n), Eigen::MatrixXd::Zero(3 * n, 6)};
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Powers &p = basis.list[static_cast<std::size_t>(i)], &q = basis.list[static_cast<std::size_t>(j)];
      const double mass = value(p, q, -1, -1);
      Eigen::Matrix3d d;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) d(a, b) = value(p, q, a, b);
      for (int a = 0; a < 3; ++a) {
        problem.mass(a * n + i, a * n + j) = problem.mass(a * n + j, a * n + i) = mass;
        for (int b = 0; b < 3; ++b) {
          const double k = lambda_over_mu * d(a, b) + d(b, a) + (a == b ? d.trace() : 0.0);
          problem.stiffness(a * n + i, b * n + j) = problem.stiffness(b * n + j, a * n + i) = k;
        }
      }
    }
  const auto row = [&](int i, int j, int k) { return static_cast<Eigen::Index>(basis.place[basis.at(i, j, k)]); };
  const Eigen::Index linear[3] = {row(1, 0, 0), row(0, 1, 0), row(0, 0, 1)};
  for (int a = 0; a < 3; ++a) {
    problem.rigid(a * n + row(0, 0, 0), a) = 1.0;
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    problem.rigid(b * n + linear[c], 3 + a) = -h[c];  // rotation about a
    problem.rigid(c * n + linear[b], 3 + a) = h[b];
  }
  return problem;
}

/// The smallest elastic eigenvalue of K x = w M x: Lanczos on (K + s M)^-1 M, every vector kept orthogonal to the rigid motions.
double lowest_elastic(const Problem& problem, double shift) {
  const Eigen::Index n = problem.mass.rows();
  const Eigen::LLT<Eigen::MatrixXd> factor(problem.stiffness + shift * problem.mass);
  Eigen::MatrixXd rigid = problem.rigid;
  const Eigen::LLT<Eigen::MatrixXd> gram(rigid.transpose() * problem.mass * rigid);
  if (factor.info() != Eigen::Success || gram.info() != Eigen::Success)
    throw InputError("polynomial modes", "the body is too thin or too crooked for this degree");
  gram.matrixL().transpose().solveInPlace<Eigen::OnTheRight>(rigid);
  const Eigen::MatrixXd rigid_mass = problem.mass * rigid;
  constexpr int kMaxSteps = 60;
  Eigen::MatrixXd basis(n, kMaxSteps + 1), basis_mass(n, kMaxSteps + 1);
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = 1.0 + std::sin(1.7 * static_cast<double>(i + 1));  // of no symmetry
  double before = 0.0;
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(kMaxSteps, kMaxSteps);
  for (int step = 0; step <= kMaxSteps; ++step) {
    for (int pass = 0; pass < 2; ++pass) {
      v -= rigid * (rigid_mass.transpose() * v);
      if (step > 0) {
        const Eigen::VectorXd along = basis_mass.leftCols(step).transpose() * v;
        if (pass == 0) t.col(step - 1).head(step) = along;
        v -= basis.leftCols(step) * along;
      }
    }
    Eigen::VectorXd mv = problem.mass * v;
    const double norm = std::sqrt(std::max(v.dot(mv), 0.0));
    if (step > 0 && (step % 4 == 0 || !(norm > 0.0))) {
      const Eigen::MatrixXd small = t.topLeftCorner(step, step).selfadjointView<Eigen::Upper>();
      const double largest =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(small, Eigen::EigenvaluesOnly).eigenvalues()[step - 1];
      if (std::abs(largest - before) <= 1e-8 * largest || !(norm > 0.0)) return 1.0 / largest - shift;
      before = largest;
    }
    if (step == kMaxSteps) break;
    basis.col(step) = v / norm;
    basis_mass.col(step) = mv / norm;
    v = factor.solve(basis_mass.col(step));
  }
  throw NumericalError("polynomial modes: the lowest frequency has not settled in " + std::to_string(kMaxSteps) +
                       " steps");
}

}  // namespace

void PolynomialModeOptions::validate() const { validate_fields("polynomial modes", *this); }

double lowest_frequency_hz(const mesh::SurfaceMesh& surface, const solid::Material& material,
                           const PolynomialModeOptions& options) {
  options.validate();
  solid::validate(material);
  const mesh::MassProperties body =
      mesh::mass_properties(mesh::SurfaceMesh{surface.vertices_m, surface.triangles.leftCols(3)});
  // In the principal frame, in units of the half extents, the powers of a thin body are as far from each other as a cube's.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> frame(body.inertia_m5);
  Eigen::Matrix3Xd vertices =
      frame.eigenvectors().transpose() * (surface.vertices_m.transpose().colwise() - body.centre_m);
  if (frame.eigenvectors().determinant() < 0.0) vertices.row(0) *= -1.0;  // normals stay outward
  const Eigen::Vector3d h = vertices.rowwise().lpNorm<Eigen::Infinity>();
  vertices.array().colwise() /= h.array();
  const PowerTable basis(options.degree), powers(2 * options.degree);
  const Problem problem = assemble_polynomials(basis, powers, moments(powers, vertices, surface.triangles), h,
                                               material.lame_lambda_pa / material.lame_mu_pa);
  const double longest = h.maxCoeff();
  const double omega_sq = lowest_elastic(
      problem, 0.01 * std::pow(h.minCoeff() / (longest * longest), 2));  // of the order of the bending modes
  return material.shear_speed_m_s() * std::sqrt(std::max(omega_sq, 0.0)) / (2.0 * kPi);
}

}  // namespace klang::modal
