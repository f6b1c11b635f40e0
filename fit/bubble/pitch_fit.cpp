#include "fit/bubble/pitch_fit.hpp"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/math/spline.hpp"
#include "fit/least_squares/least_squares.hpp"

namespace klang::fit::bubble {
namespace {

constexpr double kDeterminedStd = 0.2;  // as for elastic constants
constexpr double kLargestGrowth =
    3.0;  // of chi square, a free pitch against the shared constants; right rises give about 1
constexpr double kNormal95 = 1.959963984540054;
constexpr int kOwn = Chirp::kParameters - 2;

std::shared_ptr<const PitchLaw> law_of(const BubbleRise& rise, double max_factor) {
  if (rise.times_s.size() < 2) {
    const double depth = -rise.phi_m.front(), speed = rise.speed_m_s;
    return std::make_shared<const DepthPitch>([depth, speed](double t) { return depth - speed * t; },
                                              [speed](double) { return speed; }, max_factor);
  }
  const auto spline = std::make_shared<const klang::CubicSpline>(rise.times_s, rise.phi_m);
  return std::make_shared<const DepthPitch>([spline](double t) { return -spline->at(t).v; },
                                            [spline](double t) { return spline->at(t).d; }, max_factor);
}

PitchNumber number(std::string name, double value, double relative_std) {
  PitchNumber n;
  n.name = std::move(name);
  n.determined = relative_std <= kDeterminedStd;
  if (!n.determined) return n;  // what the solver began with is no finding
  n.value = value;
  n.standard_deviation = std::abs(value) * relative_std;
  // Of the logarithm: all are positive.
  n.low95 = value * std::exp(-kNormal95 * relative_std);
  n.high95 = value * std::exp(kNormal95 * relative_std);
  return n;
}

PitchNumber unknown(std::string name) {
  PitchNumber n;
  n.name = std::move(name);
  return n;
}

void sound_only(const BubbleSearchResult& found, PitchFitResult& result) {
  result.status = PitchStatus::kSoundOnly;
  result.message =
      "without the bubbles' rise, pitch tells each bubble's rate K v e^(eta (1 - d/|phi0|)) and growth eta v / |phi0| "
      "only (v: speed, d: depth at the onset); --rise FILE separates them";
  for (const char* name : {"k_delta_per_m", "eta", "phi0_m"}) result.parameters.push_back(unknown(name));
  for (const FoundBubble& bubble : found.found) {
    if (!bubble.is_bubble()) continue;
    const char* names[] = {"k_delta * speed * exp(eta (1 - depth/|phi0|)) [1/s]", "eta * speed / |phi0| [1/s]"};
    for (int i = 0; i < 2; ++i) {
      const double value = bubble.chirp.pitch[i],
                   spread = std::sqrt((*bubble.covariance)(i, i)) / std::max(std::abs(value), 1e-12);
      if (value > 0.0 && spread <= kDeterminedStd)
        result.identifiable.push_back(
            number("bubble at " + klang::to_text(std::round(1e4 * bubble.chirp.onset_s) / 1e4) + " s: " + names[i],
                   value, spread));
    }
  }
}

/// The joint problem's state: ln P, ln q and each bubble's own numbers.
struct Joint {
  std::array<double, 2> pitch{};
  std::map<std::size_t, std::array<double, 2>> free_pitch;  // of bubbles without a rise
  std::map<std::size_t, std::array<double, kOwn>> own;
  double cost = 1e300;
};

/// Which bubbles carry the joint fit, and by which laws all ring in it.
struct JointProblem {
  std::vector<std::shared_ptr<const PitchLaw>> along;  // of each bubble with a rise
  std::shared_ptr<const PitchLaw> shared;              // any of them: units and limits are the same
  std::vector<ChirpLaw> laws;                          // of each bubble
  std::vector<RingGroup> groups;                       // that hold a bubble with a rise
  std::size_t n_bubbles = 0;
};

/// The best joint fit so far.
struct JointFit {
  Joint joint;
  Eigen::MatrixXd covariance;  // of ln P, ln q
  double chi_square = 0.0;
  Eigen::Index n_data = 0;
  std::vector<double> ratios;  // chi square per datum of each group
};

/// Each bubble's rise: the nearest within reach of its onset.
JointProblem joint_problem(const BubbleSearchResult& found, const std::vector<BubbleRise>& rises, double max_factor) {
  JointProblem problem;
  problem.along.resize(found.found.size());
  for (std::size_t i = 0; i < found.found.size(); ++i) {
    if (!found.found[i].is_bubble()) continue;
    const BubbleRise* nearest = nullptr;
    const auto off = [&](const BubbleRise& rise) { return std::abs(rise.onset_s - found.found[i].chirp.onset_s); };
    for (const BubbleRise& rise : rises)
      if (off(rise) <= kRiseMatchS && (!nearest || off(rise) < off(*nearest))) nearest = &rise;
    if (!nearest) continue;
    problem.shared = problem.along[i] = law_of(*nearest, max_factor);
    ++problem.n_bubbles;
  }
  for (std::size_t i = 0; i < found.found.size(); ++i) {
    problem.laws.push_back(found.found[i].law);
    if (!problem.along[i]) continue;
    problem.laws.back().pitch = problem.along[i];
    problem.laws.back().rest_s.reset();  // the rise says when it rests
  }
  return problem;
}

/// What each bubble's own pitch leaves, for comparison.
double free_chi_square(const BubbleSearchResult& found, const std::vector<RingGroup>& groups) {
  double chi_square = 0.0;
  for (const RingGroup& group : groups) {
    std::vector<ChirpLaw> own_laws;
    std::vector<Chirp> chirps;
    for (const std::size_t i : group.members) {
      own_laws.push_back(found.found[i].law);
      chirps.push_back(found.found[i].chirp);
    }
    chi_square += fit_chirps(*group.window, own_laws, chirps, {}, 0, false).chi_square;
  }
  return chi_square;
}

/// All chirps as they were found, the shared numbers at (ln P, ln q).
Joint joint_start(const BubbleSearchResult& found, const std::vector<ChirpLaw>& laws, std::array<double, 2> pitch) {
  Joint joint;
  joint.pitch = pitch;
  for (std::size_t i = 0; i < found.found.size(); ++i) {
    const Chirp& chirp = found.found[i].chirp;
    const Eigen::Matrix<double, Chirp::kParameters, 1> x = chirp.vector().cwiseQuotient(chirp_scale(laws[i]));
    joint.free_pitch[i] = {x[0], x[1]};
    std::copy(x.data() + 2, x.data() + Chirp::kParameters, joint.own[i].begin());
  }
  return joint;
}

/// Adds a group's residuals and its bubbles' bounds. @return the residual block
ceres::ResidualBlockId add_group(const BubbleSearchResult& found, const JointProblem& of, const RingGroup& group,
                                 Joint& joint, ceres::Problem& problem) {
  std::vector<ChirpLaw> group_laws;
  std::vector<int> pitch_group;
  std::vector<double*> blocks = {joint.pitch.data()};
  for (const std::size_t i : group.members) {
    group_laws.push_back(of.laws[i]);
    pitch_group.push_back(of.along[i] ? 0 : static_cast<int>(blocks.size()));
    if (!of.along[i]) blocks.push_back(joint.free_pitch[i].data());
  }
  for (const std::size_t i : group.members) blocks.push_back(joint.own[i].data());
  const ceres::ResidualBlockId id =
      problem.AddResidualBlock(make_chirp_cost(group.window, group_laws, pitch_group).release(), nullptr, blocks);
  for (const std::size_t i : group.members) {
    if (!of.laws[i].soft_attack())
      problem.AddResidualBlock(make_onset_prior(of.laws[i], found.found[i].chirp).release(), nullptr,
                               joint.own[i].data());
    for (const auto& [index, reach] : {std::pair{0, 10.0}, {1, 0.2}, {2, 3.0}}) {
      const double middle = joint.own[i][static_cast<std::size_t>(index)];
      problem.SetParameterLowerBound(joint.own[i].data(), index, middle - reach);
      problem.SetParameterUpperBound(joint.own[i].data(), index, middle + reach);
    }
  }
  return id;
}

/// Shared numbers' covariance with all else free: their block of the inverse normal matrix.
Eigen::MatrixXd shared_covariance(ceres::Problem& problem, Joint& joint) {
  std::vector<double*> parameters = {joint.pitch.data()};
  for (auto& [i, own] : joint.own)
    if (problem.HasParameterBlock(own.data())) parameters.push_back(own.data());
  for (auto& [i, free] : joint.free_pitch)
    if (problem.HasParameterBlock(free.data())) parameters.push_back(free.data());
  const Eigen::MatrixXd covariance = parameter_covariance(problem, parameters).topLeftCorner(2, 2);
  // A direction that the data do not see at all has no place in a pseudo-inverse's small numbers.
  const Eigen::Matrix2d information = covariance.inverse();
  return information.allFinite() ? covariance : Eigen::MatrixXd(Eigen::Matrix2d::Identity() * 1e6);
}

/// The joint fit from a start, where it beats the best so far.
void fit_from(const BubbleSearchResult& found, const JointProblem& of, Joint joint, Monitor& monitor, JointFit& best) {
  ceres::Problem problem;
  std::vector<ceres::ResidualBlockId> ids;
  for (const RingGroup& group : of.groups) ids.push_back(add_group(found, of, group, joint, problem));
  for (int i = 0; i < 2; ++i) {
    problem.SetParameterLowerBound(joint.pitch.data(), i, of.shared->low()[i]);
    problem.SetParameterUpperBound(joint.pitch.data(), i, of.shared->high()[i]);
  }
  ceres::Solver::Options solver;
  solver.max_num_iterations = 60;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.function_tolerance = 1e-9;
  const ceres::Solver::Summary summary = least_squares(solver, problem, monitor);
  monitor.throw_if_stopped();
  if (!summary.IsSolutionUsable() || !(summary.final_cost < best.joint.cost)) return;
  best.joint = joint;
  best.joint.cost = summary.final_cost;
  best.chi_square = 0.0;
  best.n_data = 0;
  best.ratios.clear();
  for (const auto id : ids) {
    double cost = 0.0;
    problem.EvaluateResidualBlock(id, false, &cost, nullptr, nullptr);
    const int n = problem.GetCostFunctionForResidualBlock(id)->num_residuals();
    best.chi_square += 2.0 * cost;
    best.n_data += n;
    best.ratios.push_back(2.0 * cost / n);
  }
  best.covariance = shared_covariance(problem, joint);
}

/// What ln P and ln q say of the constants.
void add_constants(const JointFit& fit, const std::optional<double>& phi0_m, PitchFitResult& result) {
  const Eigen::MatrixXd covariance =
      fit.covariance * std::max(1.0, fit.chi_square / static_cast<double>(std::max<Eigen::Index>(fit.n_data, 1)));
  const double log_p = fit.joint.pitch[0], log_q = fit.joint.pitch[1], q = std::exp(log_q);
  // ln(K e^eta) = ln P + ln q.
  const Eigen::Vector2d of_q(0.0, 1.0), of_pq(1.0, 1.0);
  result.identifiable = {
      number("eta / |phi0| [1/m]", q, std::sqrt(of_q.dot(covariance * of_q))),
      number("k_delta * exp(eta) [1/m]", std::exp(log_p + log_q), std::sqrt(of_pq.dot(covariance * of_pq)))};
  std::erase_if(result.identifiable, [](const PitchNumber& n) { return !n.determined; });
  if (phi0_m) {
    const double eta = q * -*phi0_m;
    // ln K = ln P + ln q - q |phi0|.
    const Eigen::Vector2d of_k(1.0, 1.0 - eta);
    result.parameters = {number("k_delta_per_m", std::exp(log_p + log_q - eta), std::sqrt(of_k.dot(covariance * of_k))),
                         number("eta", eta, std::sqrt(of_q.dot(covariance * of_q))), unknown("phi0_m")};
    result.parameters.back().value = *phi0_m;
    result.message = "phi0 as given";
  } else {
    result.parameters = {unknown("k_delta_per_m"), unknown("eta"), unknown("phi0_m")};
    result.message = "K, eta and phi0 enter as K e^eta and eta / |phi0| only; --phi0-m separates them";
  }
}

}  // namespace

std::vector<BubbleRise> read_rises(const std::filesystem::path& path) {
  CsvFile file(path);
  const std::vector<std::string_view> even_columns = {"onset_s", "phi_m", "speed_m_s"},
                                      moment_columns = {"onset_s", "time_s", "phi_m"};
  const char* const allowed = "onset_s,phi_m,speed_m_s or onset_s,time_s,phi_m";
  if (!file.next()) throw InputError(file.name(), "holds no rise", {}, allowed);
  const bool even = file.cells() == even_columns;
  if (!even && file.cells() != moment_columns)
    throw InputError(file.place(), "has other columns", file.cells().front(), allowed);
  std::vector<BubbleRise> rises;
  while (file.next()) {
    const std::string place = file.place();
    if (file.cells().size() != 3)
      throw InputError(place, "has another number of columns", std::to_string(file.cells().size()), "3");
    const double onset = csv_number(file.cells()[0], place), a = csv_number(file.cells()[1], place),
                 b = csv_number(file.cells()[2], place);
    checked(place, "phi_m", even ? a : b, -10.0, -1e-6);
    if (even) {
      rises.push_back({onset, {0.0}, {a}, checked(place, "speed_m_s", b, -10.0, 10.0)});
      continue;
    }
    if (rises.empty() || rises.back().onset_s != onset) rises.push_back({onset, {}, {}, 0.0});
    BubbleRise& rise = rises.back();
    if (!rise.times_s.empty() && !(a > rise.times_s.back()))
      throw InputError(place, "time_s does not rise", to_text(a), "above " + to_text(rise.times_s.back()));
    rise.times_s.push_back(a);
    rise.phi_m.push_back(b);
  }
  if (rises.empty()) throw InputError(file.name(), "holds no rise", {}, allowed);
  for (const BubbleRise& rise : rises)
    if (!even && rise.times_s.size() < 2)
      throw InputError(file.name(), "has one moment only for the bubble at " + to_text(rise.onset_s) + " s");
  return rises;
}

PitchFitResult fit_pitch(const BubbleSearchResult& found, const std::vector<BubbleRise>& rises,
                         const BubbleSearchOptions& search, const PitchFitOptions& options, Monitor& monitor) {
  PitchFitResult result;
  validate_fields("pitch", options);
  JointProblem problem = joint_problem(found, rises, options.max_factor);
  result.n_bubbles = problem.n_bubbles;
  if (result.n_bubbles == 0) {
    sound_only(found, result);
    if (!rises.empty()) result.message = "no bubble was found near the rises' onsets; " + result.message;
    return result;
  }
  problem.groups = ring_groups(found, search, monitor);
  std::erase_if(problem.groups, [&](const RingGroup& group) {
    return std::none_of(group.members.begin(), group.members.end(),
                        [&](std::size_t i) { return problem.along[i] != nullptr; });
  });
  const double free = free_chi_square(found, problem.groups);
  JointFit best;
  // The published constants, and others: the problem has valleys where the chirps are weak.
  for (const double start_q : {124.0, 50.0, 300.0}) {
    const std::array<double, 2> start = {std::log(73.0 * std::exp(1.24) / 124.0), std::log(start_q)};
    fit_from(found, problem, joint_start(found, problem.laws, start), monitor, best);
  }
  if (best.joint.cost >= 1e300) {
    result.status = PitchStatus::kFailed;
    result.message = "the joint fit of the pitch constants did not converge";
    return result;
  }
  result.chi_square_per_datum = best.ratios;
  if (const double grown = best.chi_square / std::max(free, 1e-300); !(grown <= kLargestGrowth)) {
    result.status = PitchStatus::kFailed;
    result.message = "the given rise does not describe these bubbles: chi square is " +
                     klang::to_text(std::round(10.0 * grown) / 10.0) + " times that of a free pitch";
    return result;
  }
  result.status = PitchStatus::kFitted;
  add_constants(best, options.phi0_m, result);
  return result;
}

}  // namespace klang::fit::bubble
