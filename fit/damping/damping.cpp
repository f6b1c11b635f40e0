#include "fit/damping/damping.hpp"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/math/statistics.hpp"
#include "core/geometry/mesh/surface_point.hpp"

namespace klang::fit {
namespace {

constexpr double kUnknownScatter = 0.2;   // relative, where one or two decays cannot show their scatter
constexpr double kLargestOwnStd = 0.7;    // relative; beyond it ln(decay) is no normal variable
constexpr double kIdentifiableStd = 0.5;  // relative; beyond it the 95 % interval reaches zero

constexpr std::size_t kMostParameters = 3;  // two of the material and the mounts

struct KindFacts {
  DampingKind kind;
  const char* text;
  std::vector<const char*> parameters;
};

const std::vector<KindFacts>& kinds() {
  static const std::vector<KindFacts> facts = {
      {DampingKind::kRayleigh, "rayleigh", {"rayleigh_stiffness_s", "rayleigh_mass_per_s"}},
      {DampingKind::kLossFactor, "loss_factor", {"loss_factor"}},
      {DampingKind::kMassOnly, "mass_only", {"rayleigh_mass_per_s"}},
      {DampingKind::kStiffnessOnly, "stiffness_only", {"rayleigh_stiffness_s"}},
      {DampingKind::kZener, "zener", {"zener_strength", "zener_relaxation_time_s"}},
  };
  return facts;
}

const KindFacts& facts_of(DampingKind kind) {
  for (const KindFacts& facts : kinds()) {
    if (facts.kind == kind) return facts;
  }
  KLANG_CHECK(false, "unknown damping kind");
}

struct Data {
  Eigen::VectorXd omega, log_decay, sigma;  // sigma of ln decay, measurement only
  Eigen::VectorXd radiation;                // known part of each decay [1/s], zero where it is not asked for
  Eigen::VectorXd mount;                    // decay by unit dampers at the mounts [1/kg], the same

  double log_total(DampingKind kind, const double* p, Eigen::Index i,
                   std::array<double, kMostParameters>& gradient) const {
    gradient.fill(0.0);
    return log_total_decay(kind, p, omega[i], radiation[i], mount[i], gradient.data());
  }
};

/// Weighted residuals (ln decay_i - ln model_i) / total_i over x = ln(parameter / scale): positive without constraints.
class DampingCost : public ceres::CostFunction {
 public:
  DampingCost(DampingKind kind, const Data& data, Eigen::VectorXd total_sigma, Eigen::VectorXd scale)
      : kind_(kind), data_(data), sigma_(std::move(total_sigma)), scale_(std::move(scale)) {
    set_num_residuals(static_cast<int>(data.omega.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(scale_.size()));
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Index n = scale_.size();
    std::array<double, kMostParameters> p{}, g{};
    for (Eigen::Index j = 0; j < n; ++j) p[static_cast<std::size_t>(j)] = scale_[j] * std::exp(blocks[0][j]);
    for (Eigen::Index i = 0; i < data_.omega.size(); ++i) {
      const double model = data_.log_total(kind_, p.data(), i, g);
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
  DampingKind kind_;
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

Eigen::VectorXd residuals_of(DampingKind kind, const Data& data, const Eigen::VectorXd& value) {
  Eigen::VectorXd residual(data.omega.size());
  std::array<double, kMostParameters> g{};
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    residual[i] = data.log_decay[i] - data.log_total(kind, value.data(), i, g);
  }
  return residual;
}

Solution solve_from(DampingKind kind, const Data& data, const Eigen::VectorXd& start) {
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
    problem.AddResidualBlock(new DampingCost(kind, data, total.cwiseMax(1e-9), solution.scale), nullptr, x.data());
    for (int j = 0; j < static_cast<int>(x.size()); ++j) {
      // Down to nothing (1e-9 of where it starts); a relaxation time stays within a thousandfold.
      const double reach = kind == DampingKind::kZener && j == 1 ? std::log(1e3) : std::log(1e9);
      problem.SetParameterLowerBound(x.data(), j, -reach);
      problem.SetParameterUpperBound(x.data(), j, reach);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-12;
    options.max_num_consecutive_invalid_steps = 100;  // round-off at the bottom of a valley is no failure
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) return solution;
    solution.value = x.array().exp() * solution.scale.array();
    const Eigen::VectorXd residual = residuals_of(kind, data, solution.value);
    const double scatter =
        scatter_estimate(residual, data.sigma, Eigen::VectorXd::Ones(n), n_parameters, kUnknownScatter, 0.0);
    const bool settled = std::abs(scatter - solution.scatter) <= 1e-6 * (1e-3 + scatter);
    solution.scatter = scatter;
    if (settled) break;
  }
  const Eigen::VectorXd residual = residuals_of(kind, data, solution.value);
  const Eigen::ArrayXd variance = data.sigma.array().square() + solution.scatter * solution.scatter;
  solution.minus_two_log_likelihood =
      (residual.array().square() / variance.max(1e-18) + variance.max(1e-18).log() + std::log(2.0 * kPi)).sum();
  solution.rms = std::sqrt((residual.array().exp() - 1.0).square().mean());
  solution.usable = solution.value.allFinite() && std::isfinite(solution.minus_two_log_likelihood);
  return solution;
}

/// Starts from moments of the data; where the surface has several valleys, from several places.
std::vector<Eigen::VectorXd> material_starts(DampingKind kind, const Data& data) {
  const Eigen::ArrayXd whole = data.log_decay.array().exp(), omega = data.omega.array();
  const Eigen::ArrayXd decay = (whole - data.radiation.array()).max(0.05 * whole);
  const auto log_mean = [](const Eigen::ArrayXd& values) { return std::exp(values.log().mean()); };
  const auto one = [](double a) { return Eigen::VectorXd::Constant(1, a); };
  const auto two = [](double a, double b) { return (Eigen::VectorXd(2) << a, b).finished(); };
  const double stiffness = log_mean(2.0 * decay / omega.square()), mass = log_mean(2.0 * decay);
  switch (kind) {
    case DampingKind::kRayleigh:
      return {two(0.5 * stiffness, 0.5 * mass), two(stiffness, 0.05 * mass), two(0.05 * stiffness, mass)};
    case DampingKind::kLossFactor:
      return {one(log_mean(2.0 * decay / omega))};
    case DampingKind::kMassOnly:
      return {one(mass)};
    case DampingKind::kStiffnessOnly:
      return {one(stiffness)};
    case DampingKind::kZener: {
      std::vector<Eigen::VectorXd> all;
      for (const double factor : {0.03, 0.3, 1.0, 3.0, 30.0}) {
        const double tau = factor / log_mean(omega);
        const Eigen::ArrayXd x = omega * tau;
        all.push_back(two(log_mean(2.0 * decay * (1.0 + x.square()) / (omega * x)), tau));
      }
      return all;
    }
  }
  return {};
}

std::vector<Eigen::VectorXd> starts(DampingKind kind, const Data& data) {
  const std::vector<Eigen::VectorXd> material = material_starts(kind, data);
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

DampingCandidate candidate_of(DampingKind kind, const Data& data) {
  DampingCandidate candidate;
  const KindFacts& facts = facts_of(kind);
  candidate.kind = kind;
  candidate.with_radiation = data.radiation.any();
  candidate.with_mount = data.mount.any();
  candidate.model = std::string(facts.text) + (candidate.with_radiation ? "_and_radiation" : "") +
                    (candidate.with_mount ? "_and_mount" : "");
  Solution best;
  for (const Eigen::VectorXd& start : starts(kind, data)) {
    const Solution solution = solve_from(kind, data, start);
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
    std::array<double, kMostParameters> g{};
    data.log_total(kind, best.value.data(), i, g);
    for (Eigen::Index j = 0; j < n_parameters; ++j) {
      jacobian(i, j) = g[static_cast<std::size_t>(j)] * best.scale[j] / total[i];
    }
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(jacobian.transpose() * jacobian);
  const double dof = count - static_cast<double>(n_parameters);
  const double quantile = dof >= 1.0 ? student_t_975(dof) : student_t_975(1e9);
  for (Eigen::Index j = 0; j < n_parameters; ++j) {
    FitParameter parameter;
    const auto at = static_cast<std::size_t>(j);
    parameter.name = at < facts.parameters.size() ? facts.parameters[at] : "mount_damping_n_s_per_m";
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

std::string to_text(DampingKind kind) { return facts_of(kind).text; }

const DampingCandidate* find_candidate(const DampingResult& damping, DampingKind kind) {
  for (const DampingCandidate& candidate : damping.candidates) {
    if (candidate.kind == kind) return &candidate;
  }
  return nullptr;
}

double log_decay(DampingKind kind, const double* p, double omega, double* gradient) {
  double decay = 0.0;
  switch (kind) {
    case DampingKind::kRayleigh:
      decay = 0.5 * (p[0] * omega * omega + p[1]);
      gradient[0] = 0.5 * omega * omega / decay;
      gradient[1] = 0.5 / decay;
      break;
    case DampingKind::kLossFactor:
      decay = 0.5 * p[0] * omega;
      gradient[0] = 1.0 / p[0];
      break;
    case DampingKind::kMassOnly:
      decay = 0.5 * p[0];
      gradient[0] = 1.0 / p[0];
      break;
    case DampingKind::kStiffnessOnly:
      decay = 0.5 * p[0] * omega * omega;
      gradient[0] = 1.0 / p[0];
      break;
    case DampingKind::kZener: {
      const double x = omega * p[1];
      decay = 0.5 * p[0] * omega * x / (1.0 + x * x);
      gradient[0] = 1.0 / p[0];
      gradient[1] = (1.0 - x * x) / (1.0 + x * x) / p[1];
      break;
    }
  }
  return std::log(decay);
}

double log_total_decay(DampingKind kind, const double* p, double omega, double radiation_per_s, double mount_per_kg,
                       double* gradient) {
  const double material = log_decay(kind, p, omega, gradient);
  if (radiation_per_s == 0.0 && mount_per_kg == 0.0) return material;
  const std::size_t n = facts_of(kind).parameters.size();
  const double own = std::exp(material), mount = mount_per_kg == 0.0 ? 0.0 : p[n] * mount_per_kg;
  const double total = own + radiation_per_s + mount;
  for (std::size_t j = 0; j < n; ++j) gradient[j] *= own / total;
  if (mount_per_kg != 0.0) gradient[n] = mount_per_kg / total;
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
  std::array<double, kMostParameters> p{}, gradient{};
  for (std::size_t j = 0; j < parameters.size() && j < kMostParameters; ++j) p[j] = parameters[j].value;
  return std::exp(log_total_decay(kind, p.data(), angular_frequency_rad_s, with_radiation ? radiation_per_s : 0.0,
                                  with_mount ? mount_per_kg : 0.0, gradient.data()));
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
    const DecayPoint& point = used[static_cast<std::size_t>(i)];
    data.omega[i] = 2.0 * kPi * point.frequency_hz;
    data.log_decay[i] = std::log(point.decay_per_s);
    data.sigma[i] = point.decay_std_per_s / point.decay_per_s;
    radiation[i] = point.radiation_per_s;
    mount[i] = point.mount_per_kg;
  }
  double best = 0.0, sum = 0.0;
  for (const KindFacts& facts : kinds()) {
    for (const bool radiates : {false, true}) {
      for (const bool mounted : {false, true}) {
        if ((radiates && !radiation.any()) || (mounted && !mount.any())) continue;
        Data with = data;
        if (radiates) with.radiation = radiation;
        if (mounted) with.mount = mount;
        DampingCandidate candidate = candidate_of(facts.kind, with);
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
