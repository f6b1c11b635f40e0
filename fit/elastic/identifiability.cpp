#include "fit/elastic/identifiability.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/math/statistics.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"

namespace klang::fit {
namespace {

/// Inverse of a symmetric positive semi-definite matrix; directions without information get a huge variance.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& information) {
  if (information.size() == 0) return information;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const double floor = std::max(1e-13 * eigen.eigenvalues().maxCoeff(), 1e-8);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(floor).cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose();
}

Eigen::MatrixXd regularisation_information(const ParameterSpace& space, const Eigen::VectorXd& regularisation) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(space.size(), space.size());
  for (Eigen::Index j = 0; j < space.size(); ++j) {
    if (space.regularisation_std()[j] > 0.0)
      information(j, j) = std::pow(regularisation[j] / space.regularisation_std()[j], 2);
  }
  return information;
}

struct Uncertainty {
  double std = 0.0, assumed_std = 0.0;  // absolute; the second is the share that the regularisation leaves open
  double relative = 0.0, assumed_relative = 0.0;
  double value = 0.0;
};

/// Size against which an error counts: the value; for Poisson's ratio, which may be zero, at least 0.25.
double scale_of(const std::string& name, double value) {
  return name == "poissons_ratio" ? std::max(std::abs(value), 0.25) : std::abs(value);
}

Uncertainty uncertainty(const ParameterSpace& space, const Eigen::VectorXd& x, const std::string& name,
                        const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& assumed,
                        const Eigen::MatrixXd& systematic) {
  const auto quantity = space.quantity(name, x);
  const Eigen::VectorXd spread = covariance * quantity.gradient;
  Uncertainty u;
  u.value = quantity.value;
  u.std = std::sqrt(std::max(0.0, quantity.gradient.dot(spread)) + (systematic.transpose() * spread).squaredNorm());
  u.assumed_std = std::sqrt(std::max(0.0, spread.dot(assumed * spread)));
  const double scale = std::max(scale_of(name, u.value), 1e-300);
  u.relative = u.std / scale;
  u.assumed_relative = u.assumed_std / scale;
  return u;
}

double threshold(const std::string& name) {
  return name.find('.') != std::string::npos ? kDeterminedDimensionStd : kDeterminedStd;
}

bool determined(const std::string& name, const Uncertainty& u) {
  return u.relative <= threshold(name) && u.assumed_relative <= kAssumedStd;
}

/// Where a parameter's variance comes from: std^2 = g P g + sum over common errors of (pull . P g)^2. Of a given quantity the
/// model's ln f moves by the slope s, the estimate by -P J^T W s.
void add_budget(const ParameterSpace& space, const ElasticFit& fit, const FitParameter& parameter,
                const Eigen::MatrixXd& posterior, std::vector<BudgetEntry>& budget) {
  const auto quantity = space.quantity(parameter.name, fit.x);
  const Eigen::VectorXd spread = posterior * quantity.gradient;
  const double variance = std::pow(*parameter.std, 2);
  const auto add = [&](const std::string& source, std::optional<double> sensitivity, std::optional<double> part) {
    BudgetEntry& entry = budget.emplace_back();
    entry.parameter = parameter.name;
    entry.source = source;
    entry.sensitivity = sensitivity;
    entry.contribution_std = part;
    if (part && variance > 0.0) entry.share = *part * *part / variance;
  };
  add("partials", {}, std::sqrt(std::max(0.0, quantity.gradient.dot(spread))));
  double mesh = (fit.systematic.transpose() * spread).squaredNorm();
  for (const GivenQuantity& given : fit.given) {
    const double slope = -given.pull.dot(spread);  // d parameter / d ln given
    std::optional<double> part;
    if (given.relative_std) part = std::abs(slope) * *given.relative_std;
    if (part) mesh -= *part * *part;
    std::optional<double> sensitivity;
    if (quantity.value != 0.0) sensitivity = slope / quantity.value;
    add(given.name, sensitivity, part);
  }
  add("mesh", {}, std::sqrt(std::max(0.0, mesh)));
}

/// Nothing that was fitted moves it.
bool quantity_is_given(const ParameterSpace& space, const Eigen::VectorXd& x, const std::string& name) {
  const auto quantity = space.quantity(name, x);
  return quantity.gradient.cwiseAbs().maxCoeff() <= 1e-12 * std::max(std::abs(quantity.value), 1e-12);
}

std::string shown(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// What the data do say, in words: the best determined of the usual combinations, else the direction of most
/// information as a product of powers.
std::string determined_instead(const ParameterSpace& space, const ElasticFit& fit, const Eigen::MatrixXd& covariance,
                               const Eigen::MatrixXd& assumed) {
  struct Combination {
    const char* name;
    const char* text;
    double unit;
    const char* unit_text;
  };
  std::vector<Combination> combinations;
  if (space.elastic_is_free()) {
    combinations = {{"youngs_modulus_pa", "E = mu (3 lambda + 2 mu) / (lambda + mu)", 1e9, "GPa"},
                    {"lame_mu_pa", "the shear modulus mu", 1e9, "GPa"},
                    {"bulk_modulus_pa", "the bulk modulus lambda + 2 mu / 3", 1e9, "GPa"}};
  }
  if (space.density_is_free() && space.elastic_is_free()) {
    combinations.push_back({"youngs_modulus_pa/density_kg_m3", "the ratio E / rho", 1e6, "MPa m3/kg"});
    combinations.push_back({"lame_mu_pa/density_kg_m3", "the ratio mu / rho", 1e6, "MPa m3/kg"});
  }
  const Combination* best = nullptr;
  Uncertainty best_u;
  for (const Combination& combination : combinations) {
    const Uncertainty u = uncertainty(space, fit.x, combination.name, covariance, assumed, fit.systematic);
    if (!determined(combination.name, u) || !(u.std > 0.0)) continue;
    // Earlier ones are better known: a later one must be clearly better.
    if (!best || u.relative < 0.9 * best_u.relative) best = &combination, best_u = u;
  }
  if (best) {
    return std::string("the partials determine ") + best->text + " = " + shown("%.4g ", best_u.value / best->unit) +
           best->unit_text + shown(" (std %.2g %%)", 100.0 * best_u.relative);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(fit.information);
  const Eigen::Index m = space.size();
  if (m == 0 || !(eigen.eigenvalues()[m - 1] > 0.0)) return "the partials determine nothing of it";
  Eigen::VectorXd direction = eigen.eigenvectors().col(m - 1);
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  direction /= direction[largest];
  std::string text = "the partials determine only the combination";
  for (Eigen::Index j = 0; j < m; ++j) {
    if (std::abs(direction[j]) < 0.02) continue;
    const std::string& name = item(space.coordinate_names(), j);
    text += name == "poissons_ratio" ? " exp(" + shown("%.2g", direction[j]) + " " + name + ")"
                                     : " " + name + shown("^%.2g", direction[j]);
  }
  return text;
}

/// Empty where all are there.
std::string missing_tolerances(const std::vector<GivenQuantity>& given) {
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> missing;
  for (const GivenQuantity& quantity : given)
    if (!quantity.relative_std) missing.push_back(quantity.name);
  if (missing.empty()) return {};
  if (missing.size() == given.size()) return kWithoutTolerances;
  std::string text = missing.size() == 1 ? "without the tolerance of " : "without the tolerances of ";
  for (std::size_t i = 0; i < std::min(kNamed, missing.size()); ++i) text += (i > 0 ? ", " : "") + missing[i];
  if (missing.size() > kNamed) text += " and " + std::to_string(missing.size() - kNamed) + " more";
  return text;
}

}  // namespace

Eigen::VectorXd regularisation_factors(const ParameterSpace& space, const ElasticFit& fit) {
  Eigen::VectorXd factor = Eigen::VectorXd::Ones(space.size());
  const Eigen::MatrixXd covariance = inverse(fit.information + fit.prior_information);
  for (Eigen::Index j = 0; j < space.size(); ++j) {
    const std::string& name = item(space.coordinate_names(), j);
    const double scale =
        name == "poissons_ratio" || name == "lame_lambda_pa" ? scale_of("poissons_ratio", fit.x[j]) : 1.0;
    const double common = (fit.systematic.transpose() * covariance.col(j)).squaredNorm();
    if (std::sqrt(covariance(j, j) + common) <= threshold(name) * scale) factor[j] = 0.0;
  }
  return factor;
}

Eigen::VectorXd prediction_std(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                               const ElasticFit& fit, const Eigen::VectorXd& regularisation) {
  const SpectrumModel& model = *models[specimen];
  const Eigen::MatrixXd posterior =
      inverse(fit.information + fit.prior_information + regularisation_information(space, regularisation));
  const ParameterSpace::Local local = space.local(specimen, fit.x);
  const Eigen::MatrixXd gradient = 0.5 * model.spectrum(local.point).derivative * local.derivative;  // of ln f by x
  const Eigen::MatrixXd spread = gradient * posterior;
  Eigen::VectorXd variance =
      spread.cwiseProduct(gradient).rowwise().sum() + (spread * fit.systematic).rowwise().squaredNorm();
  variance.array() += fit.scatter * fit.scatter;
  if (const Eigen::VectorXd mesh = model.relative_error(); mesh.size() == variance.size()) variance += mesh.cwiseAbs2();
  return variance.cwiseMax(0.0).cwiseSqrt();
}

ElasticReport elastic_report(const ParameterSpace& space, const ElasticFit& fit, const Eigen::VectorXd& regularisation,
                             const FitProblem& problem) {
  ElasticReport report;
  if (space.size() == 0) return report;
  const Eigen::MatrixXd assumed = regularisation_information(space, regularisation);
  const Eigen::MatrixXd data_only = inverse(fit.information + assumed);
  const Eigen::MatrixXd posterior = inverse(fit.information + fit.prior_information + assumed);
  const double quantile = student_t_975(fit.degrees_of_freedom);
  const std::string instead = determined_instead(space, fit, data_only, assumed);

  std::vector<std::pair<std::string, bool>> names;  // name, derived
  for (const std::string& name : problem.parameters) {
    if (!damping::is_law_parameter(name)) names.emplace_back(name, false);
  }
  if (space.elastic_is_free()) {
    for (const char* name :
         {"youngs_modulus_pa", "poissons_ratio", "lame_lambda_pa", "lame_mu_pa", "bulk_modulus_pa"}) {
      const bool asked = std::any_of(names.begin(), names.end(), [&](const auto& n) {
        return n.first == name || (n.first == "shear_modulus_pa" && std::string(name) == "lame_mu_pa");
      });
      if (!asked) names.emplace_back(name, true);
    }
  }
  std::vector<Eigen::VectorXd> gradients;
  for (const auto& [name, derived] : names) {
    const Uncertainty alone = uncertainty(space, fit.x, name, data_only, assumed, fit.systematic);
    const Uncertainty all = uncertainty(space, fit.x, name, posterior, assumed, fit.systematic);
    FitParameter parameter;
    parameter.name = name;
    parameter.value = all.value;
    parameter.start_value = space.quantity(name, space.start()).value;
    parameter.derived = derived;
    parameter.identifiable = determined(name, alone);
    bool at_bound = false;
    for (Eigen::Index j = 0; j < space.size(); ++j) {
      const double reach = 1e-6 * (space.high()[j] - space.low()[j]);
      const bool matters = std::abs(space.quantity(name, fit.x).gradient[j]) > 0.0;
      const bool bound = fit.x[j] - space.low()[j] <= reach || space.high()[j] - fit.x[j] <= reach;
      const bool own = item(space.coordinate_names(), j) != "poissons_ratio" || name != "youngs_modulus_pa";
      at_bound = at_bound || (bound && matters && own);
    }
    if (derived && !space.ratio_is_free()) {
      // One elastic number was fitted: the others are that number and an assumption, no measurement.
      parameter.identifiable = false;
      parameter.why = "Poisson's ratio was given, not fitted";
    } else if (at_bound) {
      parameter.identifiable = false;
      parameter.why = "the fit ran to the edge of what is allowed; " + instead;
    } else if (parameter.identifiable || determined(name, all)) {
      parameter.std = all.std;
      parameter.ci95 = {{all.value - quantile * all.std, all.value + quantile * all.std}};
      if (!parameter.identifiable) parameter.why = "known by the priors, not by the partials; " + instead;
    } else {
      parameter.why = instead + ", not " + name + " alone";
    }
    if (parameter.identifiable && !derived) {
      gradients.push_back(space.quantity(name, fit.x).gradient);
    }
    parameter.given = derived && !space.ratio_is_free() && quantity_is_given(space, fit.x, name);
    if (parameter.std) parameter.caveat = missing_tolerances(fit.given);
    if (parameter.std) add_budget(space, fit, parameter, posterior, report.budget);
    report.parameters.push_back(std::move(parameter));
  }
  for (const auto& a : gradients) {
    report.correlation.emplace_back();
    for (const auto& b : gradients) {
      const double norm = std::sqrt(a.dot(posterior * a) * b.dot(posterior * b));
      report.correlation.back().push_back(norm > 0.0 ? a.dot(posterior * b) / norm : 0.0);
    }
  }
  return report;
}

}  // namespace klang::fit
