#include "core/sound/bem/detail/device_system.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/foundation/base/check.hpp"
#include "far_kernels_cl.hpp"

namespace klang::acoustics::detail {
namespace {

using Complex = std::complex<double>;
constexpr int kFields = 22;
constexpr std::size_t kGpuPairBytes = std::size_t{1} << 31, kPairBytes = std::size_t{1} << 28;
constexpr int kColumns = 4;         // COLUMNS of the kernels
constexpr int kTestsAtOnce = 4096;  // of the right-hand side

template <typename Real>
using Numbers = Eigen::Matrix<std::complex<Real>, Eigen::Dynamic, Eigen::Dynamic>;

/// Rows of far_kernels.cl's geometry, points from the middle of the body: single precision keeps more of their differences.
template <typename Real>
std::vector<Real> geometry_of(const TriangleColumns& columns, std::size_t n) {
  std::vector<Real> fields;
  fields.reserve(kFields * n);
  std::array<double, 3> middle{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& x = columns.points_m[0][axis];
    const auto [low, high] = std::minmax_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n));
    middle[axis] = 0.5 * (*low + *high);
  }
  const auto add = [&](const std::vector<double>& values, double less) {
    for (std::size_t j = 0; j < n; ++j) fields.push_back(static_cast<Real>(values[j] - less));
  };
  for (const auto& point : columns.points_m)
    for (std::size_t axis = 0; axis < 3; ++axis) add(point[axis], middle[axis]);
  for (const auto& axis : columns.normals) add(axis, 0.0);
  for (const auto& corner : columns.curls)
    for (const auto& axis : corner) add(axis, 0.0);
  add(columns.weights_m2, 0.0);
  return fields;
}

/// Columns of the kernels: kColumns of them from first on, zeros where there are none left.
template <typename Real>
Numbers<Real> four_columns(const Eigen::MatrixXcd& x, Eigen::Index first) {
  Numbers<Real> result = Numbers<Real>::Zero(x.rows(), kColumns);
  const Eigen::Index count = std::min<Eigen::Index>(kColumns, x.cols() - first);
  result.leftCols(count) = x.middleCols(first, count).cast<std::complex<Real>>();
  return result;
}

}  // namespace

DeviceSystem::DeviceSystem(const opencl::DeviceChoice& where, FarProblem problem, const NearRows& near)
    : session_(kFarKernelsSource, where.device, where.precision),
      problem_(std::move(problem)),
      n_triangles_(static_cast<int>(problem_.corner_rows.cols())),
      n_rows_(static_cast<int>(problem_.triangles_of_row.size())),
      words_((n_triangles_ + 31) / 32),
      pair_bytes_(std::min<std::size_t>(session_.device().kind == "gpu" ? kGpuPairBytes : kPairBytes,
                                        session_.device().largest_buffer_bytes)) {
  const std::size_t number = double_precision() ? sizeof(Complex) : sizeof(std::complex<float>);
  const auto n = static_cast<std::size_t>(n_rows_), n_triangles = static_cast<std::size_t>(n_triangles_);
  const std::size_t matrix = n * n * number, pairs = std::min(pair_bytes_, 9 * n_triangles * n_triangles * number);
  const std::size_t small = n_triangles * (kFields + 30) * number + near.value.size() * (number + sizeof(int));
  session_.check_memory(matrix + pairs + small, std::max(matrix, pairs),
                        "the boundary-element matrix of " + std::to_string(n_rows_) + " unknowns", where.memory_bytes);
  matrix_ = session_.buffer(matrix);
  double_precision() ? assemble<double>(near) : assemble<float>(near);
}

std::vector<std::uint32_t> DeviceSystem::near_bits(const std::vector<int>& tests) const {
  std::vector<std::uint32_t> bits(tests.size() * static_cast<std::size_t>(words_), 0);
  for (std::size_t i = 0; i < tests.size(); ++i)
    for (const NearPair& pair : problem_.near.pairs[static_cast<std::size_t>(tests[i])])
      bits[i * static_cast<std::size_t>(words_) + static_cast<std::size_t>(pair.other / 32)] |= 1u << (pair.other % 32);
  return bits;
}

template <typename Real>
void DeviceSystem::assemble(const NearRows& near) {
  const std::vector<Real> scale(problem_.row_scale.data(), problem_.row_scale.data() + n_rows_);
  geometry_ = session_.upload(geometry_of<Real>(problem_.columns, static_cast<std::size_t>(n_triangles_)));
  row_scale_ = session_.upload(scale);
  std::vector<int> corners_at{0}, corners;
  for (int row = 0; row < n_rows_; ++row) {
    for (const int t : problem_.triangles_of_row[static_cast<std::size_t>(row)])
      for (int b = 0; b < 3; ++b)
        if (problem_.corner_rows(b, t) == row) corners.push_back(4 * t + b);
    corners_at.push_back(static_cast<int>(corners.size()));
  }
  corners_at_ = session_.upload(corners_at);
  corners_ = session_.upload(corners);
  // As many rows at a time as the memory for their triangles allows.
  const std::size_t one_test = 9 * static_cast<std::size_t>(n_triangles_) * 2 * sizeof(Real);
  const std::size_t most_tests = std::max<std::size_t>(pair_bytes_ / one_test, 1);
  std::vector<int> tests;
  std::vector<char> taken(static_cast<std::size_t>(n_triangles_), 0);
  int begin = 0;
  const auto flush = [&](int end) {
    if (end == begin) return;
    assemble_rows<Real>(begin, end, tests);
    for (const int t : tests) taken[static_cast<std::size_t>(t)] = 0;
    tests.clear();
    begin = end;
  };
  for (int row = 0; row < n_rows_; ++row) {
    const std::vector<int>& own = problem_.triangles_of_row[static_cast<std::size_t>(row)];
    const auto n_new = static_cast<std::size_t>(
        std::count_if(own.begin(), own.end(), [&](int t) { return taken[static_cast<std::size_t>(t)] == 0; }));
    if (tests.size() + n_new > most_tests) flush(row);
    for (const int t : own)
      if (!std::exchange(taken[static_cast<std::size_t>(t)], 1)) tests.push_back(t);
  }
  flush(n_rows_);
  pairs_ = {};
  std::vector<std::complex<Real>> values(near.value.begin(), near.value.end());
  const std::size_t group[2] = {session_.group(), 1};
  session_.run("add_near", {session_.padded(static_cast<std::size_t>(n_rows_))}, group, n_rows_,
               session_.upload(near.first), session_.upload(near.column), session_.upload(values), matrix_);
  session_.finish();
}

template <typename Real>
void DeviceSystem::assemble_rows(int begin, int end, const std::vector<int>& tests) {
  std::vector<int> place(static_cast<std::size_t>(n_triangles_), -1), users_at{0}, users;
  for (std::size_t i = 0; i < tests.size(); ++i) place[static_cast<std::size_t>(tests[i])] = static_cast<int>(i);
  for (int row = begin; row < end; ++row) {
    for (const int t : problem_.triangles_of_row[static_cast<std::size_t>(row)])
      for (int a = 0; a < 3; ++a)
        if (problem_.corner_rows(a, t) == row) users.push_back(4 * place[static_cast<std::size_t>(t)] + a);
    users_at.push_back(static_cast<int>(users.size()));
  }
  const std::size_t n_bytes = 9 * tests.size() * static_cast<std::size_t>(n_triangles_) * 2 * sizeof(Real);
  if (pairs_.size() < n_bytes) {
    session_.finish();
    pairs_ = session_.buffer(n_bytes);
  }
  const std::size_t group[2] = {session_.group(), 1};
  session_.run("far_pairs", {session_.padded(static_cast<std::size_t>(n_triangles_)), tests.size()}, group,
               n_triangles_, geometry_, session_.upload(tests), session_.upload(near_bits(tests)), words_,
               static_cast<Real>(problem_.wavenumber_per_m), static_cast<Real>(problem_.eta_m), pairs_);
  session_.run("gathered", {session_.padded(static_cast<std::size_t>(n_rows_)), static_cast<std::size_t>(end - begin)},
               group, n_triangles_, n_rows_, begin, session_.upload(users_at), session_.upload(users), corners_at_,
               corners_, row_scale_, pairs_, matrix_);
}

template <typename Real>
Eigen::MatrixXcd DeviceSystem::far_right_of(const Eigen::MatrixXcd& at_points) {
  const auto n = static_cast<std::size_t>(n_triangles_);
  Eigen::MatrixXcd right = Eigen::MatrixXcd::Zero(n_rows_, at_points.cols());
  opencl::Buffer sums = session_.buffer(3 * n * kColumns * 2 * sizeof(Real));
  for (Eigen::Index first = 0; first < at_points.cols(); first += kColumns) {
    // Rows 3 t + q to (3 c + q) n + t.
    const Numbers<Real> values = four_columns<Real>(at_points, first);
    Numbers<Real> sorted(n_triangles_, 3 * kColumns);
    for (int c = 0; c < kColumns; ++c)
      for (int q = 0; q < 3; ++q)
        for (int t = 0; t < n_triangles_; ++t) sorted(t, 3 * c + q) = values(3 * t + q, c);
    const opencl::Buffer value = session_.upload_bytes(sorted.data(), 12 * n * 2 * sizeof(Real));
    for (int test = 0; test < n_triangles_; test += kTestsAtOnce) {
      std::vector<int> tests;
      for (int t = test; t < std::min(test + kTestsAtOnce, n_triangles_); ++t) tests.push_back(t);
      const std::size_t group[1] = {session_.group()};
      session_.run("far_right", {tests.size() * group[0]}, group, n_triangles_, geometry_, test,
                   session_.upload(near_bits(tests)), words_, static_cast<Real>(problem_.wavenumber_per_m),
                   static_cast<Real>(problem_.eta_m), value, sums);
    }
    std::vector<std::complex<Real>> at_test(3 * n * kColumns);  // [(3 t + i) kColumns + c], i the test's points
    session_.read(sums, at_test.data(), at_test.size() * sizeof at_test[0]);
    for (Eigen::Index c = 0; c < std::min<Eigen::Index>(kColumns, at_points.cols() - first); ++c)
      for (int t = 0; t < n_triangles_; ++t) {
        Complex value_at[3], sum = 0.0;
        for (int i = 0; i < 3; ++i) {
          value_at[i] = Complex(at_test[static_cast<std::size_t>((3 * t + i) * kColumns + c)]);
          sum += value_at[i];
        }
        for (int a = 0; a < 3; ++a) right(problem_.corner_rows(a, t), first + c) += 0.5 * value_at[a] + sum / 6.0;
      }
  }
  return problem_.row_scale.asDiagonal() * right;
}

Eigen::MatrixXcd DeviceSystem::far_right(const Eigen::MatrixXcd& at_points) {
  KLANG_CHECK(at_points.rows() == 3 * static_cast<Eigen::Index>(n_triangles_), "three points per triangle");
  return double_precision() ? far_right_of<double>(at_points) : far_right_of<float>(at_points);
}

template <typename Real>
Eigen::MatrixXcd DeviceSystem::times_of(const Eigen::MatrixXcd& x) {
  Eigen::MatrixXcd y(n_rows_, x.cols());
  const std::size_t n_bytes = kColumns * static_cast<std::size_t>(n_rows_) * 2 * sizeof(Real);
  const opencl::Buffer to = session_.buffer(n_bytes);
  for (Eigen::Index first = 0; first < x.cols(); first += kColumns) {
    Numbers<Real> values = four_columns<Real>(x, first);
    const std::size_t group[1] = {session_.group()};
    session_.run("product", {static_cast<std::size_t>(n_rows_) * group[0]}, group, n_rows_, matrix_,
                 session_.upload_bytes(values.data(), n_bytes), to);
    session_.read(to, values.data(), n_bytes);
    const Eigen::Index count = std::min<Eigen::Index>(kColumns, x.cols() - first);
    y.middleCols(first, count) = values.leftCols(count).template cast<Complex>();
  }
  return y;
}

Eigen::MatrixXcd DeviceSystem::times(const Eigen::MatrixXcd& x) {
  KLANG_CHECK(x.rows() == n_rows_, "a number for each unknown");
  return double_precision() ? times_of<double>(x) : times_of<float>(x);
}

template <typename Real>
Eigen::MatrixXcd DeviceSystem::read_rows(int first, int count, int n_columns) {
  const std::size_t number = 2 * sizeof(Real), n = static_cast<std::size_t>(n_rows_);
  const int first_column = n_columns == n_rows_ ? 0 : first;
  std::vector<std::complex<Real>> values(static_cast<std::size_t>(count) * static_cast<std::size_t>(n_columns));
  session_.read_block(matrix_, (static_cast<std::size_t>(first) * n + static_cast<std::size_t>(first_column)) * number,
                      n * number, static_cast<std::size_t>(n_columns) * number, static_cast<std::size_t>(count),
                      values.data());
  return Eigen::Map<const Numbers<Real>>(values.data(), n_columns, count).transpose().template cast<Complex>();
}

Eigen::MatrixXcd DeviceSystem::block(int first, int count) {
  return double_precision() ? read_rows<double>(first, count, count) : read_rows<float>(first, count, count);
}

la::RowMatrixXcd DeviceSystem::matrix() {
  la::RowMatrixXcd result(n_rows_, n_rows_);
  constexpr int kAtOnce = 256;
  for (int row = 0; row < n_rows_; row += kAtOnce) {
    const int count = std::min(kAtOnce, n_rows_ - row);
    result.middleRows(row, count) =
        double_precision() ? read_rows<double>(row, count, n_rows_) : read_rows<float>(row, count, n_rows_);
  }
  return result;
}

}  // namespace klang::acoustics::detail
