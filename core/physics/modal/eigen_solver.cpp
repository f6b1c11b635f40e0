#include "core/physics/modal/eigen_solver.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <future>
#include <optional>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/memory.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/foundation/la/block_mass.hpp"
#include "core/physics/modal/detail/cluster_orientation.hpp"
#include "core/physics/modal/detail/eigen_problem.hpp"
#include "core/physics/modal/detail/hierarchical_error.hpp"

namespace klang::modal {
namespace {

constexpr int kMaxSearches = 3;
constexpr int kMaxGuard = 64;
// From here on a pass through the factor costs more than what a block of vectors adds to it.
constexpr Eigen::Index kBlockFromNodes = 4000;
constexpr Eigen::Index kBlock = 8;
constexpr Eigen::Index kBlasAloneToDofs = 60000;

double omega_sq(double frequency_hz) { return std::pow(2 * kPi * frequency_hz, 2); }

struct Search {
  detail::Pairs pairs;
  detail::Proof proof;
  double count_at = 0;  // 0: not counted yet
  double iterate_s = 0;
};

/// The Sturm count on a thread of its own: where it is made does not depend on the last digits, so that it need not wait for them.
class EarlyCount {
 public:
  EarlyCount(detail::EigenProblem& problem, double& count_at) : problem_(problem), count_at_(count_at) {}
  bool started() const { return counting_.valid(); }
  void start(double omega_sq) {
    if (started() || !(omega_sq > 0)) return;
    count_at_ = omega_sq;
    blas_.emplace(1);
    counting_ = std::async(std::launch::async, [this] { problem_.n_below(count_at_); });
  }
  void finish() {
    if (started()) counting_.get();
    blas_.reset();
  }

 private:
  detail::EigenProblem& problem_;
  double& count_at_;
  std::optional<BlasThreads> blas_;  // two that compute at once share the threads
  std::future<void> counting_;       // last: done before the rest goes
};

// The lowest pairs: at least `n_wanted`, with guards above them so that a gap for the Sturm count is seen.
void find_lowest(detail::EigenProblem& problem, const EigenOptions& options, bool dense, Eigen::Index n_wanted,
                 Search& search) {
  for (Eigen::Index guard = 4; guard <= kMaxGuard; guard *= 4) {
    const Eigen::Index n = std::min(n_wanted + guard, problem.n_elastic());
    const Stopwatch watch;
    const bool too_many_for_lanczos = 4 * n + 8 * kBlock > problem.n_elastic();
    const bool proves = !dense && options.count > 0 && options.prove_none_missing;
    // Small products do not repay the threads that wait for the next one, on the cores that the factor is at work on.
    std::optional<BlasThreads> one;
    if (!dense && !too_many_for_lanczos && problem.n_dofs() < kBlasAloneToDofs) one.emplace(1);
    EarlyCount early(problem, search.count_at);
    if (dense || too_many_for_lanczos) {
      search.pairs = problem.lowest_dense(n);
    } else if (problem.n_dofs() >= 3 * kBlockFromNodes) {
      detail::EigenProblem::Watch look;
      if (proves && thread_count() > 1)
        look = [&](const Eigen::VectorXd& value, const Eigen::VectorXd& error) {
          early.start(detail::sure_gap_above(value, error, n_wanted));
        };
      search.pairs = problem.lowest_block(n, kBlock, options.tolerance, options.max_restarts, look);
    } else {
      search.pairs = problem.lowest(n, options.tolerance, options.max_restarts, {}, 0);
    }
    if (search.pairs.converged) {
      const double gap = detail::gap_above(search.pairs, n_wanted);
      if (proves && gap > 0 && !early.started()) {
        search.count_at = gap;
        problem.polish_and_count(search.pairs, gap);
      } else {
        problem.polish(search.pairs);
      }
    }
    early.finish();
    search.iterate_s += watch.seconds();
    if (!search.pairs.converged || n == problem.n_elastic() || detail::gap_above(search.pairs, n_wanted) > 0) return;
  }
}

/// One call of solve_modes() through its stages.
class ModeSearch {
 public:
  ModeSearch(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled, const solid::Material& material,
             const solid::Support& support, const EigenOptions& options, Monitor& monitor);
  EigenResult run();

 private:
  /// How many there are in the band is known before any is computed, and is the proof afterwards. False: all is said.
  bool count_in_band();
  void check_memory() const;
  /// The lowest n_wanted_ and those below the band, and the proof that none is missing.
  void search_upwards(bool dense);
  void prove();
  /// Pairs within the band as modes of the whole mesh; returns how many.
  Eigen::Index keep_modes(Eigen::VectorXd& round_off);
  void finish(EigenStatus status, std::string message);

  const mesh::TetMesh& mesh_;
  const solid::AssembledSolid& assembled_;
  EigenOptions options_;  // count may be set from most
  Monitor& monitor_;
  const Stopwatch total_;
  EigenResult result_;
  detail::EigenProblem problem_;
  Search search_;
  bool factored_ = false;
  Eigen::Index n_wanted_ = 0;
  Eigen::Index n_low_ = 0;      // elastic modes below the band
  Eigen::Index n_in_band_ = 0;  // and up to its upper end, where these are too many
};

ModeSearch::ModeSearch(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled,
                       const solid::Material& material, const solid::Support& support, const EigenOptions& options,
                       Monitor& monitor)
    : mesh_(mesh),
      assembled_(assembled),
      options_(options),
      monitor_(monitor),
      problem_(mesh, assembled, material),
      n_wanted_(options.count) {
  result_.model.mesh = mesh;
  result_.model.material = material;
  result_.model.support = support;
  result_.model.shapes.resize(3 * mesh.n_nodes(), 0);
  result_.n_rigid_modes = problem_.n_rigid();
}

EigenResult ModeSearch::run() {
  const auto n_free = static_cast<int>(assembled_.free_nodes.size());
  const bool dense = options_.method == EigenMethod::kDense ||
                     (options_.method == EigenMethod::kAuto && n_free < options_.dense_limit_nodes);
  result_.method_used = dense ? EigenMethod::kDense : EigenMethod::kShiftInvert;
  if (options_.count == 0 && !count_in_band()) return std::move(result_);
  if (n_wanted_ > problem_.n_elastic()) {
    throw InputError("eigenmodes", "more modes wanted than the mesh has", std::to_string(n_wanted_),
                     "at most " + std::to_string(problem_.n_elastic()));
  }
  if (std::string message; !factored_ && !problem_.factor(message)) {
    finish(EigenStatus::kFailed, message);
    return std::move(result_);
  }
  monitor_.progress("eigenmodes", 0.3);
  monitor_.throw_if_stopped();
  search_upwards(dense);

  Eigen::VectorXd round_off;
  const Eigen::Index n_modes = keep_modes(round_off);
  if (!search_.pairs.converged) {
    finish(EigenStatus::kNotConverged, search_.pairs.message);
    return std::move(result_);
  }
  for (Eigen::Index k = 0; k < n_modes; ++k) {
    if (result_.relative_residual[k] <= std::max(options_.tolerance, round_off[k])) continue;
    finish(EigenStatus::kNotConverged,
           "mode " + std::to_string(k) + " has a relative residual of " + to_text(result_.relative_residual[k]));
    return std::move(result_);
  }
  if (options_.estimate_mesh_error) {
    monitor_.progress("eigenmodes", 0.9);
    monitor_.throw_if_stopped();
    const Stopwatch watch;
    result_.mesh_relative_error = detail::hierarchical_frequency_error(result_.model, assembled_, problem_);
    result_.wall_time_s["mesh_error"] = watch.seconds();
  }
  monitor_.progress("eigenmodes", 1);
  finish(EigenStatus::kConverged, "");
  return std::move(result_);
}

bool ModeSearch::count_in_band() {
  std::string message;
  search_.proof.omega_sq = omega_sq(options_.band.high_hz);
  factored_ = problem_.factor_and_count(search_.proof.omega_sq, message);
  search_.proof.sturm_count = problem_.n_below(search_.proof.omega_sq);
  monitor_.throw_if_stopped();
  if (!search_.proof.sturm_count) {
    finish(EigenStatus::kFailed, "the number of modes in the band could not be counted");
    return false;
  }
  result_.sturm_count = search_.proof.sturm_count;
  n_wanted_ = *search_.proof.sturm_count - problem_.n_rigid();
  if (options_.most > 0 && n_wanted_ > options_.most) {
    n_in_band_ = n_wanted_;
    n_wanted_ = options_.count = options_.most;
    search_.proof = {};
  }
  if (n_wanted_ > 0) {
    check_memory();
    return true;
  }
  result_.none_missing = n_wanted_ == 0;
  result_.relative_residual.resize(0);
  if (options_.estimate_mesh_error) result_.mesh_relative_error.emplace();
  finish(EigenStatus::kConverged, "no elastic mode in the band");
  return false;
}

void ModeSearch::check_memory() const {
  // Vectors, the search's basis (twice as many) and the model's shapes.
  const double n_bytes = 4.0 * 8.0 * static_cast<double>(n_wanted_) * static_cast<double>(problem_.n_dofs());
  const double limit = std::min(16e9, 0.8 * static_cast<double>(physical_memory_bytes()));
  if (n_bytes <= limit) return;
  throw InputError(
      "eigenmodes",
      std::to_string(n_wanted_) + " modes of " + std::to_string(problem_.n_dofs()) +
          " displacements need too much memory",
      to_text(std::round(n_bytes / 1e8) / 10.0) + " GB",
      "up to " + to_text(std::round(limit / 1e8) / 10.0) + " GB: a narrower band, fewer modes or a coarser mesh");
}

void ModeSearch::search_upwards(bool dense) {
  const double low = omega_sq(options_.band.low_hz);
  for (int round = 0; round < 8; ++round) {
    find_lowest(problem_, options_, dense, n_wanted_, search_);
    monitor_.progress("eigenmodes", 0.8);
    monitor_.throw_if_stopped();
    if (options_.prove_none_missing || options_.count == 0) prove();
    const detail::Pairs& pairs = search_.pairs;
    n_low_ = (pairs.value.array() < low).count();
    if (options_.count == 0 || pairs.size() - n_low_ >= options_.count || !pairs.converged) break;
    n_wanted_ = std::min(options_.count + n_low_, problem_.n_elastic());
    if (pairs.size() >= problem_.n_elastic()) break;
  }
}

void ModeSearch::prove() {
  detail::Pairs& pairs = search_.pairs;
  double at = options_.count == 0 ? omega_sq(options_.band.high_hz) : detail::gap_above(pairs, n_wanted_);
  // The gap before the last polish serves as well, while it lies between the same pairs.
  if (at > 0 && search_.count_at > 0 &&
      (pairs.value.array() < at).count() == (pairs.value.array() < search_.count_at).count())
    at = search_.count_at;
  if (at == 0) at = pairs.size() > 0 ? pairs.value[pairs.size() - 1] * (1 + 1e-7) : omega_sq(options_.band.low_hz);
  if (pairs.converged)
    search_.proof = detail::prove(problem_, pairs, at, options_.tolerance, options_.max_restarts, kMaxSearches);
}

Eigen::Index ModeSearch::keep_modes(Eigen::VectorXd& round_off) {
  const detail::Pairs& pairs = search_.pairs;
  const Eigen::Index last = options_.count == 0 ? (pairs.value.array() <= omega_sq(options_.band.high_hz)).count()
                                                : std::min<Eigen::Index>(pairs.size(), n_low_ + options_.count);
  const Eigen::Index n_modes = std::max<Eigen::Index>(0, last - n_low_);
  detail::Pairs kept;
  kept.value = pairs.value.segment(n_low_, n_modes);
  kept.vector = pairs.vector.middleCols(n_low_, n_modes);
  problem_.residuals(kept, result_.relative_residual, round_off);

  ModalModel& model = result_.model;
  model.angular_frequency_rad_s = kept.value.cwiseMax(0.0).cwiseSqrt();
  model.shapes.setZero(3 * mesh_.n_nodes(), n_modes);
  for (std::size_t i = 0; i < assembled_.free_nodes.size(); ++i) {
    model.shapes.middleRows<3>(3 * assembled_.free_nodes[i]) =
        kept.vector.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  detail::orient_clusters(mesh_, kept.value, model.shapes);
  for (Eigen::Index k = 0; k < n_modes; ++k)
    if (detail::turns_over(model.shapes.col(k))) model.shapes.col(k) *= -1;
  result_.sturm_count = search_.proof.sturm_count;
  result_.none_missing = search_.proof.none_missing;
  result_.n_below_band = static_cast<int>(n_low_);
  if (n_in_band_ > 0) result_.n_left_out = static_cast<int>(n_in_band_ - n_low_ - n_modes);
  return n_modes;
}

void ModeSearch::finish(EigenStatus status, std::string message) {
  result_.status = status;
  result_.message = std::move(message);
  result_.n_operations = problem_.n_operations();
  result_.wall_time_s["factor"] = problem_.seconds_factor;
  result_.wall_time_s["iterate"] = search_.iterate_s;
  result_.wall_time_s["sturm"] = problem_.seconds_sturm;
  result_.wall_time_s["total"] = total_.seconds();
}

}  // namespace

void EigenOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (count == 0 && !(band.high_hz > band.low_hz && band.high_hz < 1e12))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e12)));
  throw_violations("eigenmodes", std::move(violations));
}

EigenResult solve_modes(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled,
                        const solid::Material& material, const solid::Support& support, const EigenOptions& options,
                        Monitor& monitor) {
  options.validate();
  solid::validate(material);
  if (assembled.n_mesh_nodes != mesh.n_nodes()) {
    throw InputError("eigenmodes", "the matrices belong to another mesh",
                     std::to_string(assembled.n_mesh_nodes) + " nodes", std::to_string(mesh.n_nodes()));
  }
  // BLAS keeps what its caller set (one thread inside parallel jobs), and never more than the process may use.
  monitor.progress("eigenmodes", 0);
  return ModeSearch(mesh, assembled, material, support, options, monitor).run();
}

Eigen::MatrixXd eigenvalue_lame_derivatives(const ModalModel& model, const solid::AssembledSolid& assembled) {
  Eigen::MatrixXd u(assembled.n_dofs(), model.n_modes());
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    u.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = model.shapes.middleRows<3>(3 * assembled.free_nodes[i]);
  }
  Eigen::MatrixXd result(model.n_modes(), 2);
  result.col(0) = u.cwiseProduct(la::symmetric_times(assembled.stiffness_lambda, u)).colwise().sum().transpose();
  result.col(1) = u.cwiseProduct(la::symmetric_times(assembled.stiffness_mu, u)).colwise().sum().transpose();
  return result;
}

std::size_t peak_memory_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != "VmHWM:") continue;
    std::size_t kilobytes = 0;
    status >> kilobytes;
    return kilobytes * 1024;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

}  // namespace klang::modal
