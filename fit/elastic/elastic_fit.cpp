#include "fit/elastic/elastic_fit.hpp"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/statistics.hpp"
#include "fit/least_squares/least_squares.hpp"

namespace klang::fit {
namespace {

constexpr double kHuber = 2.0;

/// ln f_model of each datum and its derivative by x.
struct Prediction {
  Eigen::VectorXd log_frequency;
  Eigen::MatrixXd derivative;
};

Prediction predict(const ParameterSpace& space, const SpectrumModels& models, const std::vector<ElasticDatum>& data,
                   const Eigen::VectorXd& x) {
  const auto n = static_cast<Eigen::Index>(data.size());
  Prediction prediction{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, space.size())};
  std::vector<char> needed(models.size(), 0);
  for (const ElasticDatum& datum : data) item(needed, datum.specimen) = 1;
  parallel_for(models.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      if (!needed[s]) continue;
      const ParameterSpace::Local local = space.local(s, x);
      const Spectrum spectrum = models[s]->spectrum(local.point);
      const Eigen::MatrixXd by_x = spectrum.derivative * local.derivative;
      for (Eigen::Index i = 0; i < n; ++i) {
        const ElasticDatum& datum = item(data, i);
        if (static_cast<std::size_t>(datum.specimen) != s) continue;
        const auto add = [&](const std::vector<int>& modes, double sign) {
          const double share = sign * 0.5 / static_cast<double>(modes.size());
          for (const int mode : modes) {
            prediction.log_frequency[i] += share * item(spectrum.log_angular_frequency_sq, mode);
            prediction.derivative.row(i) += share * by_x.row(mode);
          }
        };
        prediction.log_frequency[i] = datum.over.empty() ? -std::log(2.0 * kPi) : 0.0;
        add(datum.modes, 1.0);
        if (!datum.over.empty()) add(datum.over, -1.0);
      }
    }
  });
  return prediction;
}

class ElasticCost : public ceres::CostFunction {
 public:
  ElasticCost(const ParameterSpace& space, const SpectrumModels& models, const std::vector<ElasticDatum>& data,
              Eigen::VectorXd total, Eigen::VectorXd regularisation, const std::map<std::string, Prior>& priors)
      : space_(space),
        models_(models),
        data_(data),
        total_(std::move(total)),
        regularisation_(std::move(regularisation)),
        priors_(priors) {
    const auto n = data.size() + priors.size() + static_cast<std::size_t>(space.size());
    set_num_residuals(static_cast<int>(n));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(space.size()));
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Index m = space_.size(), n = static_cast<Eigen::Index>(data_.size());
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(blocks[0], m);
    Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian =
        Eigen::MatrixXd::Zero(num_residuals(), m);
    const Prediction prediction = predict(space_, models_, data_, x);
    for (Eigen::Index i = 0; i < n; ++i) {
      out[i] = (item(data_, i).log_frequency - prediction.log_frequency[i]) / total_[i];
      jacobian.row(i) = -prediction.derivative.row(i) / total_[i];
    }
    Eigen::Index row = n;
    for (const auto& [name, prior] : priors_) {
      const ParameterSpace::Quantity quantity = space_.quantity(name, x);
      out[row] = (quantity.value - prior.mean) / prior.std;
      jacobian.row(row++) = quantity.gradient.transpose() / prior.std;
    }
    for (Eigen::Index j = 0; j < m; ++j, ++row) {
      const double pull =
          space_.regularisation_std()[j] > 0.0 ? regularisation_[j] / space_.regularisation_std()[j] : 0.0;
      out[row] = pull * (x[j] - space_.start()[j]);
      jacobian(row, j) = pull;
    }
    if (jacobians && jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(jacobians[0], num_residuals(),
                                                                                         m) = jacobian;
    }
    return out.allFinite() && jacobian.allFinite();
  }

 private:
  const ParameterSpace& space_;
  const SpectrumModels& models_;
  const std::vector<ElasticDatum>& data_;
  Eigen::VectorXd total_, regularisation_;
  const std::map<std::string, Prior>& priors_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> elastic_cost(const ParameterSpace& space, const SpectrumModels& models,
                                                  const std::vector<ElasticDatum>& data, const Eigen::VectorXd& total,
                                                  const Eigen::VectorXd& regularisation,
                                                  const std::map<std::string, Prior>& priors) {
  return std::make_unique<ElasticCost>(space, models, data, total, regularisation, priors);
}

ElasticFit fit_elastic(const ParameterSpace& space, const SpectrumModels& models, const std::vector<ElasticDatum>& data,
                       const Eigen::VectorXd& x0, const Eigen::VectorXd& regularisation,
                       const ElasticFitOptions& options) {
  const auto n = static_cast<Eigen::Index>(data.size());
  ElasticFit fit;
  fit.x = x0;
  fit.weight = Eigen::VectorXd::Ones(n);
  fit.scatter = options.model_std;
  Eigen::VectorXd sigma(n);
  for (Eigen::Index i = 0; i < n; ++i) sigma[i] = item(data, i).sigma;
  Prediction prediction;
  const auto measure = [&] {
    prediction = predict(space, models, data, fit.x);
    fit.residual.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      fit.residual[i] = item(data, i).log_frequency - prediction.log_frequency[i];
    }
  };
  measure();
  const Eigen::VectorXd first_residual = fit.residual;
  Eigen::VectorXd total;
  // Parameters that the data can use up: no more than there are data, nor directions left free.
  const double n_used = static_cast<double>(std::min(n, space.size()));
  for (int round = 0; round < options.max_rounds; ++round) {
    const Eigen::ArrayXd variance = sigma.array().square() + fit.scatter * fit.scatter;
    total = (variance / fit.weight.array()).sqrt();
    if (space.size() > 0) {
      ceres::Problem problem;
      problem.AddResidualBlock(elastic_cost(space, models, data, total, regularisation, options.priors).release(),
                               nullptr, fit.x.data());
      for (int j = 0; j < static_cast<int>(space.size()); ++j) {
        problem.SetParameterLowerBound(fit.x.data(), j, space.low()[j]);
        problem.SetParameterUpperBound(fit.x.data(), j, space.high()[j]);
      }
      ceres::Solver::Options solver;
      solver.linear_solver_type = ceres::DENSE_QR;
      solver.max_num_iterations = 60;
      solver.function_tolerance = 1e-10;
      solver.gradient_tolerance = 1e-12;
      solver.parameter_tolerance = 1e-10;
      solver.max_num_consecutive_invalid_steps = 30;
      const ceres::Solver::Summary summary = least_squares(solver, problem);
      fit.n_iterations += static_cast<int>(summary.iterations.size());
      fit.converged = summary.termination_type == ceres::CONVERGENCE;
      if (!summary.IsSolutionUsable()) return fit;
      measure();
    } else {
      fit.converged = true;
    }
    const double before = fit.scatter;
    fit.scatter = scatter_median(fit.residual, sigma, fit.weight, n_used, options.model_std, options.model_dof);
    double moved = std::abs(fit.scatter - before) / before;
    for (Eigen::Index i = 0; options.robust && i < n; ++i) {
      const double z = std::abs(fit.residual[i]) / std::hypot(sigma[i], fit.scatter);
      const double weight = z <= kHuber ? 1.0 : kHuber / z;
      moved = std::max(moved, std::abs(weight - fit.weight[i]));
      fit.weight[i] = weight;
    }
    if (moved <= 1e-4) break;
  }
  const Eigen::ArrayXd variance = sigma.array().square() + fit.scatter * fit.scatter;
  total = (variance / fit.weight.array()).sqrt();
  const Eigen::MatrixXd scaled = total.cwiseInverse().asDiagonal() * prediction.derivative;
  fit.information = scaled.transpose() * scaled;
  Eigen::MatrixXd common = Eigen::MatrixXd::Zero(n, 2);
  const double highest = prediction.log_frequency.size() ? prediction.log_frequency.maxCoeff() : 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const ElasticDatum& datum = item(data, i);
    const Eigen::VectorXd by_mode = item(models, datum.specimen)->relative_error();
    double error = 0.0;
    for (const int mode : datum.modes) {
      if (mode < by_mode.size()) error = std::max(error, by_mode[mode] / total[i]);
    }
    common.row(i) << error, error * std::exp(prediction.log_frequency[i] - highest);
  }
  fit.systematic = scaled.transpose() * common;
  fit.derivative = prediction.derivative;
  fit.prior_information = Eigen::MatrixXd::Zero(space.size(), space.size());
  for (const auto& [name, prior] : options.priors) {
    const Eigen::VectorXd g = space.quantity(name, fit.x).gradient / prior.std;
    fit.prior_information += g * g.transpose();
  }
  fit.degrees_of_freedom = std::max(1.0, fit.weight.sum() - n_used + options.model_dof);
  fit.cost_initial = 0.5 * first_residual.cwiseQuotient(total).squaredNorm();
  fit.cost_final = 0.5 * fit.residual.cwiseQuotient(total).squaredNorm();
  return fit;
}

}  // namespace klang::fit
