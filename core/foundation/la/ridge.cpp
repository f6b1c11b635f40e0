#include "core/foundation/la/ridge.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/memory.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/la/detail/row_kernel.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la {
namespace {

constexpr int kBucketsPerColumn = 4;
constexpr int kCopies = 2;           // buckets that each row goes to
constexpr double kTolerance = 1e-3;  // error of A x over the residual that stays
constexpr double kFloor = 1e-7;      // the same over the data: what rounding leaves
constexpr int kMaxSteps = 300;
constexpr int kTile = 192;  // of the Gram matrix
constexpr std::size_t kRowsPerRange = 384;

/// Which rows go into each bucket of the sketch, and with which sign.
struct Embedding {
  struct Entry {
    int row;
    double sign;
  };
  std::vector<std::vector<Entry>> buckets;
};

Embedding embedding(Eigen::Index n_rows, Eigen::Index n_buckets) {
  Embedding result;
  result.buckets.resize(static_cast<std::size_t>(n_buckets));
  RandomStream random(0x5eed, 17);  // fixed: the same problem gives the same bits
  const double share = 1.0 / std::sqrt(static_cast<double>(kCopies));
  for (Eigen::Index i = 0; i < n_rows; ++i) {
    std::uint32_t before = ~0U;
    for (int copy = 0; copy < kCopies; ++copy) {
      std::uint32_t at = random.below(static_cast<std::uint32_t>(n_buckets));
      while (at == before) at = random.below(static_cast<std::uint32_t>(n_buckets));
      before = at;
      result.buckets[at].push_back({static_cast<int>(i), (random.next_u32() & 1U) != 0 ? share : -share});
    }
  }
  return result;
}

/// Columns of the sketch, scaled: n x n_buckets.
template <class Scalar>
Matrix<Scalar> sketch(const Embedding& embedding, const Matrix<Scalar>& adjoint, const Eigen::VectorXd& scale) {
  Matrix<Scalar> sums(adjoint.rows(), static_cast<Eigen::Index>(embedding.buckets.size()));
  prefer_huge_pages(sums.data(), static_cast<std::size_t>(sums.size()) * sizeof(Scalar));
  parallel_for(embedding.buckets.size(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      auto column = sums.col(static_cast<Eigen::Index>(k));
      column.setZero();
      for (const Embedding::Entry& entry : embedding.buckets[k]) column += entry.sign * adjoint.col(entry.row);
      column.array() *= scale.array().template cast<Scalar>();
    }
  });
  return sums;
}

/// The same of the data: n_buckets x n_columns.
template <class Scalar>
Matrix<Scalar> sketch_data(const Embedding& embedding, const Matrix<Scalar>& b) {
  Matrix<Scalar> sums = Matrix<Scalar>::Zero(static_cast<Eigen::Index>(embedding.buckets.size()), b.cols());
  for (std::size_t k = 0; k < embedding.buckets.size(); ++k)
    for (const Embedding::Entry& entry : embedding.buckets[k])
      sums.row(static_cast<Eigen::Index>(k)) += entry.sign * b.row(entry.row);
  return sums;
}

/// Lower triangle of m m^H, tile by tile: each tile is one product on one thread, so the bits do not depend on threads.
template <class Scalar>
Matrix<Scalar> gram(const Matrix<Scalar>& m) {
  const int n = static_cast<int>(m.rows()), k = static_cast<int>(m.cols());
  Matrix<Scalar> g(n, n);
  prefer_huge_pages(g.data(), static_cast<std::size_t>(g.size()) * sizeof(Scalar));
  std::vector<std::pair<int, int>> tiles;
  for (int i = 0; i < n; i += kTile)
    for (int j = 0; j <= i; j += kTile) tiles.emplace_back(i, j);
  const BlasThreads one(1);
  parallel_for(tiles.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto [i, j] = tiles[t];
      la::gemm('N', 'C', std::min(kTile, n - i), std::min(kTile, n - j), k, Scalar(1.0), m.data() + i, n, m.data() + j,
               n, Scalar(0.0), g.data() + static_cast<Eigen::Index>(j) * n + i, n);
    }
  });
  return g;
}

/// The kernel works on pairs of real vectors: two columns of real data, or one complex column.
template <class Scalar>
std::size_t n_pairs(const Matrix<Scalar>& columns) {
  return static_cast<std::size_t>(std::is_same_v<Scalar, double> ? (columns.cols() + 1) / 2 : columns.cols());
}
template <class Scalar>
std::size_t real_length(const Matrix<Scalar>& adjoint) {
  return static_cast<std::size_t>(adjoint.rows()) * (sizeof(Scalar) / sizeof(double));
}
template <class Scalar>
const double* as_real(const Matrix<Scalar>& m) {
  return reinterpret_cast<const double*>(m.data());
}

/// m is conj(row): row x = sum conj(m) x = (m . x) + i (m . (-i x)) with real dot products.
std::vector<double> to_pairs(const Matrix<std::complex<double>>& x) {
  std::vector<double> pairs;
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    for (Eigen::Index j = 0; j < x.rows(); ++j) pairs.insert(pairs.end(), {x(j, c).real(), x(j, c).imag()});
    for (Eigen::Index j = 0; j < x.rows(); ++j) pairs.insert(pairs.end(), {x(j, c).imag(), -x(j, c).real()});
  }
  return pairs;
}
std::vector<double> to_pairs(const Matrix<double>& x) {
  std::vector<double> pairs(x.data(), x.data() + x.size());
  if (x.cols() % 2 != 0) pairs.resize(pairs.size() + static_cast<std::size_t>(x.rows()), 0.0);
  return pairs;
}

/// The sum over rows of m y with y = (Re, Im): both real sums of a pair make one complex column.
void from_pairs(const std::vector<double>& w, Matrix<std::complex<double>>& out) {
  const std::size_t n = static_cast<std::size_t>(out.rows());
  for (Eigen::Index c = 0; c < out.cols(); ++c) {
    const double* const real = w.data() + static_cast<std::size_t>(c) * 4 * n;
    const double* const imag = real + 2 * n;
    for (std::size_t j = 0; j < n; ++j)
      out(static_cast<Eigen::Index>(j), c) = {real[2 * j] - imag[2 * j + 1], real[2 * j + 1] + imag[2 * j]};
  }
}
void from_pairs(const std::vector<double>& w, Matrix<double>& out) { std::copy_n(w.data(), out.size(), out.data()); }

/// Sums of a kernel over ranges of rows, in order.
template <class Scalar, class Kernel>
Matrix<Scalar> sum_over_rows(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& like, const Kernel& kernel) {
  const auto n_rows = static_cast<std::size_t>(adjoint.cols());
  const std::size_t n = real_length(adjoint), pairs = n_pairs(like);
  std::vector<std::vector<double>> parts((n_rows + kRowsPerRange - 1) / kRowsPerRange);
  parallel_for(n_rows, kRowsPerRange, [&](std::size_t begin, std::size_t end) {
    std::vector<double>& w = parts[begin / kRowsPerRange];
    w.assign(2 * n * pairs, 0.0);
    kernel(as_real(adjoint) + begin * n, begin, end - begin, n, pairs, w.data());
  });
  for (std::size_t r = 1; r < parts.size(); ++r)
    for (std::size_t j = 0; j < parts[0].size(); ++j) parts[0][j] += parts[r][j];
  Matrix<Scalar> out(adjoint.rows(), like.cols());
  from_pairs(parts[0], out);
  return out;
}

/// (rows^H rows) x without forming it.
template <class Scalar>
Matrix<Scalar> normal_times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& x) {
  const std::vector<double> pairs = to_pairs(x);
  return sum_over_rows(
      adjoint, x, [&](const double* m, std::size_t, std::size_t n_rows, std::size_t n, std::size_t count, double* w) {
        detail::rows_normal(m, n_rows, n, pairs.data(), count, w);
      });
}

/// Data as the kernel reads it: a row's pairs one after the other.
std::vector<double> row_pairs(const Matrix<std::complex<double>>& b) {
  std::vector<double> rows;
  for (Eigen::Index i = 0; i < b.rows(); ++i)
    for (Eigen::Index c = 0; c < b.cols(); ++c) rows.insert(rows.end(), {b(i, c).real(), b(i, c).imag()});
  return rows;
}
std::vector<double> row_pairs(const Matrix<double>& b) {
  const std::size_t width = 2 * n_pairs(b);
  std::vector<double> rows(static_cast<std::size_t>(b.rows()) * width, 0.0);
  for (Eigen::Index i = 0; i < b.rows(); ++i)
    for (Eigen::Index c = 0; c < b.cols(); ++c)
      rows[static_cast<std::size_t>(i) * width + static_cast<std::size_t>(c)] = b(i, c);
  return rows;
}

/// rows^H b.
template <class Scalar>
Matrix<Scalar> adjoint_times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& b) {
  const std::vector<double> data = row_pairs(b);
  return sum_over_rows(adjoint, b,
                       [&](const double* m, std::size_t first, std::size_t n_rows, std::size_t n, std::size_t count,
                           double* w) { detail::rows_add(m, n_rows, n, data.data() + 2 * count * first, count, w); });
}

/// rows^H (b - rows x) in one reading; the residual itself has all its digits, unlike a difference of sums.
template <class Scalar>
Matrix<Scalar> residual_times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& x, const Matrix<Scalar>& b) {
  const std::vector<double> pairs = to_pairs(x), data = row_pairs(b);
  return sum_over_rows(
      adjoint, b,
      [&](const double* m, std::size_t first, std::size_t n_rows, std::size_t n, std::size_t count, double* w) {
        detail::rows_residual(m, n_rows, n, pairs.data(), data.data() + 2 * count * first, count, w);
      });
}

template <class Scalar>
RidgeSolution<Scalar> solve_direct(const Matrix<Scalar>& adjoint, const Eigen::VectorXd& scale, const Matrix<Scalar>& b,
                                   double eps) {
  const int n = static_cast<int>(adjoint.rows()), n_rows = static_cast<int>(adjoint.cols()),
            columns = static_cast<int>(b.cols());
  Matrix<Scalar> system = Matrix<Scalar>::Zero(n_rows + n, n), data = Matrix<Scalar>::Zero(n_rows + n, columns);
  system.topRows(n_rows) = adjoint.adjoint() * scale.asDiagonal();
  system.bottomRows(n).diagonal().setConstant(Scalar(eps));
  data.topRows(n_rows) = b;
  Scalar wanted = 0.0;
  RidgeSolution<Scalar> result;
  if (la::gels(n_rows + n, n, columns, system.data(), data.data(), &wanted, -1) != 0) return result;
  std::vector<Scalar> work(static_cast<std::size_t>(std::real(wanted)) + 1);
  const int info =
      la::gels(n_rows + n, n, columns, system.data(), data.data(), work.data(), static_cast<int>(work.size()));
  result.x = data.topRows(n);
  result.solved = info == 0 && result.x.allFinite();
  if (!result.solved) result.message = "the least-squares problem is singular";
  return result;
}

/// Lower Cholesky factor of g + eps^2 I; the ridge grows where rounding took the last positive digit.
template <class Scalar>
std::optional<Matrix<Scalar>> cholesky(const Matrix<Scalar>& g, double eps) {
  double trace = 0.0;
  for (Eigen::Index i = 0; i < g.rows(); ++i) trace += std::real(g(i, i));
  for (double more = 0.0; more < 1e-6 * trace; more = std::max(10.0 * more, 1e-16 * trace)) {
    Matrix<Scalar> factor = g;
    factor.diagonal().array() += Scalar(eps * eps + more);
    if (la::potrf(static_cast<int>(g.rows()), factor.data()) == 0 && factor.diagonal().allFinite()) return factor;
    if (!(trace > 0.0)) break;
  }
  return std::nullopt;
}

template <class Scalar>
RidgeSolution<Scalar> solve_sketched(const Matrix<Scalar>& adjoint, const Eigen::VectorXd& scale,
                                     const Matrix<Scalar>& b, double eps) {
  RidgeSolution<Scalar> result;
  const int n = static_cast<int>(adjoint.rows()), columns = static_cast<int>(b.cols());
  const bool small = kBucketsPerColumn * adjoint.rows() >= adjoint.cols();  // then the sketch is the problem itself
  const BlasThreads one(1);
  Matrix<Scalar> rows, data;
  if (small) {
    rows = scale.asDiagonal() * adjoint;
    data = b;
  } else {
    const Embedding where = embedding(adjoint.cols(), kBucketsPerColumn * adjoint.rows());
    rows = sketch(where, adjoint, scale);
    data = sketch_data(where, b);
  }
  const std::optional<Matrix<Scalar>> factor = cholesky(gram(rows), eps);
  if (!factor) {
    result.message = "the source functions depend on each other beyond the ridge";
    return result;
  }
  // Start: the solution of the sketched problem, whose residual is within a factor 2 of the smallest.
  Matrix<Scalar> x = adjoint_times(rows, data);
  la::solve_lower('N', n, columns, factor->data(), x.data());
  la::solve_lower('C', n, columns, factor->data(), x.data());
  const Matrix<Scalar> left = times(rows, x) - data;
  Eigen::VectorXd enough(columns);
  for (int c = 0; c < columns; ++c)
    enough[c] = std::max(kTolerance * kTolerance * (left.col(c).squaredNorm() + eps * eps * x.col(c).squaredNorm()),
                         kFloor * kFloor * data.col(c).squaredNorm());
  rows.resize(0, 0);
  const auto normal = [&](const Matrix<Scalar>& v) {
    Matrix<Scalar> w = scale.asDiagonal() * normal_times(adjoint, Matrix<Scalar>(scale.asDiagonal() * v));
    w += Scalar(eps * eps) * v;
    return w;
  };
  // Conjugate gradients for every column of b, side by side, on L^-1 (A^H A + eps^2) L^-H u = L^-1 residual.
  Matrix<Scalar> r = scale.asDiagonal() * residual_times(adjoint, Matrix<Scalar>(scale.asDiagonal() * x), b);
  r -= Scalar(eps * eps) * x;
  la::solve_lower('N', n, columns, factor->data(), r.data());
  Matrix<Scalar> p = r, u = Matrix<Scalar>::Zero(n, columns);
  Eigen::VectorXd size = r.colwise().squaredNorm().transpose();
  for (int step = 0; step < kMaxSteps; ++step) {
    if ((size.array() <= enough.array()).all()) {
      result.solved = true;
      break;
    }
    Matrix<Scalar> v = p;
    la::solve_lower('C', n, columns, factor->data(), v.data());
    Matrix<Scalar> w = normal(v);
    la::solve_lower('N', n, columns, factor->data(), w.data());
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
  la::solve_lower('C', n, columns, factor->data(), u.data());
  result.x = x + u;
  result.solved = result.solved && result.x.allFinite();
  if (!result.solved) result.message = "the least-squares solver did not converge";
  return result;
}

}  // namespace

template <class Scalar>
RidgeSolution<Scalar> solve_ridge(const Matrix<Scalar>& adjoint, const Eigen::VectorXd& scale, const Matrix<Scalar>& b,
                                  double eps, RidgeMethod method) {
  KLANG_CHECK(b.rows() == adjoint.cols() && scale.size() == adjoint.rows() && eps >= 0.0,
              "a ridge system has one row of data per row");
  KLANG_CHECK(adjoint.rows() % kMultiple<Scalar> == 0, "unknowns of a ridge system come padded");
  return method == RidgeMethod::kDirect ? solve_direct(adjoint, scale, b, eps) : solve_sketched(adjoint, scale, b, eps);
}

template <class Scalar>
Matrix<Scalar> times(const Matrix<Scalar>& adjoint, const Matrix<Scalar>& x) {
  const std::size_t n = real_length(adjoint), count = n_pairs(x);
  const std::vector<double> pairs = to_pairs(x);
  Matrix<Scalar> y(adjoint.cols(), x.cols());
  parallel_for(static_cast<std::size_t>(adjoint.cols()), kRowsPerRange, [&](std::size_t begin, std::size_t end) {
    std::vector<double> rows(2 * count * (end - begin));
    detail::rows_times(as_real(adjoint) + begin * n, end - begin, n, pairs.data(), count, rows.data());
    for (std::size_t i = 0; i < end - begin; ++i)
      for (Eigen::Index c = 0; c < x.cols(); ++c) {
        const double* const at = rows.data() + 2 * count * i;
        if constexpr (std::is_same_v<Scalar, double>) {
          y(static_cast<Eigen::Index>(begin + i), c) = at[c];
        } else {
          y(static_cast<Eigen::Index>(begin + i), c) = {at[2 * c], at[2 * c + 1]};
        }
      }
  });
  return y;
}

template RidgeSolution<double> solve_ridge(const Matrix<double>&, const Eigen::VectorXd&, const Matrix<double>&, double,
                                           RidgeMethod);
template RidgeSolution<std::complex<double>> solve_ridge(const Matrix<std::complex<double>>&, const Eigen::VectorXd&,
                                                         const Matrix<std::complex<double>>&, double, RidgeMethod);
template Matrix<double> times(const Matrix<double>&, const Matrix<double>&);
template Matrix<std::complex<double>> times(const Matrix<std::complex<double>>&, const Matrix<std::complex<double>>&);

}  // namespace klang::la
