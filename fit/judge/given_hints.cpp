#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fit/judge/judge.hpp"

namespace klang::fit {
namespace {

constexpr double kCentsPerLog = 1200.0 / 0.693147180559945309417;
constexpr double kLeastCents = 0.3, kMostCents = 60.0;
constexpr int kScatters = 20;

struct Marginal {
  double log_evidence = 0.0;
  Eigen::VectorXd step, std;  // at the likeliest scatter
};

/// Of residuals that a linear model with columns of given prior deviation explains, the scatter integrated out.
Marginal marginal(const Eigen::VectorXd& residual, const Eigen::VectorXd& sigma, const Eigen::MatrixXd& columns,
                  const Eigen::VectorXd& prior_std, double model_std_cents) {
  const Eigen::Index m = columns.cols();
  const Eigen::MatrixXd scaled = columns * prior_std.asDiagonal();
  Marginal result;
  std::vector<double> terms;
  double best = -1e300;
  for (int g = 0; g < kScatters; ++g) {
    const double cents = kLeastCents * std::pow(kMostCents / kLeastCents, g / (kScatters - 1.0));
    const double relative = cents / model_std_cents * 0.741;  // a half-Student's median is 0.741 of its scale
    const double s = cents / kCentsPerLog;
    const Eigen::ArrayXd variance = sigma.array().square() + s * s;
    const Eigen::VectorXd weight = variance.inverse();
    const Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(m, m) + scaled.transpose() * weight.asDiagonal() * scaled;
    const Eigen::VectorXd pull = scaled.transpose() * weight.cwiseProduct(residual);
    const Eigen::LLT<Eigen::MatrixXd> factor(normal);
    const Eigen::VectorXd y = factor.solve(pull);
    const double term = std::log(relative) - 2.5 * std::log1p(relative * relative / 4.0) -
                        0.5 * (weight.cwiseProduct(residual).dot(residual) - pull.dot(y)) - 0.5 * variance.log().sum() -
                        factor.matrixLLT().diagonal().array().log().sum();
    terms.push_back(term);
    if (term <= best) continue;
    best = term;
    result.step = prior_std.cwiseProduct(y);
    const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(m, m));
    result.std = prior_std.cwiseProduct(covariance.diagonal().cwiseSqrt());
  }
  double sum = 0.0;
  for (const double term : terms) sum += std::exp(term - best);
  result.log_evidence = best + std::log(sum);
  return result;
}

}  // namespace

double given_error_std(GivenKind kind) { return kind == GivenKind::kModulus ? 0.05 : 0.03; }

std::vector<GivenHint> given_hints(const JudgedResiduals& r, double model_std_cents) {
  std::vector<GivenHint> hints;
  const Eigen::Index n = r.residual.size(), m = r.derivative.cols();
  if (n < 2) return hints;
  const Marginal none = marginal(r.residual, r.sigma, r.derivative, r.guess_std, model_std_cents);
  const Eigen::VectorXd left = r.residual - r.derivative * none.step;
  for (std::size_t d = 0; d < r.given.size(); ++d) {
    Eigen::MatrixXd columns(n, m + 1);
    columns << r.derivative, r.given[d].slope;
    Eigen::VectorXd prior(m + 1);
    prior << r.guess_std, given_error_std(r.given[d].kind);
    const Marginal with = marginal(r.residual, r.sigma, columns, prior, model_std_cents);
    GivenHint hint{d, with.log_evidence - none.log_evidence, with.step[m], with.std[m], "", with.step.head(m)};
    Eigen::Index most = 0;
    (left.cwiseAbs() - (r.residual - columns * with.step).cwiseAbs()).maxCoeff(&most);
    hint.ring = r.rings[static_cast<std::size_t>(most)];
    hints.push_back(std::move(hint));
  }
  std::stable_sort(hints.begin(), hints.end(),
                   [](const GivenHint& a, const GivenHint& b) { return a.log_odds > b.log_odds; });
  return hints;
}

std::vector<double> stiffness_powers(const JudgedResiduals& r) {
  const auto at = std::find(r.coordinates.begin(), r.coordinates.end(), "youngs_modulus_pa");
  std::vector<double> powers;
  if (at == r.coordinates.end() || r.residual.size() == 0) return powers;
  const Eigen::Index e = at - r.coordinates.begin();
  Eigen::MatrixXd normal = r.derivative.transpose() * r.derivative;
  // What the data do not determine stays: a trace of the guess's own pull, for residuals of a tenth of a per cent.
  normal.diagonal() += (1e-3 * r.guess_std.cwiseInverse()).cwiseAbs2();
  const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
  for (const GivenValue& given : r.given) powers.push_back(-factor.solve(r.derivative.transpose() * given.slope)[e]);
  return powers;
}

}  // namespace klang::fit
