#include "core/sound/bem/detail/bem_solve.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <mutex>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/la/gmres.hpp"

namespace klang::acoustics::detail {
namespace {

constexpr int kBlockRows = 192;            // of the preconditioner
constexpr int kMostSteps = 250;            // of GMRES between two starts
constexpr double kSingleTolerance = 3e-6;  // what products in single precision allow

/// Inverse of the matrix's diagonal blocks. Rows follow a space-filling curve: a block is a patch of the surface.
class BlockInverse {
 public:
  BlockInverse(DeviceSystem& system, int n_rows) {
    const int n_blocks = (n_rows + kBlockRows - 1) / kBlockRows;
    for (int b = 0; b < n_blocks; ++b) first_.push_back(static_cast<int>(static_cast<long>(n_rows) * b / n_blocks));
    first_.push_back(n_rows);
    std::vector<Eigen::MatrixXcd> blocks;
    for (int b = 0; b < n_blocks; ++b) blocks.push_back(system.block(first_[b], first_[b + 1] - first_[b]));
    factors_.resize(blocks.size());
    parallel_for(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) factors_[b].compute(blocks[b]);
    });
  }
  Eigen::MatrixXcd operator()(const Eigen::MatrixXcd& x) const {
    Eigen::MatrixXcd y(x.rows(), x.cols());
    parallel_for(factors_.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b)
        y.middleRows(first_[b], first_[b + 1] - first_[b]) =
            factors_[b].solve(x.middleRows(first_[b], first_[b + 1] - first_[b]));
    });
    return y;
  }

 private:
  std::vector<int> first_;
  std::vector<Eigen::PartialPivLU<Eigen::MatrixXcd>> factors_;
};

void take(BemSolution& solution, la::DenseSolution dense) {
  solution.x = std::move(dense.x);
  solution.solved = dense.solved;
  solution.relative_residual = dense.relative_residual;
  solution.n_refinements = dense.n_refinements;
  solution.double_factor = dense.double_factor;
  solution.wall_time_s["factor"] = dense.factor_s;
  solution.wall_time_s["refine"] = dense.refine_s;
}

void solve_assembled(DeviceSystem& on_device, const Eigen::MatrixXcd& right, const BemSystem& system,
                     BemSolution& solution) {
  const Stopwatch lap;
  const double tolerance =
      on_device.double_precision() ? system.options.tolerance : std::max(system.options.tolerance, kSingleTolerance);
  const BlockInverse inverse(on_device, system.n_rows);
  la::KrylovSolution found =
      la::gmres([&](const Eigen::MatrixXcd& x) { return on_device.times(x); }, std::cref(inverse), right, tolerance,
                kMostSteps, [&] { return system.monitor.stop_requested(); });
  system.monitor.throw_if_stopped();
  solution.n_products = found.n_products;
  solution.solved = found.solved;
  solution.relative_residual = found.relative_residual;
  solution.x = std::move(found.x);
  solution.wall_time_s["solve"] = lap.seconds();
  if (found.solved) return;
  la::RowMatrixXcd matrix = on_device.matrix();
  take(solution, la::dense_solve(matrix, right, tolerance, system.options.max_refinements));
}

}  // namespace

BemSolution solve_on_processor(const BemSystem& system) {
  const Stopwatch lap;
  const BemOptions& options = system.options;
  const auto n = static_cast<std::size_t>(system.n_rows);
  la::RowMatrixXcd matrix = la::RowMatrixXcd::Zero(system.n_rows, system.n_rows);
  Eigen::MatrixXcd right = Eigen::MatrixXcd::Zero(system.n_rows, system.n_columns);
  const std::size_t grain =
      options.alone ? std::clamp<std::size_t>(n / (6 * static_cast<std::size_t>(thread_count())), 24, 400) : 4000;
  std::atomic<std::size_t> done = 0;
  parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    if (system.monitor.stop_requested()) return;
    system.assembly.rows(begin, end, matrix, right);
    done += end - begin;
    system.monitor.progress("boundary elements", 0.7 * static_cast<double>(done) / static_cast<double>(n));
  });
  system.monitor.throw_if_stopped();
  BemSolution solution;
  solution.done = true;
  solution.wall_time_s["assemble"] = lap.seconds();
  const BlasThreads blas(options.n_blas_threads > 0 ? options.n_blas_threads : thread_count());
  take(solution, la::dense_solve(matrix, right, options.tolerance, options.max_refinements));
  return solution;
}

BemSolution solve_on_device(const BemSystem& system) {
  static std::mutex turn;
  BemSolution solution;
  Stopwatch lap;
  Eigen::MatrixXcd right = Eigen::MatrixXcd::Zero(system.n_rows, system.n_columns);
  const NearRows near = system.assembly.near_rows(right);
  solution.wall_time_s["near"] = lap.seconds();
  system.monitor.throw_if_stopped();
  system.monitor.progress("boundary elements", 0.3);
  const std::lock_guard lock(turn);  // one matrix at a time in the device's memory
  try {
    lap.restart();
    DeviceSystem on_device(system.options.device, system.assembly.far_problem(), near);
    right += on_device.far_right(system.assembly.at_points());
    solution.device = on_device.device().name;
    solution.wall_time_s["assemble"] = lap.seconds();
    system.monitor.throw_if_stopped();
    system.monitor.progress("boundary elements", 0.7);
    solve_assembled(on_device, right, system, solution);
    solution.done = true;
  } catch (const opencl::Error& error) {
    solution.message = std::string(error.what()) + "; the processor does it";
  }
  return solution;
}

}  // namespace klang::acoustics::detail
