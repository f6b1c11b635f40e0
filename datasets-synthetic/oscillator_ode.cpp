#include "datasets-synthetic/oscillator_ode.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace klang::datasets {
namespace {

constexpr int kStages = 4;
constexpr double kStepTimesOmega = 0.4;

using Stages = Eigen::Vector4d;
using Table = Eigen::Matrix4d;

// Butcher's table of the Gauss-Legendre method: c the roots of P_4 on [0, 1], a_ij = int_0^{c_i} L_j, b_j = int_0^1
// L_j.
struct GaussTable {
  Stages c, b;
  Table a;
  GaussTable() {
    const double inner = std::sqrt(3.0 / 7.0 - 2.0 / 7.0 * std::sqrt(6.0 / 5.0));
    const double outer = std::sqrt(3.0 / 7.0 + 2.0 / 7.0 * std::sqrt(6.0 / 5.0));
    c << 0.5 - 0.5 * outer, 0.5 - 0.5 * inner, 0.5 + 0.5 * inner, 0.5 + 0.5 * outer;
    Table powers, integrals;  // sum_j a_ij c_j^k = c_i^(k+1) / (k+1)
    Stages whole;
    for (int k = 0; k < kStages; ++k) {
      powers.row(k) = c.array().pow(k).transpose();
      integrals.row(k) = c.array().pow(k + 1).transpose() / (k + 1);
      whole[k] = 1.0 / (k + 1);
    }
    const Eigen::PartialPivLU<Table> lu(powers);
    a = lu.solve(integrals).transpose();
    b = lu.solve(whole);
  }
};

const GaussTable& gauss() {
  static const GaussTable table;
  return table;
}

// One step for the accelerations at the stages: q_i' = v + h a q'', q_i = q + h c_i v + h^2 a a q''.
void step(const std::function<OscillatorCoefficients(double)>& coefficients, double from_s, double h, double& q,
          double& v) {
  const GaussTable& g = gauss();
  static const Table twice = g.a * g.a;
  Table system;
  Stages rhs;
  for (int i = 0; i < kStages; ++i) {
    const OscillatorCoefficients at = coefficients(from_s + g.c[i] * h);
    const double stiffness = at.omega0_rad_s * at.omega0_rad_s, damping = 2.0 * at.decay_per_s;
    system.row(i) = damping * h * g.a.row(i) + stiffness * h * h * twice.row(i);
    system(i, i) += 1.0;
    rhs[i] = -damping * v - stiffness * (q + g.c[i] * h * v);
  }
  const Stages acceleration = Eigen::PartialPivLU<Table>(system).solve(rhs);
  q += h * v + h * h * g.b.dot(g.a * acceleration);
  v += h * g.b.dot(acceleration);
}

}  // namespace

Eigen::MatrixXd integrate_oscillator(const std::function<OscillatorCoefficients(double)>& coefficients,
                                     double start_velocity, double first_s, double step_s, Eigen::Index n,
                                     const std::vector<double>& corners_s) {
  Eigen::MatrixXd rows(n, 3);
  double q = 0.0, v = start_velocity, now = 0.0;
  std::size_t corner = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double wanted = first_s + static_cast<double>(i) * step_s;
    while (now < wanted) {
      while (corner < corners_s.size() && corners_s[corner] <= now) ++corner;
      const double until = corner < corners_s.size() ? std::min(wanted, corners_s[corner]) : wanted;
      const double omega = std::max(coefficients(now).omega0_rad_s, coefficients(0.5 * (now + until)).omega0_rad_s);
      const double n_steps = std::max(1.0, std::ceil((until - now) * omega / kStepTimesOmega));
      const double h = (until - now) / n_steps, from = now;
      for (double k = 0; k < n_steps; ++k) step(coefficients, from + k * h, h, q, v);
      now = until;
    }
    const OscillatorCoefficients at = coefficients(wanted);
    rows.row(i) << q, v, -2.0 * at.decay_per_s * v - at.omega0_rad_s * at.omega0_rad_s * q;
  }
  return rows;
}

}  // namespace klang::datasets
