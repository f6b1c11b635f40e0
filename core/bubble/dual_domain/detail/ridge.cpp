#include "core/bubble/dual_domain/detail/ridge.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/base/check.hpp"
#include "core/base/parallel.hpp"
#include "core/base/random.hpp"
#include "core/bubble/dual_domain/detail/lapack.hpp"

namespace klang::bubble::detail {
namespace {

constexpr int kBucketsPerColumn = 4;
constexpr int kCopies = 2;            // buckets that each row goes to
constexpr double kTolerance = 1e-6;   // of the preconditioned residual
constexpr int kMaxSteps = 300;
constexpr int kTile = 128;            // of the Gram matrix
constexpr int kRowBlock = 32;         // rows that stay in the cache between A p and A^H (A p)
constexpr std::size_t kRowsPerRange = 384;

/// Columns of the sketch: n x n_buckets.
template <class Scalar>
Matrix<Scalar> sketch(const Matrix<Scalar>& adjoint, Eigen::Index n_buckets) {
  struct Entry {
    int row;
    double sign;
  };
  std::vector<std::vector<Entry>> buckets(static_cast<std::size_t>(n_buckets));
  RandomStream random(0x5eed, 17);  // fixed: the same problem gives the same bits
  const double share = 1.0 / std::sqrt(static_cast<double>(kCopies));
  for (Eigen::Index i = 0; i < adjoint.cols(); ++i) {
    std::uint32_t before = ~0U;
    for (int copy = 0; copy < kCopies; ++copy) {
      std::uint32_t at = random.below(static_cast<std::uint32_t>(n_buckets));
      while (at == before) at = random.below(static_cast<std::uint32_t>(n_buckets));
      before = at;
      buckets[at].push_back({static_cast<int>(i), (random.next_u32() & 1U) != 0 ? share : -share});
    }
  }
  Matrix<Scalar> sums(adjoint.rows(), n_buckets);
  parallel_for(buckets.size(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      auto column = sums.col(static_cast<Eigen::Index>(k));
      column.setZero();
      for (const Entry& entry : buckets[k]) column += entry.sign * adjoint.col(entry.row);
    }
  });
  return sums;
}

/// Lower triangle of m m^H, tile by tile: each tile is one product on one thread, so the bits do not depend on threads.
template <class Scalar>
Matrix<Scalar> gram(const Matrix<Scalar>& m) {
  const int n = static_cast<int>(m.rows()), k = static_cast<int>(m.cols());
  Matrix<Scalar> g(n, n);
  std::vector<std::pair<int, int>> tiles;
  for (int i = 0; i < n; i += kTile)
    for (int j = 0; j <= i; j += kTile) tiles.emplace_back(i, j);
  const BlasThreads one(1);
  parallel_for(tiles.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto [i, j] = tiles[t];
      gemm('N', 'C', std::min(kTile, n - i), std::min(kTile, n - j), k, Scalar(1.0), m.data() + i, n, m.data() + j, n, Scalar(0.0),
           g.data() + static_cast<Eigen::Index>(j) * n + i, n);
    }
  });
  return g;
}

/// (A^H A) x without forming it: blocks of rows are used twice while they are in the cache. Sums a range at a time.
template <class Scalar>
Matrix<Scalar> normal_times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& x) {
  const auto n_rows = static_cast<std::size_t>(adjoint.cols());
  const int n = static_cast<int>(adjoint.rows()), columns = static_cast<int>(x.cols());
  const std::size_t n_ranges = (n_rows + kRowsPerRange - 1) / kRowsPerRange;
  std::vector<Matrix<Scalar>> parts(n_ranges);
  const BlasThreads one(1);
  parallel_for(n_rows, kRowsPerRange, [&](std::size_t begin, std::size_t end) {
    Matrix<Scalar>& sum = parts[begin / kRowsPerRange];
    sum.setZero(n, columns);
    Matrix<Scalar> y(kRowBlock, columns);
    for (std::size_t i = begin; i < end; i += kRowBlock) {
      const int rows = static_cast<int>(std::min<std::size_t>(kRowBlock, end - i));
      const Scalar* const block = adjoint.data() + i * static_cast<std::size_t>(n);
      gemm('C', 'N', rows, columns, n, Scalar(1.0), block, n, x.data(), n, Scalar(0.0), y.data(), kRowBlock);
      gemm('N', 'N', n, columns, rows, Scalar(1.0), block, n, y.data(), kRowBlock, Scalar(1.0), sum.data(), n);
    }
  });
  for (std::size_t r = 1; r < n_ranges; ++r) parts[0] += parts[r];
  return parts[0];
}

/// A^H b.
template <class Scalar>
Matrix<Scalar> adjoint_times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& b) {
  const auto n_rows = static_cast<std::size_t>(adjoint.cols());
  const int n = static_cast<int>(adjoint.rows()), columns = static_cast<int>(b.cols());
  const std::size_t n_ranges = (n_rows + kRowsPerRange - 1) / kRowsPerRange;
  std::vector<Matrix<Scalar>> parts(n_ranges);
  const BlasThreads one(1);
  parallel_for(n_rows, kRowsPerRange, [&](std::size_t begin, std::size_t end) {
    Matrix<Scalar>& sum = parts[begin / kRowsPerRange];
    sum.resize(n, columns);
    gemm('N', 'N', n, columns, static_cast<int>(end - begin), Scalar(1.0), adjoint.data() + begin * static_cast<std::size_t>(n), n,
         b.data() + begin, static_cast<int>(n_rows), Scalar(0.0), sum.data(), n);
  });
  for (std::size_t r = 1; r < n_ranges; ++r) parts[0] += parts[r];
  return parts[0];
}

template <class Scalar>
RidgeSolution<Scalar> solve_direct(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& b, double eps) {
  const int n = static_cast<int>(adjoint.rows()), n_rows = static_cast<int>(adjoint.cols()), columns = static_cast<int>(b.cols());
  Matrix<Scalar> system = Matrix<Scalar>::Zero(n_rows + n, n), data = Matrix<Scalar>::Zero(n_rows + n, columns);
  system.topRows(n_rows) = adjoint.adjoint();
  system.bottomRows(n).diagonal().setConstant(Scalar(eps));
  data.topRows(n_rows) = b;
  Scalar wanted = 0.0;
  RidgeSolution<Scalar> result;
  if (gels(n_rows + n, n, columns, system.data(), data.data(), &wanted, -1) != 0) return result;
  std::vector<Scalar> work(static_cast<std::size_t>(std::real(wanted)) + 1);
  const int info = gels(n_rows + n, n, columns, system.data(), data.data(), work.data(), static_cast<int>(work.size()));
  result.x = data.topRows(n);
  result.solved = info == 0 && result.x.allFinite();
  if (!result.solved) result.message = "the least-squares problem is singular";
  return result;
}

/// Lower Cholesky factor of sketch^H sketch + eps^2 I; the ridge grows where rounding took the last positive digit.
template <class Scalar>
std::optional<Matrix<Scalar>> preconditioner(const Matrix<Scalar>& adjoint, double eps) {
  const Eigen::Index n = adjoint.rows(), n_buckets = kBucketsPerColumn * n;
  const Matrix<Scalar> g = n_buckets < adjoint.cols() ? gram(sketch(adjoint, n_buckets)) : gram(adjoint);
  double trace = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) trace += std::real(g(i, i));
  const BlasThreads one(1);
  for (double shift = eps * eps; shift < 1e-6 * trace; shift = std::max(10.0 * shift, 1e-16 * trace)) {
    Matrix<Scalar> factor = g;
    factor.diagonal().array() += Scalar(shift);
    if (potrf(static_cast<int>(n), factor.data()) == 0 && factor.diagonal().allFinite()) return factor;
  }
  return std::nullopt;
}

template <class Scalar>
RidgeSolution<Scalar> solve_sketched(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& b, double eps) {
  RidgeSolution<Scalar> result;
  const std::optional<Matrix<Scalar>> factor = preconditioner(adjoint, eps);
  if (!factor) {
    result.message = "the source functions depend on each other beyond the ridge";
    return result;
  }
  const int n = static_cast<int>(adjoint.rows()), columns = static_cast<int>(b.cols());
  const BlasThreads one(1);
  // Conjugate gradients for every column of b, side by side, on L^-1 (A^H A + eps^2) L^-H u = L^-1 A^H b.
  Matrix<Scalar> r = adjoint_times(adjoint, b);
  solve_lower('N', n, columns, factor->data(), r.data());
  Matrix<Scalar> p = r, u = Matrix<Scalar>::Zero(n, columns);
  Eigen::VectorXd size = r.colwise().squaredNorm().transpose();
  const Eigen::VectorXd first = size;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (((size.array() <= kTolerance * kTolerance * first.array())).all()) {
      result.solved = true;
      break;
    }
    Matrix<Scalar> v = p;
    solve_lower('C', n, columns, factor->data(), v.data());
    Matrix<Scalar> w = normal_times(adjoint, v);
    w += Scalar(eps * eps) * v;
    solve_lower('N', n, columns, factor->data(), w.data());
    for (int c = 0; c < columns; ++c) {
      const double curvature = std::real(p.col(c).dot(w.col(c)));
      if (!(curvature > 0.0)) {
        if (size[c] == 0.0) continue;
        result.message = "the least-squares solver broke down";
        return result;
      }
      const double along = size[c] / curvature;
      u.col(c) += along * p.col(c);
      r.col(c) -= along * w.col(c);
      const double now = r.col(c).squaredNorm();
      p.col(c) = r.col(c) + now / size[c] * p.col(c);
      size[c] = now;
    }
    ++result.n_iterations;
  }
  solve_lower('C', n, columns, factor->data(), u.data());
  result.x = std::move(u);
  result.solved = result.solved && result.x.allFinite();
  if (!result.solved) result.message = "the least-squares solver did not converge";
  return result;
}

}  // namespace

template <class Scalar>
RidgeSolution<Scalar> solve_ridge(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& b, double eps, RidgeMethod method) {
  KLANG_CHECK(b.rows() == adjoint.cols() && eps >= 0.0, "a ridge system has one row of data a row");
  return method == RidgeMethod::kDirect ? solve_direct(adjoint, b, eps) : solve_sketched(adjoint, b, eps);
}

template <class Scalar>
Matrix<Scalar> times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& x) {
  const int n = static_cast<int>(adjoint.rows()), columns = static_cast<int>(x.cols()), n_rows = static_cast<int>(adjoint.cols());
  Matrix<Scalar> y(n_rows, columns);
  const BlasThreads one(1);
  parallel_for(static_cast<std::size_t>(n_rows), kRowsPerRange, [&](std::size_t begin, std::size_t end) {
    gemm('C', 'N', static_cast<int>(end - begin), columns, n, Scalar(1.0), adjoint.data() + begin * static_cast<std::size_t>(n), n,
         x.data(), n, Scalar(0.0), y.data() + begin, n_rows);
  });
  return y;
}

template RidgeSolution<double> solve_ridge(const Matrix<double>&, const Matrix<double>&, double, RidgeMethod);
template RidgeSolution<std::complex<double>> solve_ridge(const Matrix<std::complex<double>>&, const Matrix<std::complex<double>>&,
                                                         double, RidgeMethod);
template Matrix<double> times(const Matrix<double>&, const Matrix<double>&);
template Matrix<std::complex<double>> times(const Matrix<std::complex<double>>&, const Matrix<std::complex<double>>&);

}  // namespace klang::bubble::detail
