#include "fit/damping/damping.hpp"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/math/statistics.hpp"
#include "core/geometry/mesh/surface_point.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"
#include "fit/least_squares/least_squares.hpp"

namespace klang::fit {
namespace {

constexpr double kUnknownScatter = 0.2;   // relative, where one or two decays cannot show their scatter
constexpr double kLargestOwnStd = 0.7;    // relative; beyond it ln(decay) is no normal variable
constexpr double kIdentifiableStd = 0.5;  // relative; beyond it the 95 % interval reaches zero

constexpr std::size_t kMostParameters = damping::kMostLawParameters + 1;  // and the mounts'
constexpr std::string_view kMountParameter = "mount_damping_n_s_per_m";

using damping::DampingLaw;
using Gradient = std::array<double, kMostParameters>;

struct Data {
  Eigen::VectorXd omega, log_decay, sigma;  // sigma of ln decay, measurement only
  Eigen::VectorXd radiation;                // known part of each decay [1/s], zero where it is not asked for
  Eigen::VectorXd mount;                    // decay by unit dampers at the mounts [1/kg], the same

  double log_total(const DampingLaw& law, const double* p, Eigen::Index i, Gradient& gradient) const {
    gradient.fill(0.0);
    return log_total_decay(law, p, omega[i], {radiation[i], mount[i]}, gradient.data());
  }
};

/// Weighted residuals (ln decay_i - ln model_i) / total_i over x = ln(parameter / scale): positive without constraints.
class DampingCost : public ceres::CostFunction {
 public:
  DampingCost(const DampingLaw& law, const Data& data, Eigen::VectorXd total_sigma, Eigen::VectorXd scale)
      : law_(law), data_(data), sigma_(std::move(total_sigma)), scale_(std::move(scale)) {
    set_num_residuals(static_cast<int>(data.omega.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(scale_.size()));
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Index n = scale_.size();
    Gradient p{}, g{};
    for (Eigen::Index j = 0; j < n; ++j) item(p, j) = scale_[j] * std::exp(blocks[0][j]);
    for (Eigen::Index i = 0; i < data_.omega.size(); ++i) {
      const double model = data_.log_total(law_, p.data(), i, g);
      if (!std::isfinite(model)) return false;
      residuals[i] = (data_.log_decay[i] - model) / sigma_[i];
      for (Eigen::Index j = 0; jacobians && jacobians[0] && j < n; ++j) {
        const auto k = static_cast<std::size_t>(j);
        jacobians[0][i * n + j] = -g[k] * p[k] / sigma_[i];
      }
    }
    return true;
  }

 private:
  const DampingLaw& law_;
  const Data& data_;
  Eigen::VectorXd sigma_, scale_;
};

struct Solution {
  Eigen::VectorXd value;  // physical units
  Eigen::VectorXd scale;
  double scatter = 0.0;
  double minus_two_log_likelihood = 0.0;
  double rms = 0.0;
  bool usable = false;
};

Eigen::VectorXd residuals_of(const DampingLaw& law, const Data& data, const Eigen::VectorXd& value) {
  Eigen::VectorXd residual(data.omega.size());
  Gradient g{};
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    residual[i] = data.log_decay[i] - data.log_total(law, value.data(), i, g);
  }
  return residual;
}

Solution solve_from(const DampingLaw& law, const Data& data, const Eigen::VectorXd& start) {
  Solution solution;
  solution.value = start;
  solution.scale = start;
  solution.scatter = kUnknownScatter;
  const auto n = data.omega.size();
  const double n_parameters = static_cast<double>(start.size());
  for (int round = 0; round < 12; ++round) {
    const Eigen::VectorXd total = (data.sigma.array().square() + solution.scatter * solution.scatter).sqrt();
    ceres::Problem problem;
    Eigen::VectorXd x = solution.value.cwiseQuotient(solution.scale).array().log();
    problem.AddResidualBlock(new DampingCost(law, data, total.cwiseMax(1e-9), solution.scale), nullptr, x.data());
    for (int j = 0; j < static_cast<int>(x.size()); ++j) {
      const auto parameters = law.parameters();
      const auto at = static_cast<std::size_t>(j);
      const double reach = std::log(at < parameters.size() ? parameters[at].fit_reach : 1e9);
      problem.SetParameterLowerBound(x.data(), j, -reach);
      problem.SetParameterUpperBound(x.data(), j, reach);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-12;
    options.max_num_consecutive_invalid_steps = 100;  // round-off at the bottom of a valley is no failure
    const ceres::Solver::Summary summary = least_squares(options, problem);
    if (!summary.IsSolutionUsable()) return solution;
    solution.value = x.array().exp() * solution.scale.array();
    const Eigen::VectorXd residual = residuals_of(law, data, solution.value);
    const double scatter =
        scatter_estimate(residual, data.sigma, Eigen::VectorXd::Ones(n), n_parameters, kUnknownScatter, 0.0);
    const bool settled = std::abs(scatter - solution.scatter) <= 1e-6 * (1e-3 + scatter);
    solution.scatter = scatter;
    if (settled) break;
  }
  const Eigen::VectorXd residual = residuals_of(law, data, solution.value);
  const Eigen::ArrayXd variance = data.sigma.array().square() + solution.scatter * solution.scatter;
  solution.minus_two_log_likelihood =
      (residual.array().square() / variance.max(1e-18) + variance.max(1e-18).log() + std::log(2.0 * kPi)).sum();
  solution.rms = std::sqrt((residual.array().exp() - 1.0).square().mean());
  solution.usable = solution.value.allFinite() && std::isfinite(solution.minus_two_log_likelihood);
  return solution;
}

std::vector<Eigen::VectorXd> material_starts(const DampingLaw& law, const Data& data) {
  const Eigen::ArrayXd whole = data.log_decay.array().exp();
  return law.starts(data.omega.array(), (whole - data.radiation.array()).max(0.05 * whole));
}

std::vector<Eigen::VectorXd> starts(const DampingLaw& law, const Data& data) {
  const std::vector<Eigen::VectorXd> material = material_starts(law, data);
  if (!data.mount.any()) return material;
  const double all = data.log_decay.array().exp().mean() / data.mount.mean();
  std::vector<Eigen::VectorXd> both;
  for (const Eigen::VectorXd& start : material) {
    for (const double share : {0.5, 0.01}) {
      both.emplace_back(start.size() + 1);
      both.back() << (1.0 - share) * start, share * all;
    }
  }
  return both;
}

DampingCandidate candidate_of(const DampingLaw& law, const Data& data) {
  DampingCandidate candidate;
  const auto law_parameters = law.parameters();
  candidate.law = &law;
  candidate.with_radiation = data.radiation.any();
  candidate.with_mount = data.mount.any();
  candidate.model = std::string(law.name()) + (candidate.with_radiation ? "_and_radiation" : "") +
                    (candidate.with_mount ? "_and_mount" : "");
  Solution best;
  for (const Eigen::VectorXd& start : starts(law, data)) {
    const Solution solution = solve_from(law, data, start);
    if (solution.usable && (!best.usable || solution.minus_two_log_likelihood < best.minus_two_log_likelihood)) {
      best = solution;
    }
  }
  if (!best.usable) return candidate;
  const auto n = data.omega.size(), n_parameters = best.value.size();
  candidate.rms_relative_residual = best.rms;
  const double k = static_cast<double>(n_parameters) + 1.0, count = static_cast<double>(n);
  if (count - k - 1.0 > 0.0) {
    candidate.aicc = best.minus_two_log_likelihood + 2.0 * k + 2.0 * k * (k + 1.0) / (count - k - 1.0);
  }

  // Information in relative units of the start values, so that the two columns compare.
  const Eigen::ArrayXd total = (data.sigma.array().square() + best.scatter * best.scatter).sqrt().max(1e-9);
  Eigen::MatrixXd jacobian(n, n_parameters);
  for (Eigen::Index i = 0; i < n; ++i) {
    Gradient g{};
    data.log_total(law, best.value.data(), i, g);
    for (Eigen::Index j = 0; j < n_parameters; ++j) {
      jacobian(i, j) = item(g, j) * best.scale[j] / total[i];
    }
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(jacobian.transpose() * jacobian);
  const double dof = count - static_cast<double>(n_parameters);
  const double quantile = dof >= 1.0 ? student_t_975(dof) : student_t_975(1e9);
  for (Eigen::Index j = 0; j < n_parameters; ++j) {
    FitParameter parameter;
    const auto at = static_cast<std::size_t>(j);
    parameter.name = at < law_parameters.size() ? law_parameters[at].name : kMountParameter;
    parameter.value = best.value[j];
    parameter.start_value = best.scale[j];
    double variance = 0.0;
    for (Eigen::Index m = 0; m < n_parameters; ++m) {
      const double along = eigen.eigenvectors()(j, m);
      variance += along * along / std::max(eigen.eigenvalues()[m], 1e-30);
    }
    const double std = std::sqrt(variance) * best.scale[j];
    parameter.identifiable = dof >= 0.0 && std <= kIdentifiableStd * std::abs(parameter.value);
    if (std <= 1e3 * std::max(std::abs(parameter.value), best.scale[j])) {
      parameter.std = std;
      parameter.ci95 = {{std::max(0.0, parameter.value - quantile * std), parameter.value + quantile * std}};
    }
    if (!parameter.identifiable) {
      parameter.why =
          dof < 0.0 ? "fewer decays than parameters" : "its interval reaches zero: the decays do not need it";
      if (dof < 0.0) parameter.std.reset(), parameter.ci95.reset();
    }
    candidate.parameters.push_back(parameter);
  }
  return candidate;
}

}  // namespace

const DampingCandidate* find_candidate(const DampingResult& damping, const DampingLaw& law) {
  for (const DampingCandidate& candidate : damping.candidates) {
    if (candidate.law == &law) return &candidate;
  }
  return nullptr;
}

double log_total_decay(const DampingLaw& law, const double* p, double omega, const OtherDecay& other,
                       double* gradient) {
  law.log_gradient(omega, p, gradient);
  const double material = std::log(law.decay_per_s(omega, p));
  if (other.radiation_per_s == 0.0 && other.mount_per_kg == 0.0) return material;
  const std::size_t n = law.parameters().size();
  const double own = std::exp(material), mount = other.mount_per_kg == 0.0 ? 0.0 : p[n] * other.mount_per_kg;
  const double total = own + other.radiation_per_s + mount;
  for (std::size_t j = 0; j < n; ++j) gradient[j] *= own / total;
  if (other.mount_per_kg != 0.0) gradient[n] = other.mount_per_kg / total;
  return std::log(total);
}

Eigen::VectorXd mount_decay_per_kg(const modal::ModalModel& model, const std::vector<Mount>& mounts) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model.n_modes());
  for (const Mount& mount : mounts) {
    const Eigen::Map<const Eigen::Vector3d> at_m(mount.at_m.data());
    const mesh::SurfacePoint place = mesh::nearest_surface_point(model.mesh, at_m);
    Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(3, model.n_modes());
    for (std::size_t k = 0; k < place.nodes.size(); ++k)
      shapes += place.weights[static_cast<Eigen::Index>(k)] * model.shapes.middleRows(3 * place.nodes[k], 3);
    if (!mount.direction) {
      sum += 0.5 * shapes.colwise().squaredNorm().transpose();
    } else {
      const Eigen::Map<const Eigen::Vector3d> direction(mount.direction->data());
      sum += 0.5 * (direction.normalized().transpose() * shapes).cwiseAbs2().transpose();
    }
  }
  return sum;
}

double DampingCandidate::decay_per_s(double angular_frequency_rad_s, double radiation_per_s,
                                     double mount_per_kg) const {
  if (parameters.empty()) return 0.0;
  Gradient p{}, gradient{};
  for (std::size_t j = 0; j < parameters.size() && j < kMostParameters; ++j) p[j] = parameters[j].value;
  const OtherDecay other{with_radiation ? radiation_per_s : 0.0, with_mount ? mount_per_kg : 0.0};
  return std::exp(log_total_decay(*law, p.data(), angular_frequency_rad_s, other, gradient.data()));
}

DampingResult fit_damping(const std::vector<DecayPoint>& points, std::vector<std::string>& warnings) {
  std::vector<DecayPoint> used;
  for (const DecayPoint& point : points) {
    const bool fits = point.frequency_hz > 0 && point.decay_per_s > 0 && std::isfinite(point.decay_std_per_s) &&
                      point.decay_std_per_s >= 0 && point.decay_std_per_s <= kLargestOwnStd * point.decay_per_s;
    if (fits) used.push_back(point);
  }
  if (used.size() < points.size()) {
    warnings.push_back(std::to_string(points.size() - used.size()) + " decays left out: not positive or too uncertain");
  }
  DampingResult result;
  if (used.empty()) return result;
  if (used.size() <= 2) warnings.push_back("few decays: their scatter is assumed to be 20 %");

  const auto n = static_cast<Eigen::Index>(used.size());
  Data data{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd::Zero(n),
            Eigen::VectorXd::Zero(n)};
  Eigen::VectorXd radiation(n), mount(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const DecayPoint& point = item(used, i);
    data.omega[i] = 2.0 * kPi * point.frequency_hz;
    data.log_decay[i] = std::log(point.decay_per_s);
    data.sigma[i] = point.decay_std_per_s / point.decay_per_s;
    radiation[i] = point.radiation_per_s;
    mount[i] = point.mount_per_kg;
  }
  double best = 0.0, sum = 0.0;
  for (const DampingLaw* law : damping::damping_laws()) {
    for (const bool radiates : {false, true}) {
      for (const bool mounted : {false, true}) {
        if ((radiates && !radiation.any()) || (mounted && !mount.any())) continue;
        Data with = data;
        if (radiates) with.radiation = radiation;
        if (mounted) with.mount = mount;
        DampingCandidate candidate = candidate_of(*law, with);
        if (!candidate.parameters.empty()) result.candidates.push_back(std::move(candidate));
      }
    }
  }
  const auto rank = [](const DampingCandidate& c) {
    return c.aicc ? *c.aicc : 1e12 + 1e6 * static_cast<double>(c.parameters.size()) + c.rms_relative_residual;
  };
  std::stable_sort(result.candidates.begin(), result.candidates.end(),
                   [&](const DampingCandidate& a, const DampingCandidate& b) { return rank(a) < rank(b); });
  if (result.candidates.empty()) return result;
  best = rank(result.candidates.front());
  for (const DampingCandidate& c : result.candidates) sum += c.aicc ? std::exp(-0.5 * (*c.aicc - best)) : 0.0;
  for (DampingCandidate& c : result.candidates) {
    if (c.aicc) c.aicc_weight = std::exp(-0.5 * (*c.aicc - best)) / sum;
  }
  result.model = result.candidates.front().model;
  return result;
}

}  // namespace klang::fit
