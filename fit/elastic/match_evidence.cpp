#include "fit/elastic/match_evidence.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/math/statistics.hpp"

namespace klang::fit {
namespace {

constexpr double kStiffnessStd = 0.35, kPoissonStd = 0.12, kDimensionStd = 0.02, kLambdaOverMuStd = 1.0;
constexpr double kCentsPerLog = 1200.0 / 0.693147180559945309417;
constexpr int kScatters = 24;  // of the integral, in equal steps of the logarithm from 0.02 to 60 cents
constexpr double kLeastCents = 0.02, kMostCents = 60.0;

/// ln density of Student's t, 5 degrees of freedom: one bad residual is no proof against a match.
double log_t5(double x) { return std::log(8.0 / (3.0 * kPi * std::sqrt(5.0))) - 3.0 * std::log(1.0 + x * x / 5.0); }

double log_sum(const std::vector<double>& terms) {
  const double largest = *std::max_element(terms.begin(), terms.end());
  double sum = 0.0;
  for (const double term : terms) sum += std::exp(term - largest);
  return largest + std::log(sum);
}

}  // namespace

Eigen::VectorXd guess_std(const ParameterSpace& space) {
  Eigen::VectorXd std(space.size());
  for (Eigen::Index j = 0; j < space.size(); ++j) {
    const std::string& name = space.coordinate_names()[static_cast<std::size_t>(j)];
    std[j] = name == "poissons_ratio"              ? kPoissonStd
             : name == "lame_lambda_pa"            ? kLambdaOverMuStd
             : name.find('.') != std::string::npos ? kDimensionStd
                                                   : kStiffnessStd;
  }
  return std;
}

double match_evidence(const ParameterSpace& space, const WeighedMatch& weighed, const ElasticFitOptions& options,
                      const MatchOptions& match) {
  const auto& [tables, lines, matches, data, fit] = weighed;
  double score = 0.0;
  for (std::size_t s = 0; s < tables.size(); ++s) score += match_prior_score(tables[s], lines[s], matches[s], match);
  const Eigen::VectorXd guess = guess_std(space);
  score -= 0.5 * (fit.x - space.start()).cwiseQuotient(guess).squaredNorm();
  const auto n = static_cast<Eigen::Index>(data.size());
  const Eigen::MatrixXd scaled = fit.derivative * guess.asDiagonal();  // of a guess's standard deviation
  const double median_cents = options.model_std * kCentsPerLog;
  // Half of a half-Student's weight lies below 0.741 scales (4 degrees of freedom).
  const double scale_cents = median_cents / 0.741;
  std::vector<double> terms;
  for (int g = 0; g < kScatters; ++g) {
    const double s = kLeastCents * std::pow(kMostCents / kLeastCents, g / (kScatters - 1.0));
    // Density of s times its step, s ds of the logarithm.
    double term = std::log(s / scale_cents) -
                  0.5 * (options.model_dof + 1.0) * std::log1p(s * s / (scale_cents * scale_cents * options.model_dof));
    Eigen::VectorXd inverse_std(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double total = std::hypot(s, data[static_cast<std::size_t>(i)].sigma * kCentsPerLog);
      term += log_t5(fit.residual[i] * kCentsPerLog / total) - std::log(total);
      inverse_std[i] = kCentsPerLog / total;
    }
    if (space.size() > 0) {
      const Eigen::MatrixXd rows = inverse_std.asDiagonal() * scaled;
      const Eigen::MatrixXd information =
          Eigen::MatrixXd::Identity(space.size(), space.size()) + rows.transpose() * rows;
      term -= Eigen::LLT<Eigen::MatrixXd>(information).matrixLLT().diagonal().array().log().sum();
    }
    terms.push_back(term);
  }
  return score + log_sum(terms);
}

ElasticFit linear_fit(const ParameterSpace& space, const Eigen::VectorXd& x, const Eigen::VectorXd& residual,
                      const Eigen::MatrixXd& derivative, const std::vector<ElasticDatum>& data,
                      const ElasticFitOptions& options) {
  ElasticFit fit;
  fit.x = x;
  fit.residual = residual;
  fit.derivative = derivative;
  const auto n = static_cast<Eigen::Index>(data.size()), m = space.size();
  if (m == 0) return fit;
  Eigen::VectorXd sigma(n), weight = Eigen::VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) sigma[i] = data[static_cast<std::size_t>(i)].sigma;
  const Eigen::VectorXd guess = guess_std(space);
  double scatter = options.model_std;
  for (int round = 0; round < 4; ++round) {
    const Eigen::VectorXd total_inverse = (sigma.array().square() + scatter * scatter).rsqrt();
    const Eigen::MatrixXd rows = total_inverse.asDiagonal() * derivative;
    Eigen::MatrixXd normal = rows.transpose() * rows;
    normal.diagonal() += guess.array().square().inverse().matrix();
    const Eigen::VectorXd pull =
        rows.transpose() * total_inverse.cwiseProduct(residual) - (x - space.start()).cwiseQuotient(guess.cwiseAbs2());
    const Eigen::VectorXd step = normal.ldlt().solve(pull);
    fit.x = (x + step).cwiseMax(space.low()).cwiseMin(space.high());
    fit.residual = residual - derivative * (fit.x - x);
    scatter = scatter_median(fit.residual, sigma, weight, static_cast<double>(std::min(n, m)), options.model_std,
                             options.model_dof);
  }
  fit.scatter = scatter;
  return fit;
}

}  // namespace klang::fit
