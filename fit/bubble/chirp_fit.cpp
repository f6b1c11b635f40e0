#include "fit/bubble/chirp_fit.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/audio/fft.hpp"
#include "fit/least_squares/least_squares.hpp"

namespace klang::fit::bubble {
namespace {

constexpr int kOwn = Chirp::kParameters - 2;

class ChirpCost final : public ceres::CostFunction {
 public:
  ChirpCost(std::shared_ptr<const ChirpWindow> window, std::vector<ChirpLaw> laws, std::vector<int> pitch_group)
      : window_(std::move(window)), laws_(std::move(laws)), pitch_group_(std::move(pitch_group)) {
    n_groups_ = pitch_group_.empty() ? 0 : *std::max_element(pitch_group_.begin(), pitch_group_.end()) + 1;
    set_num_residuals(static_cast<int>(window_->n_real_data()));
    for (int g = 0; g < n_groups_; ++g) mutable_parameter_block_sizes()->push_back(2);
    for (std::size_t b = 0; b < laws_.size(); ++b) mutable_parameter_block_sizes()->push_back(kOwn);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const ChirpWindow& w = *window_;
    const Eigen::Index n = w.taper.size(), rows = w.n_real_data();
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n), value(n);
    Eigen::MatrixXd slopes;
    bool finite = true;  // what is not is refused: the solver then takes a shorter step
    if (jacobians) {
      for (int g = 0; g < n_groups_; ++g)
        if (jacobians[g]) Eigen::Map<RowMajor>(jacobians[g], rows, 2).setZero();
    }
    for (std::size_t b = 0; b < laws_.size(); ++b) {
      const Eigen::Matrix<double, Chirp::kParameters, 1> scale = chirp_scale(laws_[b]);
      Eigen::Matrix<double, Chirp::kParameters, 1> x;
      x.head<2>() = Eigen::Map<const Eigen::Vector2d>(parameters[pitch_group_[b]]);
      x.tail<kOwn>() = Eigen::Map<const Eigen::Matrix<double, kOwn, 1>>(parameters[n_groups_ + static_cast<int>(b)]);
      if (w.work) w.work->count(n, jacobians != nullptr);
      evaluate_chirp(laws_[b], Chirp::from(x.cwiseProduct(scale)), w.first_s, w.sample_rate_hz, value,
                     jacobians ? &slopes : nullptr);
      sum += value;
      if (!jacobians) continue;
      double* own = jacobians[n_groups_ + static_cast<int>(b)];
      double* shared = jacobians[pitch_group_[b]];
      Eigen::MatrixXd columns(rows, Chirp::kParameters);
      parallel_for(Chirp::kParameters, 1, [&](std::size_t begin, std::size_t end) {
        for (auto p = static_cast<Eigen::Index>(begin); p < static_cast<Eigen::Index>(end); ++p)
          columns.col(p) = w.weighted(slopes.col(p) * scale[p]);
      });
      for (int p = 0; p < Chirp::kParameters; ++p) {
        double* block = p < 2 ? shared : own;
        if (!block) continue;
        const auto column = columns.col(p);
        finite = finite && column.allFinite();
        if (p < 2) {
          Eigen::Map<RowMajor>(block, rows, 2).col(p) += column;
        } else {
          Eigen::Map<RowMajor>(block, rows, kOwn).col(p - 2) = column;
        }
      }
    }
    Eigen::Map<Eigen::VectorXd> r(residuals, rows);
    r = w.weighted(sum);
    r.head(w.n_bins) -= w.data.real().cwiseProduct(w.weight);
    r.tail(w.n_bins) -= w.data.imag().cwiseProduct(w.weight);
    return finite && r.allFinite();
  }

 private:
  std::shared_ptr<const ChirpWindow> window_;
  std::vector<ChirpLaw> laws_;
  std::vector<int> pitch_group_;
  int n_groups_ = 0;
};

/// (x - mean) / std for two numbers.
class PriorCost final : public ceres::SizedCostFunction<2, 2> {
 public:
  PriorCost(const Eigen::Vector2d& mean, const Eigen::Vector2d& standard_deviation)
      : mean_(mean), std_(standard_deviation) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int i = 0; i < 2; ++i) residuals[i] = (parameters[0][i] - mean_[i]) / std_[i];
    if (jacobians && jacobians[0]) {
      const double j[4] = {1.0 / std_[0], 0.0, 0.0, 1.0 / std_[1]};
      std::copy(j, j + 4, jacobians[0]);
    }
    return true;
  }

 private:
  Eigen::Vector2d mean_, std_;
};

class OnsetPrior final : public ceres::SizedCostFunction<1, kOwn> {
 public:
  OnsetPrior(double mean, double standard_deviation) : mean_(mean), std_(standard_deviation) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = (parameters[0][0] - mean_) / std_;
    if (jacobians && jacobians[0]) {
      std::fill(jacobians[0], jacobians[0] + kOwn, 0.0);
      jacobians[0][0] = 1.0 / std_;
    }
    return true;
  }

 private:
  double mean_, std_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> make_onset_prior(const ChirpLaw& law, const Chirp& found) {
  constexpr double kCycles = 0.05;
  const double unit_s = chirp_scale(law)[2];
  return std::make_unique<OnsetPrior>(found.onset_s / unit_s, kCycles / std::exp(found.log_frequency) / unit_s);
}

double NoiseSpectrum::at(double frequency_hz) const {
  const double x = std::clamp(frequency_hz / step_hz, 0.0, static_cast<double>(variance.size() - 1) - 1e-9);
  const auto i = static_cast<Eigen::Index>(x);
  const double t = x - static_cast<double>(i);
  return (1.0 - t) * variance[i] + t * variance[i + 1];
}

ChirpWindow::ChirpWindow(const Eigen::VectorXd& samples, double rate, const Place& place, const NoiseSpectrum& noise)
    : first_s(static_cast<double>(place.first) / rate),
      sample_rate_hz(rate),
      taper(Eigen::VectorXd::Ones(samples.size())) {
  const Eigen::Index n = samples.size();
  const Eigen::Index edge = std::max<Eigen::Index>(1, std::min(n / 8, static_cast<Eigen::Index>(0.002 * rate)));
  for (Eigen::Index i = 0; i < edge; ++i) {
    const double t = 0.5 - 0.5 * std::cos(kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(edge));
    if (place.first > 0) taper[i] *= t;
    if (place.first + n < place.n_recording) taper[n - 1 - i] *= t;
  }
  n_fft = audio::good_fft_size(n);
  const double bin_hz = rate / static_cast<double>(n_fft);
  const Eigen::Index last =
      std::min<Eigen::Index>(n_fft / 2, static_cast<Eigen::Index>(std::floor(place.high_hz / bin_hz)));
  first_bin = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::ceil(place.low_hz / bin_hz)), 1, last);
  n_bins = last - first_bin + 1;
  data = audio::real_spectrum(samples.cwiseProduct(taper), n_fft).segment(first_bin, n_bins);
  weight.resize(n_bins);
  const double energy = taper.squaredNorm();
  // Bins closer than 1/n are correlated: their information is spread over n_fft / n of them.
  const double share = std::sqrt(static_cast<double>(n) / static_cast<double>(n_fft));
  for (Eigen::Index k = 0; k < n_bins; ++k)
    weight[k] = share * std::sqrt(2.0 / (energy * noise.at(bin_hz * static_cast<double>(first_bin + k))));
}

Eigen::VectorXd ChirpWindow::weighted(const Eigen::VectorXd& samples) const {
  const Eigen::VectorXcd bins = audio::real_spectrum(samples.cwiseProduct(taper), n_fft).segment(first_bin, n_bins);
  Eigen::VectorXd result(2 * n_bins);
  result << bins.real().cwiseProduct(weight), bins.imag().cwiseProduct(weight);
  return result;
}

std::unique_ptr<ceres::CostFunction> make_chirp_cost(std::shared_ptr<const ChirpWindow> window,
                                                     std::vector<ChirpLaw> laws, std::vector<int> pitch_group) {
  return std::make_unique<ChirpCost>(std::move(window), std::move(laws), std::move(pitch_group));
}

Eigen::Matrix<double, Chirp::kParameters, 1> chirp_scale(const ChirpLaw& law) {
  Eigen::Matrix<double, Chirp::kParameters, 1> scale;
  scale << law.pitch->unit(), 1e-3, 1.0, 1.0, 1.0, 1.0;
  return scale;
}

double fit_amplitude(const ChirpWindow& window, const ChirpLaw& law, Chirp& chirp) {
  const Eigen::Index n = window.taper.size();
  if (window.work) {
    window.work->monitor().throw_if_stopped();
    window.work->count(2 * n, false);
  }
  Eigen::MatrixXd columns(window.n_real_data(), 2);
  Eigen::VectorXd value(n);
  for (int i = 0; i < 2; ++i) {
    Chirp unit = chirp;
    unit.cosine = i == 0 ? 1.0 : 0.0;
    unit.sine = i == 0 ? 0.0 : 1.0;
    evaluate_chirp(law, unit, window.first_s, window.sample_rate_hz, value);
    columns.col(i) = window.weighted(value);
  }
  Eigen::VectorXd data(window.n_real_data());
  data << window.data.real().cwiseProduct(window.weight), window.data.imag().cwiseProduct(window.weight);
  const Eigen::Matrix2d gram = columns.transpose() * columns;
  const Eigen::Vector2d image = columns.transpose() * data;
  const Eigen::Vector2d best = (gram + 1e-12 * gram.trace() * Eigen::Matrix2d::Identity()).ldlt().solve(image);
  if (!best.allFinite()) return data.squaredNorm();
  chirp.cosine = best[0];
  chirp.sine = best[1];
  return (data - columns * best).squaredNorm();
}

Eigen::MatrixXd parameter_covariance(ceres::Problem& problem, const std::vector<double*>& blocks) {
  ceres::Problem::EvaluateOptions at;
  at.parameter_blocks = blocks;
  ceres::CRSMatrix sparse;
  problem.Evaluate(at, nullptr, nullptr, nullptr, &sparse);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int r = 0; r < sparse.num_rows; ++r)
    for (int i = sparse.rows[static_cast<std::size_t>(r)]; i < sparse.rows[static_cast<std::size_t>(r) + 1]; ++i)
      jacobian(r, sparse.cols[static_cast<std::size_t>(i)]) = sparse.values[static_cast<std::size_t>(i)];
  // Columns of one length first: parameters of all units are judged alike.
  const Eigen::VectorXd norm = jacobian.colwise().norm().cwiseMax(1e-300).transpose();
  const Eigen::MatrixXd scaled = jacobian * norm.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = (scaled.transpose() * scaled).completeOrthogonalDecomposition().pseudoInverse();
  return inverse.cwiseQuotient(norm * norm.transpose());
}

ChirpFit fit_chirps(const ChirpWindow& window, const std::vector<ChirpLaw>& laws, const std::vector<Chirp>& start,
                    const PitchPrior& prior, int max_iterations, bool with_covariance) {
  ChirpFit fit;
  fit.chirps = start;
  fit.n_real_data = window.n_real_data();
  const int n = static_cast<int>(start.size());
  std::vector<std::array<double, 2>> pitch(start.size());
  std::vector<std::array<double, kOwn>> own(start.size());
  std::vector<int> groups(start.size());
  std::vector<double*> blocks(2 * start.size());
  for (std::size_t b = 0; b < start.size(); ++b) {
    const Eigen::Matrix<double, Chirp::kParameters, 1> x = start[b].vector().cwiseQuotient(chirp_scale(laws[b]));
    std::copy(x.data(), x.data() + 2, pitch[b].begin());
    std::copy(x.data() + 2, x.data() + Chirp::kParameters, own[b].begin());
    groups[b] = static_cast<int>(b);
    blocks[b] = pitch[b].data();
    blocks[start.size() + b] = own[b].data();
  }
  ceres::Problem::Options problem_options;
  ceres::Problem problem(problem_options);
  const std::shared_ptr<const ChirpWindow> view(&window, [](const ChirpWindow*) {});
  const auto id = problem.AddResidualBlock(make_chirp_cost(view, laws, groups).release(), nullptr, blocks);
  for (std::size_t b = 0; b < start.size(); ++b) {
    const auto scale = chirp_scale(laws[b]);
    if (prior.standard_deviation.allFinite())
      problem.AddResidualBlock(new PriorCost(prior.mean.cwiseQuotient(scale.head<2>()),
                                             prior.standard_deviation.cwiseQuotient(scale.head<2>())),
                               nullptr, pitch[b].data());
    const Eigen::Vector2d low = laws[b].pitch->low().cwiseQuotient(scale.head<2>()),
                          high = laws[b].pitch->high().cwiseQuotient(scale.head<2>());
    for (int i = 0; i < 2; ++i) {
      problem.SetParameterLowerBound(pitch[b].data(), i, low[i]);
      problem.SetParameterUpperBound(pitch[b].data(), i, high[i]);
      double& x = pitch[b][static_cast<std::size_t>(i)];
      x = std::clamp(x, low[i] + 0.01 * (high[i] - low[i]), high[i] - 0.01 * (high[i] - low[i]));
    }
    if (!laws[b].soft_attack())
      problem.AddResidualBlock(make_onset_prior(laws[b], start[b]).release(), nullptr, own[b].data());
    const double f = own[b][1], decay = own[b][2], t = own[b][0];
    problem.SetParameterLowerBound(own[b].data(), 0, t - 30.0);
    problem.SetParameterUpperBound(own[b].data(), 0, t + 30.0);
    problem.SetParameterLowerBound(own[b].data(), 1, f - 0.4);
    problem.SetParameterUpperBound(own[b].data(), 1, f + 0.4);
    problem.SetParameterLowerBound(own[b].data(), 2, decay - 4.0);
    problem.SetParameterUpperBound(own[b].data(), 2, decay + 4.0);
  }
  ceres::Solver::Options options;
  options.max_num_iterations = max_iterations;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-8;
  options.parameter_tolerance = 1e-10;
  const ceres::Solver::Summary summary =
      least_squares(options, problem, window.work ? window.work->monitor() : silent_monitor());
  fit.ok = summary.IsSolutionUsable();
  for (std::size_t b = 0; b < start.size(); ++b) {
    Eigen::Matrix<double, Chirp::kParameters, 1> x;
    x << pitch[b][0], pitch[b][1], Eigen::Map<Eigen::Matrix<double, kOwn, 1>>(own[b].data());
    fit.chirps[b] = Chirp::from(x.cwiseProduct(chirp_scale(laws[b])));
  }
  double cost = 0.0;
  problem.EvaluateResidualBlock(id, false, &cost, nullptr, nullptr);
  fit.chi_square = 2.0 * cost;
  if (with_covariance) {
    const Eigen::MatrixXd all = parameter_covariance(problem, blocks);
    for (int b = 0; b < n; ++b) {
      Eigen::MatrixXd c(Chirp::kParameters, Chirp::kParameters);
      std::array<Eigen::Index, Chirp::kParameters> at_column{};
      for (int p = 0; p < Chirp::kParameters; ++p)
        at_column[static_cast<std::size_t>(p)] = p < 2 ? 2 * b + p : 2 * n + kOwn * b + p - 2;
      const auto scale = chirp_scale(laws[static_cast<std::size_t>(b)]);
      for (int i = 0; i < Chirp::kParameters; ++i)
        for (int j = 0; j < Chirp::kParameters; ++j) {
          const Eigen::Index ci = at_column[static_cast<std::size_t>(i)], cj = at_column[static_cast<std::size_t>(j)];
          c(i, j) = all(ci, cj) * scale[i] * scale[j];
        }
      fit.covariance.push_back(c);
    }
  }
  return fit;
}

}  // namespace klang::fit::bubble
