#include "fit/ringdown/detail/sub_band_fit.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/foundation/base/conventions.hpp"
#include "fit/least_squares/least_squares.hpp"

namespace klang::fit::detail {
namespace {

/// Real form of complex bins: real parts above imaginary parts.
Eigen::MatrixXd stacked(const Eigen::MatrixXcd& a) {
  Eigen::MatrixXd result(2 * a.rows(), a.cols());
  result.topRows(a.rows()) = a.real();
  result.bottomRows(a.rows()) = a.imag();
  return result;
}

/// Columns (ar, ai) of each pole, then Legendre polynomials times 1 and i. The derivative columns belong to
/// the first 2p.
struct Design {
  Eigen::MatrixXd phi;                        ///< 2 n_bins x (2p + 2 kBackgroundTerms)
  std::vector<Eigen::MatrixXd> by_parameter;  ///< 2p of them: 2 n_bins x 2, by f [Hz] and decay [1/s] of each pole
};

Design make_design(const BinBlock& block, const std::vector<Pole>& poles, bool with_derivatives) {
  const Eigen::Index n_bins = block.y.size();
  const auto p = static_cast<Eigen::Index>(poles.size());
  Design design;
  design.phi = Eigen::MatrixXd::Zero(2 * n_bins, 2 * p + 2 * kBackgroundTerms);
  for (Eigen::Index i = 0; i < p; ++i) {
    const Pole& pole = poles[static_cast<std::size_t>(i)];
    const ExponentialColumns columns =
        exponential_columns(block, pole.frequency_hz, pole.decay_per_s, with_derivatives);
    design.phi.middleCols(2 * i, 2) = stacked(columns.value);
    if (with_derivatives) {
      design.by_parameter.push_back(stacked(columns.by_frequency));
      design.by_parameter.push_back(stacked(columns.by_decay));
    }
  }
  for (Eigen::Index j = 0; j < n_bins; ++j) {
    const double x = n_bins > 1 ? 2.0 * static_cast<double>(j) / static_cast<double>(n_bins - 1) - 1.0 : 0.0;
    const double terms[kBackgroundTerms] = {1.0, x, 1.5 * x * x - 0.5};
    for (Eigen::Index t = 0; t < kBackgroundTerms; ++t) {
      design.phi(j, 2 * p + 2 * t) = terms[t];
      design.phi(n_bins + j, 2 * p + 2 * t + 1) = terms[t];
    }
  }
  return design;
}

class ProjectedCost final : public ceres::CostFunction {
 public:
  ProjectedCost(BinBlock block, std::vector<Pole> start, double time_scale_s, double noise_rms)
      : block_(std::move(block)),
        start_(std::move(start)),
        time_scale_s_(time_scale_s),
        weight_(std::sqrt(2.0) / noise_rms) {
    set_num_residuals(static_cast<int>(2 * block_.y.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(2 * start_.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const bool slopes = jacobians != nullptr && jacobians[0] != nullptr;
    std::vector<Pole> poles = start_;
    for (std::size_t i = 0; i < poles.size(); ++i) {
      poles[i].frequency_hz += parameters[0][2 * i] / (2 * kPi * time_scale_s_);
      poles[i].decay_per_s = parameters[0][2 * i + 1] / time_scale_s_;
    }
    const Design design = make_design(block_, poles, slopes);
    const Eigen::Index rows = design.phi.rows(), cols = design.phi.cols();
    if (!design.phi.allFinite()) return false;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(design.phi);
    const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(rows, cols);
    const auto r = qr.matrixQR().topRows(cols).triangularView<Eigen::Upper>();
    const Eigen::VectorXd y = stacked(block_.y);
    const Eigen::VectorXd qy = q.transpose() * y;
    const Eigen::VectorXd rest = y - q * qy;
    Eigen::Map<Eigen::VectorXd>(residuals, rows) = weight_ * rest;
    if (!slopes) return true;
    const Eigen::VectorXd pivots = qr.matrixQR().diagonal().cwiseAbs();
    // Where two poles fall together one of them takes all, and what is left of the slope leads on from there.
    const bool together = !(pivots.minCoeff() > 1e-13 * pivots.maxCoeff());
    const Eigen::VectorXd c = together ? Eigen::VectorXd(design.phi.colPivHouseholderQr().solve(y)) : r.solve(qy);
    // d(rest) = -(1 - Q Q^T) dPhi c - Q R^-T dPhi^T rest, with dPhi in the two columns of one pole.
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
        jacobians[0], rows, static_cast<Eigen::Index>(2 * poles.size()));
    for (Eigen::Index k = 0; k < jacobian.cols(); ++k) {
      const Eigen::MatrixXd& d_phi = design.by_parameter[static_cast<std::size_t>(k)];
      const Eigen::Index column = 2 * (k / 2);
      const Eigen::VectorXd moved = d_phi * c.segment(column, 2);
      Eigen::VectorXd d_rest = -(moved - q * (q.transpose() * moved));
      Eigen::VectorXd turned = Eigen::VectorXd::Zero(cols);
      turned.segment(column, 2) = d_phi.transpose() * rest;
      if (!together) {
        r.transpose().solveInPlace(turned);
        d_rest -= q * turned;
      }
      const double unit = k % 2 == 0 ? 1 / (2 * kPi * time_scale_s_) : 1 / time_scale_s_;
      jacobian.col(k) = weight_ * unit * d_rest;
    }
    return jacobian.allFinite();
  }

 private:
  BinBlock block_;
  std::vector<Pole> start_;
  double time_scale_s_;
  double weight_;
};

}  // namespace

Eigen::Index SubBand::n_real_data() const {
  Eigen::Index n = 0;
  for (const BinBlock& block : blocks) n += 2 * block.y.size();
  return n;
}

LinearFit linear_fit(const SubBand& band, const std::vector<Pole>& poles) {
  LinearFit fit;
  for (const BinBlock& block : band.blocks) {
    const Design design = make_design(block, poles, false);
    const Eigen::VectorXd y = stacked(block.y);
    const Eigen::VectorXd c = design.phi.colPivHouseholderQr().solve(y);
    const Eigen::VectorXd rest = y - design.phi * c;
    Eigen::VectorXcd residual(block.y.size());
    residual.real() = rest.head(block.y.size());
    residual.imag() = rest.tail(block.y.size());
    fit.residual_sum_sq += rest.squaredNorm();
    fit.coefficients.push_back(c);
    fit.residuals.push_back(std::move(residual));
  }
  return fit;
}

std::unique_ptr<ceres::CostFunction> make_projected_cost(const BinBlock& block, const std::vector<Pole>& start,
                                                         double time_scale_s, double noise_rms) {
  return std::make_unique<ProjectedCost>(block, start, time_scale_s, noise_rms);
}

RefinedFit refine(const SubBand& band, const std::vector<Pole>& start, bool precise) {
  RefinedFit result;
  result.poles = start;
  if (start.empty()) {
    result.linear = linear_fit(band, start);
    result.ok = true;
    return result;
  }
  double power = 0;
  for (const BinBlock& block : band.blocks) power += block.y.squaredNorm();
  const double scale = std::sqrt(power / static_cast<double>(std::max<Eigen::Index>(1, band.n_real_data())));
  if (!(scale > 0)) return result;

  const double time_s = band.time_scale_s;
  std::vector<double> x;
  double low = band.blocks.front().frequency_hz(0), high = low;
  for (const BinBlock& block : band.blocks) high = std::max(high, block.frequency_hz(block.y.size() - 1));
  for (const Pole& pole : start) {
    x.push_back(0.0);
    x.push_back(pole.decay_per_s * time_s);
  }
  ceres::Problem::Options problem_options;
  problem_options.disable_all_safety_checks = true;
  ceres::Problem problem(problem_options);
  problem.AddParameterBlock(x.data(), static_cast<int>(x.size()));
  for (const BinBlock& block : band.blocks) {
    problem.AddResidualBlock(make_projected_cost(block, start, time_s, scale).release(), nullptr, x.data());
  }
  for (std::size_t i = 0; i < start.size(); ++i) {
    const auto f = static_cast<int>(2 * i);
    const double below = 2 * kPi * (low - start[i].frequency_hz) * time_s;
    const double above = 2 * kPi * (high - start[i].frequency_hz) * time_s;
    if (!(below <= 0 && above >= 0)) return result;
    problem.SetParameterLowerBound(x.data(), f, below);
    problem.SetParameterUpperBound(x.data(), f, above);
    problem.SetParameterLowerBound(x.data(), f + 1, -2.0);
    problem.SetParameterUpperBound(x.data(), f + 1, 300.0);
    x[2 * i + 1] = std::clamp(x[2 * i + 1], -1.9, 299.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = precise ? 40 : 15;
  options.function_tolerance = precise ? 1e-9 : 1e-5;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-10;
  options.max_num_consecutive_invalid_steps = 20;
  const ceres::Solver::Summary summary = least_squares(options, problem);
  if (!summary.IsSolutionUsable()) return result;
  for (std::size_t i = 0; i < start.size(); ++i) {
    result.poles[i].frequency_hz = start[i].frequency_hz + x[2 * i] / (2 * kPi * time_s);
    result.poles[i].decay_per_s = x[2 * i + 1] / time_s;
  }
  result.linear = linear_fit(band, result.poles);
  result.ok = std::isfinite(result.linear.residual_sum_sq);
  return result;
}

FitCovariance covariance(const SubBand& band, const std::vector<Pole>& poles, const LinearFit& linear,
                         double noise_variance) {
  FitCovariance result;
  const auto n = static_cast<Eigen::Index>(2 * poles.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  std::vector<Eigen::MatrixXd> inverse_gram, shifts;
  for (std::size_t b = 0; b < band.blocks.size(); ++b) {
    const Design design = make_design(band.blocks[b], poles, true);
    const Eigen::Index rows = design.phi.rows(), cols = design.phi.cols();
    if (!design.phi.allFinite()) return result;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(design.phi);
    const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(rows, cols);
    const Eigen::MatrixXd r = qr.matrixQR().topRows(cols).triangularView<Eigen::Upper>();
    if (!(r.diagonal().cwiseAbs().minCoeff() > 1e-12 * r.diagonal().cwiseAbs().maxCoeff())) return result;
    Eigen::MatrixXd moved(rows, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      moved.col(k) = design.by_parameter[static_cast<std::size_t>(k)] * linear.coefficients[b].segment(2 * (k / 2), 2);
    }
    const Eigen::MatrixXd along = q.transpose() * moved;
    const Eigen::MatrixXd across = moved - q * along;
    information += across.transpose() * across;
    const Eigen::MatrixXd inverse_r = r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(cols, cols));
    inverse_gram.push_back((inverse_r * inverse_r.transpose()).topLeftCorner(n, n));
    shifts.push_back(-(inverse_r * along).topRows(n));
  }
  // Half of E|noise|^2 falls on each of the real and imaginary parts.
  const double variance = 0.5 * noise_variance;
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scale.asDiagonal() * information * scale.asDiagonal());
  if (n > 0 && !(ldlt.vectorD().minCoeff() > 1e-14)) return result;
  result.poles =
      variance * (scale.asDiagonal() * ldlt.solve(Eigen::MatrixXd::Identity(n, n)) * scale.asDiagonal()).eval();
  for (std::size_t b = 0; b < band.blocks.size(); ++b) {
    result.cross.push_back(shifts[b] * result.poles);
    result.amplitudes_held.push_back(variance * inverse_gram[b]);
    result.amplitudes.push_back(result.amplitudes_held[b] + result.cross[b] * shifts[b].transpose());
  }
  result.ok = result.poles.allFinite();
  return result;
}

}  // namespace klang::fit::detail
