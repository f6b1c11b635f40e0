#include "core/sound/bem/detail/assembly.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <utility>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/triangle_rules.hpp"
#include "core/sound/bem/detail/spatial_order.hpp"
#include "core/sound/bem/detail/static_integrals.hpp"

namespace klang::acoustics::detail {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;

constexpr Complex kI{0.0, 1.0};
constexpr std::size_t kNearRowsAtOnce = 48;

}  // namespace

BemGeometry::BemGeometry(RadiatingSurface radiating) : surface(std::move(radiating)), classes(surface) {
  const RadiatingSurface& s = surface;
  const auto n = static_cast<std::size_t>(s.n_triangles());
  KLANG_CHECK(n > 0, "a surface without triangles");
  const std::vector<int> order = spatial_order(s.vertices_m);
  row_of_vertex.assign(order.size(), -1);
  column_of_vertex.resize(order.size());
  int n_rows = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    column_of_vertex[order[i]] = static_cast<int>(i);
    if (order[i] < classes.n_own_vertices()) row_of_vertex[order[i]] = n_rows++;
  }
  triangles_of_row.resize(static_cast<std::size_t>(n_rows));
  corner_rows.resize(3, s.n_triangles());
  corner_columns.resize(3, s.n_triangles());
  std::vector<char> tested(n, 0);
  for (int t = 0; t < s.n_triangles(); ++t)
    for (int c = 0; c < 3; ++c) {
      corner_columns(c, t) = column_of_vertex[s.triangles(c, t)];
      corner_rows(c, t) = row_of_vertex[s.triangles(c, t)];
      if (corner_rows(c, t) < 0) continue;
      triangles_of_row[corner_rows(c, t)].push_back(t);
      tested[t] = 1;
    }

  columns.n_padded = (n + simd::kLanes - 1) / simd::kLanes * simd::kLanes;
  for (auto* group : {&columns.points_m, &columns.curls})
    for (auto& axes : *group)
      for (auto& values : axes) values.assign(columns.n_padded, 0.0);
  for (auto& values : columns.normals) values.assign(columns.n_padded, 0.0);
  columns.weights_m2.assign(columns.n_padded, 0.0);
  curls.resize(n);
  for (std::size_t j = 0; j < n; ++j) {
    const int t = static_cast<int>(j);
    const FlatTriangle flat(s.corner(t, 0), s.corner(t, 1), s.corner(t, 2));
    for (int c = 0; c < 3; ++c) curls[j][c] = flat.normal.cross(flat.gradient[c]);
    columns.weights_m2[j] = s.areas_m2[t] / 3.0;
    const auto points = three_points();
    for (int axis = 0; axis < 3; ++axis) {
      columns.normals[axis][j] = s.normals(axis, t);
      for (int q = 0; q < 3; ++q) {
        double x = 0.0;
        for (int c = 0; c < 3; ++c) x += points[q].at[c] * flat.corners[c][axis];
        columns.points_m[q][axis][j] = x;
        columns.curls[q][axis][j] = curls[j][q][axis];
      }
    }
  }
  near = near_field(s, tested);
}

Assembly::Assembly(const BemGeometry& geometry, double wavenumber_per_m, const Eigen::MatrixXcd& derivative)
    : geometry_(geometry),
      wavenumber_per_m_(wavenumber_per_m),
      eta_m_(1.0 / std::max(wavenumber_per_m, 1.0 / geometry.surface.radius_m)),
      derivative_(derivative),
      at_points_(derivative.rows(), derivative.cols()) {
  const RadiatingSurface& s = geometry.surface;
  for (int t = 0; t < s.n_triangles(); ++t) {
    const auto corners = derivative.middleRows(3 * t, 3);
    at_points_.middleRows(3 * t, 3) = (0.5 * corners).rowwise() + corners.colwise().sum() / 6.0;
  }
  const std::size_t n_padded = geometry.columns.n_padded;
  point_values_.assign(6 * n_padded * static_cast<std::size_t>(derivative.cols()), 0.0);
  for (Eigen::Index c = 0; c < derivative.cols(); ++c)
    for (int t = 0; t < s.n_triangles(); ++t)
      for (int q = 0; q < 3; ++q) {
        double* const to = point_values_.data() + 2 * (3 * static_cast<std::size_t>(c) + q) * n_padded + t;
        to[0] = at_points_(3 * t + q, c).real();
        to[n_padded] = at_points_(3 * t + q, c).imag();
      }
  row_scale_.resize(static_cast<Eigen::Index>(geometry.triangles_of_row.size()));
  for (Eigen::Index row = 0; row < row_scale_.size(); ++row) {
    double lumped = 0.0;
    for (const int t : geometry.triangles_of_row[static_cast<std::size_t>(row)]) lumped += s.areas_m2[t] / 3.0;
    row_scale_[row] = 1.0 / lumped;
  }
}

void Assembly::far(const Tests& tests, const Target& target, std::vector<double>& keep, FarBlock& block) const {
  const RadiatingSurface& surface = geometry_.surface;
  const TriangleColumns& columns = geometry_.columns;
  const int t = tests.triangle;
  const auto n = static_cast<std::size_t>(surface.n_triangles());
  for (const auto& pair : geometry_.near.pairs[t]) keep[pair.other] = 0.0;
  TestTriangle test;
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      test.points_m[i][axis] = columns.points_m[i][axis][t];
      test.curls[i][axis] = geometry_.curls[t][i][axis];
      test.normal[axis] = surface.normals(axis, t);
    }
  test.weight_m2 = columns.weights_m2[t];
  for (std::size_t first = 0; first < columns.n_padded; first += kBlockTriangles) {
    const std::size_t count = std::min(kBlockTriangles, columns.n_padded - first);
    far_block(columns, keep.data(), first, count, test, wavenumber_per_m_, eta_m_, block);
    const std::size_t real = std::min(count, n - first);
    for (int a = 0; a < 3; ++a) {
      if (tests.rows[a] < 0) continue;
      Complex* const row = target.matrix.row(tests.rows[a] - target.first).data();
      for (std::size_t j = 0; j < real; ++j) {
        if (keep[first + j] == 0.0) continue;
        for (int b = 0; b < 3; ++b) {
          const int column = geometry_.corner_columns(b, static_cast<Eigen::Index>(first + j));
          row[column] += Complex(block.system[a][b][0][j], block.system[a][b][1][j]);
        }
      }
    }
    for (Eigen::Index c = 0; c < derivative_.cols(); ++c) {
      const double* values[3][2];
      for (int q = 0; q < 3; ++q)
        for (int part = 0; part < 2; ++part)
          values[q][part] =
              point_values_.data() + ((3 * static_cast<std::size_t>(c) + q) * 2 + part) * columns.n_padded + first;
      double sums[3][2];
      far_sums(block, count, values, sums);
      for (int a = 0; a < 3; ++a)
        if (tests.rows[a] >= 0) target.right(tests.rows[a], c) += Complex(sums[a][0], sums[a][1]);
    }
  }
  for (const auto& pair : geometry_.near.pairs[t]) keep[pair.other] = 1.0;
}

void Assembly::close(const Tests& tests, const Target& target) const {
  const RadiatingSurface& surface = geometry_.surface;
  const auto& curls = geometry_.curls;
  const int t = tests.triangle;
  const double k = wavenumber_per_m_;
  const Complex coupling = kI * eta_m_;
  for (const auto& pair : geometry_.near.pairs[t]) {
    const SmoothPart smooth = smooth_part(surface, t, pair.other, k);
    const Eigen::Matrix3cd single = (pair.single + smooth.single) / (4.0 * kPi);
    const Eigen::Matrix3cd twice = (pair.twice + smooth.twice) / (4.0 * kPi);
    const Eigen::Matrix3cd adjoint = (pair.adjoint + smooth.adjoint) / (4.0 * kPi);
    const double n_n = surface.normals.col(t).dot(surface.normals.col(pair.other));
    const Complex all = single.sum();
    Eigen::Matrix3cd system = -twice + (coupling * (k * k * n_n)) * single;
    Eigen::Matrix3cd source = -single + coupling * adjoint;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) system(a, b) -= coupling * curls[t][a].dot(curls[pair.other][b]) * all;
    if (pair.other == t) {
      const Eigen::Matrix3d mass = surface.areas_m2[t] / 12.0 * (Eigen::Matrix3d::Ones() + Eigen::Matrix3d::Identity());
      system += 0.5 * mass;
      source += (0.5 * coupling) * mass;
    }
    for (int a = 0; a < 3; ++a) {
      if (tests.rows[a] < 0) continue;
      for (int b = 0; b < 3; ++b) {
        target.matrix(tests.rows[a] - target.first, geometry_.corner_columns(b, pair.other)) += system(a, b);
        target.right.row(tests.rows[a]) += source(a, b) * derivative_.row(3 * pair.other + b);
      }
    }
  }
}

std::vector<Assembly::Tests> Assembly::tests_of(std::size_t begin, std::size_t end) const {
  std::vector<int> touched;
  for (std::size_t row = begin; row < end; ++row)
    touched.insert(touched.end(), geometry_.triangles_of_row[row].begin(), geometry_.triangles_of_row[row].end());
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  std::vector<Tests> tests;
  for (const int t : touched) {
    Tests one{t, {-1, -1, -1}};
    for (int a = 0; a < 3; ++a)
      if (const int row = geometry_.corner_rows(a, t); row >= static_cast<int>(begin) && row < static_cast<int>(end))
        one.rows[a] = row;
    tests.push_back(one);
  }
  return tests;
}

void Assembly::scale(std::size_t begin, std::size_t end, const Target& target) const {
  for (auto row = static_cast<Eigen::Index>(begin); row < static_cast<Eigen::Index>(end); ++row) {
    target.matrix.row(row - target.first) *= row_scale_[row];
    target.right.row(row) *= row_scale_[row];
  }
}

void Assembly::rows(std::size_t begin, std::size_t end, la::RowMatrixXcd& matrix, Eigen::MatrixXcd& right) const {
  std::vector<double> keep(geometry_.columns.n_padded, 1.0);
  std::fill(keep.begin() + geometry_.surface.n_triangles(), keep.end(), 0.0);
  const auto block = std::make_unique<FarBlock>();
  const Target target{0, matrix, right};
  // Every row sums its triangles in ascending order, so that the cut into blocks of rows does not show in the bits.
  for (const Tests& tests : tests_of(begin, end)) {
    far(tests, target, keep, *block);
    close(tests, target);
  }
  scale(begin, end, target);
}

NearRows Assembly::near_rows(Eigen::MatrixXcd& right) const {
  const std::size_t n = geometry_.triangles_of_row.size(), n_blocks = (n + kNearRowsAtOnce - 1) / kNearRowsAtOnce;
  std::vector<NearRows> of_block(n_blocks);
  parallel_for(n_blocks, 1, [&](std::size_t first_block, std::size_t last_block) {
    la::RowMatrixXcd dense(kNearRowsAtOnce, n);
    for (std::size_t b = first_block; b < last_block; ++b) {
      const std::size_t begin = b * kNearRowsAtOnce, end = std::min(begin + kNearRowsAtOnce, n);
      dense.setZero();
      const Target target{static_cast<int>(begin), dense, right};
      for (const Tests& tests : tests_of(begin, end)) close(tests, target);
      scale(begin, end, target);
      NearRows& rows = of_block[b];
      for (std::size_t row = begin; row < end; ++row) {
        rows.first.push_back(static_cast<int>(rows.value.size()));
        for (std::size_t column = 0; column < n; ++column) {
          const Complex value = dense(static_cast<Eigen::Index>(row - begin), static_cast<Eigen::Index>(column));
          if (value == Complex(0.0)) continue;
          rows.column.push_back(static_cast<int>(column));
          rows.value.push_back(value);
        }
      }
    }
  });
  NearRows all;
  for (const NearRows& rows : of_block) {
    for (const int first : rows.first) all.first.push_back(static_cast<int>(all.value.size()) + first);
    all.column.insert(all.column.end(), rows.column.begin(), rows.column.end());
    all.value.insert(all.value.end(), rows.value.begin(), rows.value.end());
  }
  all.first.push_back(static_cast<int>(all.value.size()));
  return all;
}

FarProblem Assembly::far_problem() const {
  return {geometry_.columns,
          geometry_.corner_rows,
          geometry_.triangles_of_row,
          geometry_.near,
          row_scale_,
          wavenumber_per_m_,
          eta_m_};
}

}  // namespace klang::acoustics::detail
