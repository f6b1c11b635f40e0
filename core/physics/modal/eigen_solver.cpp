#include "core/physics/modal/eigen_solver.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/la/block_mass.hpp"
#include "core/physics/modal/detail/eigen_problem.hpp"
#include "core/physics/modal/detail/hierarchical_error.hpp"

namespace klang::modal {
namespace {

constexpr int kMaxSearches = 3;
constexpr int kMaxGuard = 64;
// From here on a pass through the factor costs more than what a block of vectors adds to it.
constexpr Eigen::Index kBlockFromNodes = 4000;
constexpr Eigen::Index kBlock = 8;

double omega_sq(double frequency_hz) { return std::pow(2 * kPi * frequency_hz, 2); }

struct Search {
  detail::Pairs pairs;
  detail::Proof proof;
  double count_at = 0;  // 0: not counted yet
  double iterate_s = 0;
};

// The lowest pairs: at least `n_wanted`, with guards above them so that a gap for the Sturm count is seen.
void find_lowest(detail::EigenProblem& problem, const EigenOptions& options, bool dense, Eigen::Index n_wanted,
                 Search& search) {
  for (Eigen::Index guard = 4; guard <= kMaxGuard; guard *= 4) {
    const Eigen::Index n = std::min(n_wanted + guard, problem.n_elastic());
    const Stopwatch watch;
    const bool too_many_for_lanczos = 4 * n + 8 * kBlock > problem.n_elastic();
    if (dense || too_many_for_lanczos) {
      search.pairs = problem.lowest_dense(n);
    } else {
      search.pairs = problem.n_dofs() >= 3 * kBlockFromNodes
                         ? problem.lowest_block(n, kBlock, options.tolerance, options.max_restarts)
                         : problem.lowest(n, options.tolerance, options.max_restarts, {}, 0);
    }
    if (search.pairs.converged) {
      // Where the count is made does not depend on the last digits, so that it need not wait for them.
      const double gap = detail::gap_above(search.pairs, n_wanted);
      if (!dense && options.count > 0 && options.prove_none_missing && gap > 0) {
        search.count_at = gap;
        problem.polish_and_count(search.pairs, gap);
      } else {
        problem.polish(search.pairs);
      }
    }
    search.iterate_s += watch.seconds();
    if (!search.pairs.converged || n == problem.n_elastic() || detail::gap_above(search.pairs, n_wanted) > 0) return;
  }
}

}  // namespace

void EigenOptions::validate() const {
  const char* place = "eigenmodes";
  if (count < 0) throw InputError(place, "count must not be negative", std::to_string(count), "0 or more");
  checked(place, "band.low_hz", band.low_hz, 0, 1e12);
  if (count == 0) {
    checked_open(place, "band.high_hz", band.high_hz, band.low_hz, 1e12);
  }
  checked(place, "tolerance", tolerance, 1e-14, 1e-3);
  if (max_restarts < 1)
    throw InputError(place, "max_restarts must be positive", std::to_string(max_restarts), "1 or more");
  if (dense_limit_nodes < 0) {
    throw InputError(place, "dense_limit_nodes must not be negative", std::to_string(dense_limit_nodes), "0 or more");
  }
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
  const Stopwatch total;
  // BLAS keeps what its caller set (one thread inside parallel jobs), and never more than the process may
  // use.
  EigenResult result;
  result.model.mesh = mesh;
  result.model.material = material;
  result.model.support = support;
  result.model.shapes.resize(3 * mesh.n_nodes(), 0);

  monitor.progress("eigenmodes", 0);
  detail::EigenProblem problem(mesh, assembled, material);
  result.n_rigid_modes = problem.n_rigid();
  const auto n_free = static_cast<int>(assembled.free_nodes.size());
  const bool dense = options.method == EigenMethod::kDense ||
                     (options.method == EigenMethod::kAuto && n_free < options.dense_limit_nodes);
  result.method_used = dense ? EigenMethod::kDense : EigenMethod::kShiftInvert;

  Search search;
  const auto finish = [&](EigenStatus status, std::string message) -> EigenResult& {
    result.status = status;
    result.message = std::move(message);
    result.n_operations = problem.n_operations();
    result.wall_time_s["factor"] = problem.seconds_factor;
    result.wall_time_s["iterate"] = search.iterate_s;
    result.wall_time_s["sturm"] = problem.seconds_sturm;
    result.wall_time_s["total"] = total.seconds();
    return result;
  };

  std::string message;
  bool factored = false;
  Eigen::Index n_wanted = options.count;
  if (options.count == 0) {
    // How many there are in the band is known before any is computed, and is the proof afterwards.
    search.proof.omega_sq = omega_sq(options.band.high_hz);
    factored = problem.factor_and_count(search.proof.omega_sq, message);
    search.proof.sturm_count = problem.n_below(search.proof.omega_sq);
    monitor.throw_if_stopped();
    if (!search.proof.sturm_count) {
      return finish(EigenStatus::kFailed, "the number of modes in the band could not be counted");
    }
    result.sturm_count = search.proof.sturm_count;
    n_wanted = *search.proof.sturm_count - problem.n_rigid();
    if (n_wanted <= 0) {
      result.none_missing = n_wanted == 0;
      result.relative_residual.resize(0);
      if (options.estimate_mesh_error) result.mesh_relative_error.emplace();
      return finish(EigenStatus::kConverged, "no elastic mode in the band");
    }
  }
  if (n_wanted > problem.n_elastic()) {
    throw InputError("eigenmodes", "more modes wanted than the mesh has", std::to_string(n_wanted),
                     "at most " + std::to_string(problem.n_elastic()));
  }
  if (!factored && !problem.factor(message)) return finish(EigenStatus::kFailed, message);
  monitor.progress("eigenmodes", 0.3);
  monitor.throw_if_stopped();

  const double low = omega_sq(options.band.low_hz);
  Eigen::Index n_low = 0;  // elastic modes below the band
  for (int round = 0; round < 8; ++round) {
    find_lowest(problem, options, dense, n_wanted, search);
    monitor.progress("eigenmodes", 0.8);
    monitor.throw_if_stopped();
    if (options.prove_none_missing || options.count == 0) {
      double at = options.count == 0 ? omega_sq(options.band.high_hz) : detail::gap_above(search.pairs, n_wanted);
      // The gap before the last polish serves as well, while it lies between the same pairs.
      if (at > 0 && search.count_at > 0 &&
          (search.pairs.value.array() < at).count() == (search.pairs.value.array() < search.count_at).count())
        at = search.count_at;
      if (at == 0) at = search.pairs.size() > 0 ? search.pairs.value[search.pairs.size() - 1] * (1 + 1e-7) : low;
      if (search.pairs.converged) {
        search.proof = detail::prove(problem, search.pairs, at, options.tolerance, options.max_restarts, kMaxSearches);
      }
    }
    n_low = (search.pairs.value.array() < low).count();
    if (options.count == 0 || search.pairs.size() - n_low >= options.count || !search.pairs.converged) break;
    n_wanted = std::min(options.count + n_low, problem.n_elastic());
    if (search.pairs.size() >= problem.n_elastic()) break;
  }

  detail::Pairs& pairs = search.pairs;
  const Eigen::Index last = options.count == 0 ? (pairs.value.array() <= omega_sq(options.band.high_hz)).count()
                                               : std::min<Eigen::Index>(pairs.size(), n_low + options.count);
  const Eigen::Index n_modes = std::max<Eigen::Index>(0, last - n_low);
  detail::Pairs kept;
  kept.value = pairs.value.segment(n_low, n_modes);
  kept.vector = pairs.vector.middleCols(n_low, n_modes);
  Eigen::VectorXd round_off;
  problem.residuals(kept, result.relative_residual, round_off);

  result.model.angular_frequency_rad_s = kept.value.cwiseMax(0.0).cwiseSqrt();
  result.model.shapes.setZero(3 * mesh.n_nodes(), n_modes);
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    result.model.shapes.middleRows<3>(3 * assembled.free_nodes[i]) =
        kept.vector.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  }
  // A vector's sign is free: the largest component is made positive, so that runs can be compared.
  for (Eigen::Index k = 0; k < n_modes; ++k) {
    Eigen::Index largest = 0;
    result.model.shapes.col(k).cwiseAbs().maxCoeff(&largest);
    if (result.model.shapes(largest, k) < 0) result.model.shapes.col(k) *= -1;
  }
  result.sturm_count = search.proof.sturm_count;
  result.none_missing = search.proof.none_missing;

  if (!pairs.converged) return finish(EigenStatus::kNotConverged, pairs.message);
  for (Eigen::Index k = 0; k < n_modes; ++k) {
    if (!(result.relative_residual[k] <= std::max(options.tolerance, round_off[k]))) {
      return finish(EigenStatus::kNotConverged, "mode " + std::to_string(k) + " has a relative residual of " +
                                                    to_text(result.relative_residual[k]));
    }
  }
  if (options.estimate_mesh_error) {
    monitor.progress("eigenmodes", 0.9);
    monitor.throw_if_stopped();
    const Stopwatch watch;
    result.mesh_relative_error = detail::hierarchical_frequency_error(result.model, assembled, problem);
    result.wall_time_s["mesh_error"] = watch.seconds();
  }
  monitor.progress("eigenmodes", 1);
  return finish(EigenStatus::kConverged, "");
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
