#include "core/foundation/math/statistics.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang {

double student_t_975(double degrees_of_freedom) {
  KLANG_CHECK(degrees_of_freedom >= 1.0, "needs a degree of freedom");
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), 0.975);
}

double scatter_estimate(const Eigen::VectorXd& residual, const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                        double n_parameters, double prior_s, double prior_dof) {
  const double dof = weight.sum() - n_parameters + prior_dof;
  if (!(dof > 0.0)) return prior_s;
  // The excess falls with s: bisection in log s cannot fail.
  const auto excess = [&](double s) {
    double sum = prior_dof * prior_s * prior_s / (s * s);
    for (Eigen::Index i = 0; i < residual.size(); ++i) {
      sum += weight[i] * residual[i] * residual[i] / (sigma[i] * sigma[i] + s * s);
    }
    return sum - dof;
  };
  const double largest = std::max(residual.size() ? residual.cwiseAbs().maxCoeff() : 0.0, prior_s);
  if (!(largest > 0.0)) return 0.0;
  double low = 1e-9 * largest, high = 1e3 * largest;
  if (excess(low) <= 0.0) return 0.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = std::sqrt(low * high);
    (excess(middle) > 0.0 ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

double scatter_median(const Eigen::VectorXd& residual, const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                      double n_parameters, double prior_s, double prior_dof) {
  KLANG_CHECK(prior_s > 0.0 && prior_dof >= 1.0, "scatter_median: a prior with a scale");
  const double n = weight.sum();
  if (!(n > 0.0)) return prior_s;
  const double left = std::max(0.0, n - n_parameters) / n;
  // Upper quartile of Student's t in units of its scale, to a per mille: half-Student's median.
  const double quartile = 0.6744898 * (1.0 + 0.364 / prior_dof + 0.27 / (prior_dof * prior_dof));
  const double scale = prior_s / quartile;
  constexpr int kSteps = 600;
  const double low = std::log(1e-7 * scale), step = std::log(1e11) / kSteps;
  Eigen::VectorXd log_density(kSteps);
  for (int k = 0; k < kSteps; ++k) {
    const double s = std::exp(low + k * step), t = s / scale;
    // ln s: the grid is even in ln s, the prior a density in s.
    double value = std::log(s) - 0.5 * (prior_dof + 1.0) * std::log1p(t * t / prior_dof);
    for (Eigen::Index i = 0; i < residual.size(); ++i) {
      const double variance = sigma[i] * sigma[i] + s * s;
      value -= 0.5 * weight[i] * (left * std::log(variance) + residual[i] * residual[i] / variance);
    }
    log_density[k] = value;
  }
  const Eigen::VectorXd density = (log_density.array() - log_density.maxCoeff()).exp();
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    sum += density[k];
    if (sum >= 0.5 * density.sum()) {
      const double back = (sum - 0.5 * density.sum()) / density[k];
      return std::exp(low + (k + 0.5 - back) * step);
    }
  }
  return prior_s;
}

}  // namespace klang
