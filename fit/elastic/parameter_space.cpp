#include "fit/elastic/parameter_space.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"

namespace klang::fit {
namespace {

// Beyond these no known solid lies; a start outside widens them.
constexpr double kPoissonLow = -0.1, kPoissonHigh = 0.485;
constexpr double kPoissonRegularisationStd = 0.1, kDensityRegularisationStd = 0.1, kDimensionRegularisationStd = 0.02,
                 kSingleRegularisationStd = 0.0;

void append(Eigen::VectorXd& vector, double value) {
  vector.conservativeResize(vector.size() + 1);
  vector[vector.size() - 1] = value;
}

}  // namespace

void ParameterSpace::add(const std::string& name, double start, double low, double high, double regularisation_std) {
  names_.push_back(name);
  append(start_, start);
  append(low_, low);
  append(high_, high);
  append(regularisation_std_, regularisation_std);
}

ParameterSpace::ParameterSpace(const FitProblem& problem) {
  young0_ = problem.material.youngs_modulus_pa();
  poisson0_ = problem.material.poissons_ratio();
  lambda0_ = problem.material.lame_lambda_pa;
  mu0_ = problem.material.lame_mu_pa;
  density0_ = problem.material.density_kg_m3;
  std::vector<std::string> elastic;
  for (const std::string& name : problem.parameters) {
    if (name == "lame_lambda_pa" || name == "lame_mu_pa" || name == "youngs_modulus_pa" || name == "poissons_ratio") {
      elastic.push_back(name);
    } else if (name == "shear_modulus_pa") {
      elastic.push_back("lame_mu_pa");
    }
  }
  n_elastic_ = static_cast<int>(elastic.size());
  KLANG_CHECK(n_elastic_ <= 2, "at most two elastic constants");
  const double poisson_low = std::min(kPoissonLow, 0.5 * (poisson0_ - 1.0));
  const double poisson_high = std::max(kPoissonHigh, 0.5 * (poisson0_ + 0.5));
  if (n_elastic_ == 2) {
    add("youngs_modulus_pa", 0.0, -5.0, 5.0, 0.0);
    add("poissons_ratio", poisson0_, poisson_low, poisson_high, kPoissonRegularisationStd);
  } else if (n_elastic_ == 1) {
    single_ = elastic.front();
    if (single_ == "poissons_ratio") {
      add(single_, poisson0_, poisson_low, poisson_high, kPoissonRegularisationStd);
    } else if (single_ == "lame_lambda_pa") {
      add(single_, lambda0_ / mu0_, -0.6, 60.0, 2.0);
    } else {
      add(single_, 0.0, -5.0, 5.0, kSingleRegularisationStd);
    }
  }
  if (std::count(problem.parameters.begin(), problem.parameters.end(), "density_kg_m3")) {
    density_at_ = size();
    add("density_kg_m3", 0.0, -3.0, 3.0, kDensityRegularisationStd);
  }
  for (const Specimen& specimen : problem.specimens) {
    specimen_names_.push_back(specimen.name);
    dimensions_.emplace_back();
    dimension_at_.emplace_back();
    dimension0_.emplace_back();
    if (!specimen.shape) continue;
    for (const auto& [dimension, value] : specimen.shape->dims) {
      const std::string name = specimen.name + "." + dimension;
      if (!std::count(problem.parameters.begin(), problem.parameters.end(), name)) continue;
      dimensions_.back().push_back(dimension);
      dimension_at_.back().push_back(size());
      dimension0_.back().push_back(value);
      add(name, 0.0, -0.3, 0.3, kDimensionRegularisationStd);
    }
  }
}

ParameterSpace::Elastic ParameterSpace::elastic(const Eigen::VectorXd& x) const {
  Elastic e{young0_, poisson0_, lambda0_, mu0_, {}, {}, {}, {}};
  e.d_young = e.d_poisson = e.d_lambda = e.d_mu = Eigen::VectorXd::Zero(size());
  if (n_elastic_ == 0) return e;
  const bool by_lame = n_elastic_ == 1 && (single_ == "lame_lambda_pa" || single_ == "lame_mu_pa");
  if (by_lame) {
    if (single_ == "lame_lambda_pa") {
      e.lambda = mu0_ * x[0];
      e.d_lambda[0] = mu0_;
    } else {
      e.mu = mu0_ * std::exp(x[0]);
      e.d_mu[0] = e.mu;
    }
    const double sum = e.lambda + e.mu;
    e.young = e.mu * (3.0 * e.lambda + 2.0 * e.mu) / sum;
    e.poisson = e.lambda / (2.0 * sum);
    e.d_young = e.mu * e.mu / (sum * sum) * e.d_lambda +
                (3.0 * e.lambda * e.lambda + 4.0 * e.lambda * e.mu + 2.0 * e.mu * e.mu) / (sum * sum) * e.d_mu;
    e.d_poisson = (e.mu * e.d_lambda - e.lambda * e.d_mu) / (2.0 * sum * sum);
    return e;
  }
  if (n_elastic_ == 2 || single_ == "youngs_modulus_pa") {
    e.young = young0_ * std::exp(x[0]);
    e.d_young[0] = e.young;
  }
  if (n_elastic_ == 2 || single_ == "poissons_ratio") {
    const Eigen::Index at = n_elastic_ - 1;
    e.poisson = x[at];
    e.d_poisson[at] = 1.0;
  }
  const double nu = e.poisson, a = 1.0 + nu, b = 1.0 - 2.0 * nu;
  e.lambda = e.young * nu / (a * b);
  e.mu = e.young / (2.0 * a);
  e.d_lambda = nu / (a * b) * e.d_young + e.young * (1.0 + 2.0 * nu * nu) / (a * a * b * b) * e.d_poisson;
  e.d_mu = e.d_young / (2.0 * a) - e.young / (2.0 * a * a) * e.d_poisson;
  return e;
}

ParameterSpace::Local ParameterSpace::local(std::size_t specimen, const Eigen::VectorXd& x) const {
  const Elastic e = elastic(x);
  const auto& at = dimension_at_[specimen];
  Local local;
  local.point.lame_lambda_pa = e.lambda;
  local.point.lame_mu_pa = e.mu;
  local.point.density_kg_m3 = density0_ * (density_at_ >= 0 ? std::exp(x[density_at_]) : 1.0);
  local.derivative = Eigen::MatrixXd::Zero(3 + static_cast<Eigen::Index>(at.size()), size());
  if (size() > 0) {
    local.derivative.row(0) = e.d_lambda.transpose();
    local.derivative.row(1) = e.d_mu.transpose();
  }
  if (density_at_ >= 0) local.derivative(2, density_at_) = 1.0;
  for (std::size_t d = 0; d < at.size(); ++d) {
    const double value = dimension0_[specimen][d] * std::exp(x[at[d]]);
    local.point.dimensions.push_back(value);
    local.derivative(3 + static_cast<Eigen::Index>(d), at[d]) = value;
  }
  return local;
}

ParameterSpace::Quantity ParameterSpace::quantity(const std::string& name, const Eigen::VectorXd& x) const {
  const auto slash = name.find('/');
  if (slash != std::string::npos) {
    const Quantity a = quantity(name.substr(0, slash), x), b = quantity(name.substr(slash + 1), x);
    return {a.value / b.value, a.gradient / b.value - a.value / (b.value * b.value) * b.gradient};
  }
  const Elastic e = elastic(x);
  if (name == "youngs_modulus_pa") return {e.young, e.d_young};
  if (name == "poissons_ratio") return {e.poisson, e.d_poisson};
  if (name == "lame_lambda_pa") return {e.lambda, e.d_lambda};
  if (name == "lame_mu_pa" || name == "shear_modulus_pa") return {e.mu, e.d_mu};
  if (name == "bulk_modulus_pa") return {e.lambda + 2.0 / 3.0 * e.mu, e.d_lambda + 2.0 / 3.0 * e.d_mu};
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size());
  if (name == "density_kg_m3") {
    const double value = density0_ * (density_at_ >= 0 ? std::exp(x[density_at_]) : 1.0);
    if (density_at_ >= 0) gradient[density_at_] = value;
    return {value, gradient};
  }
  for (std::size_t s = 0; s < dimensions_.size(); ++s) {
    for (std::size_t d = 0; d < dimensions_[s].size(); ++d) {
      if (name != specimen_names_[s] + "." + dimensions_[s][d]) continue;
      const double value = dimension0_[s][d] * std::exp(x[dimension_at_[s][d]]);
      gradient[dimension_at_[s][d]] = value;
      return {value, gradient};
    }
  }
  KLANG_CHECK(false, "unknown quantity " + name);
}

Eigen::VectorXd ParameterSpace::shifted(const Eigen::VectorXd& x, double log_factor) const {
  Eigen::VectorXd y = x;
  const bool stiffness = n_elastic_ == 2 || single_ == "youngs_modulus_pa" || single_ == "lame_mu_pa";
  if (stiffness) {
    y[0] += 2.0 * log_factor;
  } else if (density_at_ >= 0) {
    y[density_at_] -= 2.0 * log_factor;
  }
  return y.cwiseMax(low_).cwiseMin(high_);
}

double ParameterSpace::largest_dimension_step(const Eigen::VectorXd& x) const {
  double step = 0.0;
  for (const auto& coordinates : dimension_at_) {
    for (const Eigen::Index j : coordinates) step = std::max(step, std::abs(x[j] - start_[j]));
  }
  return step;
}

Eigen::VectorXd ParameterSpace::with_poissons_ratio(const Eigen::VectorXd& x, double poissons_ratio) const {
  Eigen::VectorXd y = x;
  if (n_elastic_ == 2) y[1] = std::clamp(poissons_ratio, low_[1], high_[1]);
  return y;
}

}  // namespace klang::fit
