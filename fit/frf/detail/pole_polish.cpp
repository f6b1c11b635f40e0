#include "fit/frf/detail/pole_polish.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace klang::fit::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

constexpr int kMostRounds = 40;
constexpr Index kMostSamples = 20000;

/// The data of a fit: rows are real numbers (real, then imaginary parts of FRFs).
struct Problem {
  bool in_time = false;
  int derivative = 2;
  VectorXd x;     ///< omega or time
  MatrixXd data;  ///< rows x responses, each scaled to norm 1
  VectorXd scale;
};

Problem problem_of(const ResponseSet& set, const Band& band) {
  Problem problem;
  problem.in_time = set.in_time;
  problem.derivative = set.derivative;
  Index first = 0, last = set.n_lines();
  if (!set.in_time) {
    while (first < last && (set.abscissa[first] < band.low_hz || set.abscissa[first] <= 0)) ++first;
    while (last > first && set.abscissa[last - 1] > band.high_hz) --last;
  }
  const Index n = set.in_time ? std::min(last, kMostSamples) : last - first;
  problem.x = set.abscissa.segment(first, n);
  if (!set.in_time) problem.x *= 2 * std::numbers::pi;
  const Eigen::MatrixXcd values = set.values.middleCols(first, n).transpose();
  problem.data.resize(set.in_time ? n : 2 * n, values.cols());
  problem.data.topRows(n) = values.real();
  if (!set.in_time) problem.data.bottomRows(n) = values.imag();
  problem.scale = problem.data.colwise().norm().cwiseMax(1e-300);
  problem.data = problem.data * problem.scale.cwiseInverse().asDiagonal();
  return problem;
}

Complex power(Complex base, int exponent) {
  Complex result = 1.0;
  for (int i = 0; i < exponent; ++i) result *= base;
  return result;
}

/// Columns of the linear unknowns, and of each pole's two the derivatives by decay and omega.
struct Basis {
  MatrixXd columns;                          ///< rows x (2 poles + constants)
  std::vector<MatrixXd> by_decay, by_omega;  ///< rows x 2 each
};

void set_column(const Problem& problem, const VectorXcd& values, Eigen::Ref<VectorXd> column) {
  const Index n = values.size();
  column.head(n) = values.real();
  if (!problem.in_time) column.tail(n) = values.imag();
}

Basis basis_of(const Problem& problem, const std::vector<Pole>& poles, bool slopes) {
  const Index n = problem.x.size(), rows = problem.data.rows(), n_poles = static_cast<Index>(poles.size());
  const Index n_constants = problem.in_time ? 1 : 4;
  Basis basis;
  basis.columns.resize(rows, 2 * n_poles + n_constants);
  VectorXcd front(n), g(n), conjugate(n), dg(n), dconjugate(n);
  for (Index i = 0; i < n; ++i) front[i] = problem.in_time ? 1.0 : power({0, problem.x[i]}, problem.derivative);
  const Complex unit(0, 1);
  for (Index r = 0; r < n_poles; ++r) {
    const Pole pole = poles[static_cast<std::size_t>(r)];
    for (Index i = 0; i < n; ++i) {
      if (problem.in_time) {
        const double t = problem.x[i] - problem.x[0];
        g[i] = std::exp(pole * t), conjugate[i] = std::conj(g[i]);
        dg[i] = t * g[i], dconjugate[i] = t * conjugate[i];
      } else {
        const Complex s(0, problem.x[i]), a = 1.0 / (s - pole), b = 1.0 / (s - std::conj(pole));
        g[i] = front[i] * a, conjugate[i] = front[i] * b;
        dg[i] = g[i] * a, dconjugate[i] = conjugate[i] * b;
      }
    }
    set_column(problem, g + conjugate, basis.columns.col(2 * r));
    set_column(problem, unit * (g - conjugate), basis.columns.col(2 * r + 1));
    if (!slopes) continue;
    MatrixXd by_real(rows, 2), by_omega(rows, 2);
    set_column(problem, dg + dconjugate, by_real.col(0));
    set_column(problem, unit * (dg - dconjugate), by_real.col(1));
    set_column(problem, unit * (dg - dconjugate), by_omega.col(0));
    set_column(problem, -(dg + dconjugate), by_omega.col(1));
    basis.by_decay.push_back(-by_real);
    basis.by_omega.push_back(by_omega);
  }
  if (problem.in_time) {
    basis.columns.rightCols(1).setOnes();
    return basis;
  }
  const double middle = problem.x[n / 2];
  for (int constant = 0; constant < 4; ++constant) {
    VectorXcd column(n);
    for (Index i = 0; i < n; ++i) {
      const double inertia = middle / problem.x[i];
      column[i] = front[i] * (constant < 2 ? 1.0 : -inertia * inertia) * (constant % 2 ? unit : Complex(1.0));
    }
    set_column(problem, column, basis.columns.col(2 * n_poles + constant));
  }
  return basis;
}

/// The columns scaled to norm 1, their orthogonal basis, what they explain.
struct Projection {
  VectorXd norms;
  MatrixXd q, coefficients, misfit;
  double cost = 0;
};

Projection projection_of(const Problem& problem, const Basis& basis) {
  Projection result;
  result.norms = basis.columns.colwise().norm().cwiseMax(1e-300);
  const MatrixXd scaled = basis.columns * result.norms.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(scaled);
  result.q = qr.householderQ() * MatrixXd::Identity(scaled.rows(), scaled.cols());
  const MatrixXd seen = result.q.transpose() * problem.data;
  result.coefficients = result.norms.cwiseInverse().asDiagonal() *
                        qr.matrixQR().topRows(scaled.cols()).triangularView<Eigen::Upper>().solve(seen);
  result.misfit = problem.data - result.q * seen;
  result.cost = result.misfit.squaredNorm();
  return result;
}

/// Normal equations of the poles: J = -P (d basis) c by Kaufman's simplification.
void normal_equations(const Problem& problem, const Basis& basis, const Projection& at, MatrixXd& square,
                      VectorXd& side) {
  const auto n_poles = static_cast<Index>(basis.by_decay.size());
  square = MatrixXd::Zero(2 * n_poles, 2 * n_poles);
  side = VectorXd::Zero(2 * n_poles);
  for (Index o = 0; o < problem.data.cols(); ++o) {
    MatrixXd jacobian(problem.data.rows(), 2 * n_poles);
    for (Index r = 0; r < n_poles; ++r) {
      const Eigen::Vector2d c = at.coefficients.col(o).segment<2>(2 * r);
      jacobian.col(2 * r) = basis.by_decay[static_cast<std::size_t>(r)] * c;
      jacobian.col(2 * r + 1) = basis.by_omega[static_cast<std::size_t>(r)] * c;
    }
    jacobian -= at.q * (at.q.transpose() * jacobian);
    square += jacobian.transpose() * jacobian;
    side += jacobian.transpose() * at.misfit.col(o);
  }
}

std::vector<Pole> moved(const std::vector<Pole>& poles, const VectorXd& step) {
  std::vector<Pole> result = poles;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const double decay = -poles[r].real(), changed = decay + step[2 * static_cast<Index>(r)];
    result[r] = {-std::clamp(changed, 0.2 * decay, 5.0 * decay), poles[r].imag() + step[2 * static_cast<Index>(r) + 1]};
  }
  return result;
}

}  // namespace

PolishedPoles polished(const ResponseSet& set, const Band& band, std::vector<Pole> start) {
  const Problem problem = problem_of(set, band);
  PolishedPoles result;
  result.poles = std::move(start);
  MatrixXd square;
  VectorXd side;
  double damping = 1e-6;
  Basis basis = basis_of(problem, result.poles, true);
  Projection here = projection_of(problem, basis);
  for (int round = 0; round < kMostRounds && !result.converged; ++round) {
    normal_equations(problem, basis, here, square, side);
    bool better = false;
    for (int attempt = 0; attempt < 12 && !better; ++attempt) {
      MatrixXd damped = square;
      damped.diagonal() *= 1.0 + damping;
      const VectorXd step = damped.ldlt().solve(side);
      const std::vector<Pole> next = moved(result.poles, step);
      Basis there_basis = basis_of(problem, next, true);
      Projection there = projection_of(problem, there_basis);
      if (!(there.cost <= here.cost * (1 + 1e-12))) {
        damping *= 10;
        continue;
      }
      better = true;
      damping = std::max(1e-9, 0.1 * damping);
      double change = 0;
      for (std::size_t r = 0; r < next.size(); ++r)
        change = std::max(change, std::abs(next[r] - result.poles[r]) / std::abs(next[r].real()));
      result.converged = change < 1e-7;
      result.poles = next;
      basis = std::move(there_basis);
      here = std::move(there);
    }
    if (!better) result.converged = true;  // round-off
  }
  result.explained = 1.0 - here.cost / problem.data.squaredNorm();
  result.residues.resize(problem.data.cols(), static_cast<Index>(result.poles.size()));
  for (Index r = 0; r < result.residues.cols(); ++r) {
    for (Index o = 0; o < result.residues.rows(); ++o) {
      const auto c = here.coefficients.col(o).segment<2>(2 * r);
      result.residues(o, r) = problem.scale[o] * Complex(c[0], c[1]);
    }
  }
  const auto freedom = static_cast<double>(problem.data.size() - basis.columns.cols() * problem.data.cols()) -
                       2.0 * static_cast<double>(result.poles.size());
  if (freedom > 0) {
    normal_equations(problem, basis, here, square, side);
    const MatrixXd inverse = square.ldlt().solve(MatrixXd::Identity(square.rows(), square.cols()));
    if (inverse.allFinite()) result.covariance = here.cost / freedom * inverse;
  }
  return result;
}

}  // namespace klang::fit::detail
