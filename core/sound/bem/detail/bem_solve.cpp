#include "core/sound/bem/detail/bem_solve.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

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

void take(BemSolution& solution, const la::DenseSolution& dense) {
  solution.solved = dense.solved;
  solution.relative_residual =
      std::max(solution.relative_residual.value_or(0.0), dense.relative_residual.value_or(HUGE_VAL));
  solution.n_refinements = std::max(solution.n_refinements, dense.n_refinements);
  solution.double_factor |= dense.double_factor;
  solution.wall_time_s["factor"] += dense.factor_s;
  solution.wall_time_s["refine"] += dense.refine_s;
}

void solve_assembled(DeviceSystem& on_device, const Eigen::MatrixXcd& right, const BemSystem& system,
                     BemSolution& solution) {
  const Stopwatch lap;
  const double tolerance =
      on_device.double_precision() ? system.options.tolerance : std::max(system.options.tolerance, kSingleTolerance);
  const BlockInverse inverse(on_device, static_cast<int>(system.geometry.row_of_vertex.size()));
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
  la::DenseSolution dense = la::dense_solve(matrix, right, tolerance, system.options.max_refinements);
  solution.relative_residual.reset();
  take(solution, dense);
  solution.x = std::move(dense.x);
}

/// One class after the other, all its columns at once.
void solve_classes(la::RowMatrixXcd matrix, const Eigen::MatrixXcd& right, const BemSystem& system,
                   const std::vector<MirrorClasses::Part>& parts, BemSolution& solution) {
  const BemGeometry& geometry = system.geometry;
  solution.x = Eigen::MatrixXcd::Zero(geometry.surface.n_vertices(), system.n_columns);
  solution.solved = true;
  solution.relative_residual = 0.0;
  for (std::size_t first = 0, end = 0; first < parts.size() && solution.solved; first = end) {
    const int number = parts[first].number;
    while (end < parts.size() && parts[end].number == number) ++end;
    const std::vector<int> vertices = geometry.classes.vertices_of(number, geometry.row_of_vertex);
    const auto n = static_cast<Eigen::Index>(vertices.size());
    Eigen::MatrixXcd b(n, static_cast<Eigen::Index>(end - first));
    for (Eigen::Index i = 0; i < n; ++i)
      b.row(i) = right.row(geometry.row_of_vertex[vertices[static_cast<std::size_t>(i)]])
                     .segment(static_cast<Eigen::Index>(first), b.cols());
    la::RowMatrixXcd a = n == matrix.cols() ? std::move(matrix)
                                            : geometry.classes.folded(number, vertices, matrix, geometry.row_of_vertex,
                                                                      geometry.column_of_vertex);
    const la::DenseSolution dense = la::dense_solve(a, b, system.options.tolerance, system.options.max_refinements);
    take(solution, dense);
    for (std::size_t i = first; i < end; ++i)
      geometry.classes.spread(number, vertices, dense.x.col(static_cast<Eigen::Index>(i - first)),
                              solution.x.col(parts[i].column));
  }
}

}  // namespace

BemSolution solve_on_processor(const BemSystem& system, const std::vector<MirrorClasses::Part>& parts) {
  const Stopwatch lap;
  const BemOptions& options = system.options;
  const std::size_t n = system.geometry.triangles_of_row.size();
  la::RowMatrixXcd matrix = la::RowMatrixXcd::Zero(static_cast<Eigen::Index>(n), system.geometry.surface.n_vertices());
  Eigen::MatrixXcd right =
      Eigen::MatrixXcd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(parts.size()));
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
  solve_classes(std::move(matrix), right, system, parts, solution);
  return solution;
}

BemSolution solve_on_device(const BemSystem& system) {
  static std::mutex turn;
  BemSolution solution;
  Stopwatch lap;
  Eigen::MatrixXcd right = Eigen::MatrixXcd::Zero(system.geometry.surface.n_vertices(), system.n_columns);
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
    const Eigen::MatrixXcd by_rows = std::move(solution.x);
    solution.x.resize(by_rows.rows(), by_rows.cols());
    for (Eigen::Index v = 0; v < by_rows.rows(); ++v)
      solution.x.row(v) = by_rows.row(system.geometry.row_of_vertex[static_cast<std::size_t>(v)]);
    solution.done = true;
  } catch (const opencl::Error& error) {
    solution.message = std::string(error.what()) + "; the processor does it";
  }
  return solution;
}

}  // namespace klang::acoustics::detail
