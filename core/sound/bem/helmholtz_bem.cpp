#include "core/sound/bem/helmholtz_bem.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/la/dense_solve.hpp"
#include "core/foundation/math/triangle_rules.hpp"
#include "core/sound/bem/detail/far_kernel.hpp"
#include "core/sound/bem/detail/near_field.hpp"
#include "core/sound/bem/detail/static_integrals.hpp"

namespace klang::acoustics {

using Complex = std::complex<double>;
using Eigen::Vector3d;

namespace {

constexpr Complex kI{0.0, 1.0};

/// Vertices in the order of a space-filling curve (Morton): neighbours in space are neighbours in the matrix.
std::vector<int> spatial_order(const Eigen::Matrix3Xd& points) {
  const Vector3d low = points.rowwise().minCoeff();
  const double size = std::max((points.rowwise().maxCoeff() - low).maxCoeff(), 1e-300);
  std::vector<std::uint64_t> key(static_cast<std::size_t>(points.cols()), 0);
  for (Eigen::Index v = 0; v < points.cols(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::uint64_t>((points(axis, v) - low[axis]) / size * 1023.0);
      for (int bit = 0; bit < 10; ++bit) key[static_cast<std::size_t>(v)] |= (cell >> bit & 1) << (3 * bit + axis);
    }
  std::vector<int> order(key.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key[a] < key[b]; });
  return order;
}

}  // namespace

void BemOptions::validate() const {
  medium.validate();
  checked("boundary elements", "min_elements_per_wavelength", min_elements_per_wavelength, 0.5, 100.0);
  checked("boundary elements", "tolerance", tolerance, 1e-13, 1e-3);
  if (max_refinements < 1 || max_refinements > 1000)
    throw InputError("boundary elements", "max_refinements", std::to_string(max_refinements), "1 to 1000");
}

double check_resolution(const RadiatingSurface& surface, double frequency_hz, const BemOptions& options) {
  const double wavelength_m = options.medium.sound_speed_m_s / frequency_hz;
  const double count = wavelength_m / surface.largest_edge_m;
  if (count < options.min_elements_per_wavelength && !options.allow_coarse) {
    char text[200];
    std::snprintf(text, sizeof text, "%.3g elements per wavelength at %.6g Hz; the largest element is %.4g m", count,
                  frequency_hz, surface.largest_edge_m);
    char allowed[200];
    std::snprintf(allowed, sizeof allowed, "elements of at most %.4g m (%g per wavelength)",
                  wavelength_m / options.min_elements_per_wavelength, options.min_elements_per_wavelength);
    throw InputError("surface", "is too coarse for the frequency", text, allowed);
  }
  return count;
}

struct HelmholtzBem::Data {
  RadiatingSurface surface;
  std::vector<int> row_of_vertex;                  ///< place in the matrix
  std::vector<std::vector<int>> triangles_of_row;  ///< ascending
  detail::TriangleColumns columns;
  detail::NearField near;
  std::vector<std::array<Vector3d, 3>> curls;  ///< n x grad phi of each corner
};

HelmholtzBem::HelmholtzBem(RadiatingSurface surface) {
  auto data = std::make_unique<Data>();
  data->surface = std::move(surface);
  const RadiatingSurface& s = data->surface;
  const auto n = static_cast<std::size_t>(s.n_triangles());
  KLANG_CHECK(n > 0, "a surface without triangles");
  const std::vector<int> order = spatial_order(s.vertices_m);
  data->row_of_vertex.resize(order.size());
  for (std::size_t row = 0; row < order.size(); ++row) data->row_of_vertex[order[row]] = static_cast<int>(row);
  data->triangles_of_row.resize(order.size());
  for (int t = 0; t < s.n_triangles(); ++t)
    for (int c = 0; c < 3; ++c) data->triangles_of_row[data->row_of_vertex[s.triangles(c, t)]].push_back(t);

  detail::TriangleColumns& columns = data->columns;
  columns.n_padded = (n + simd::kLanes - 1) / simd::kLanes * simd::kLanes;
  for (auto* group : {&columns.points_m, &columns.curls})
    for (auto& axes : *group)
      for (auto& values : axes) values.assign(columns.n_padded, 0.0);
  for (auto& values : columns.normals) values.assign(columns.n_padded, 0.0);
  columns.weights_m2.assign(columns.n_padded, 0.0);
  data->curls.resize(n);
  for (std::size_t j = 0; j < n; ++j) {
    const int t = static_cast<int>(j);
    const detail::FlatTriangle flat(s.corner(t, 0), s.corner(t, 1), s.corner(t, 2));
    for (int c = 0; c < 3; ++c) data->curls[j][c] = flat.normal.cross(flat.gradient[c]);
    columns.weights_m2[j] = s.areas_m2[t] / 3.0;
    const auto points = three_points();
    for (int axis = 0; axis < 3; ++axis) {
      columns.normals[axis][j] = s.normals(axis, t);
      for (int q = 0; q < 3; ++q) {
        double x = 0.0;
        for (int c = 0; c < 3; ++c) x += points[q].at[c] * flat.corners[c][axis];
        columns.points_m[q][axis][j] = x;
        columns.curls[q][axis][j] = data->curls[j][q][axis];
      }
    }
  }
  data->near = detail::near_field(s);
  data_ = std::move(data);
}

HelmholtzBem::~HelmholtzBem() = default;
HelmholtzBem::HelmholtzBem(HelmholtzBem&&) noexcept = default;

const RadiatingSurface& HelmholtzBem::surface() const { return data_->surface; }

Eigen::MatrixXcd HelmholtzBem::from_triangles(const Eigen::MatrixXcd& velocity_m_s) const {
  KLANG_CHECK(velocity_m_s.rows() == surface().n_triangles(), "one velocity per triangle");
  Eigen::MatrixXcd corners(3 * velocity_m_s.rows(), velocity_m_s.cols());
  for (Eigen::Index t = 0; t < velocity_m_s.rows(); ++t)
    corners.middleRows(3 * t, 3) = velocity_m_s.row(t).replicate(3, 1);
  return corners;
}

Eigen::MatrixXcd HelmholtzBem::from_vertices(const Eigen::MatrixXcd& velocity_m_s) const {
  KLANG_CHECK(velocity_m_s.rows() == surface().n_vertices(), "one velocity per vertex");
  const Eigen::Matrix3Xi& triangles = surface().triangles;
  Eigen::MatrixXcd corners(3 * triangles.cols(), velocity_m_s.cols());
  for (Eigen::Index t = 0; t < triangles.cols(); ++t)
    for (int c = 0; c < 3; ++c) corners.row(3 * t + c) = velocity_m_s.row(triangles(c, t));
  return corners;
}

namespace {

/// Matrix and right-hand sides for q = normal derivative at the corners (3 n_triangles x n_columns).
struct Assembly {
  const RadiatingSurface& surface;
  const std::vector<int>& row_of_vertex;
  const std::vector<std::vector<int>>& triangles_of_row;
  const detail::TriangleColumns& columns;
  const detail::NearField& near;
  const std::vector<std::array<Vector3d, 3>>& curls;
  double wavenumber_per_m, eta_m;
  const Eigen::MatrixXcd& derivative;
  Eigen::MatrixXcd at_points;  ///< of the normal derivative: row 3 t + q
  la::RowMatrixXcd& matrix;
  Eigen::MatrixXcd& right;  ///< n_rows x n_columns

  void rows(std::size_t begin, std::size_t end) const;

 private:
  void far(int t, const int* rows_of_test, std::vector<double>& keep, detail::FarBlock& block) const;
  void close(int t, const int* rows_of_test) const;
};

/// rows_of_test[a]: matrix row of corner a, or -1 where another block owns it.
void Assembly::far(int t, const int* rows_of_test, std::vector<double>& keep, detail::FarBlock& block) const {
  const auto n = static_cast<std::size_t>(surface.n_triangles());
  for (const auto& pair : near.pairs[t]) keep[pair.other] = 0.0;
  detail::TestTriangle test;
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      test.points_m[i][axis] = columns.points_m[i][axis][t];
      test.curls[i][axis] = curls[t][i][axis];
      test.normal[axis] = surface.normals(axis, t);
    }
  test.weight_m2 = columns.weights_m2[t];
  for (std::size_t first = 0; first < columns.n_padded; first += detail::kBlockTriangles) {
    const std::size_t count = std::min(detail::kBlockTriangles, columns.n_padded - first);
    detail::far_block(columns, keep.data(), first, count, test, wavenumber_per_m, eta_m, block);
    const std::size_t real = std::min(count, n - first);
    for (int a = 0; a < 3; ++a) {
      if (rows_of_test[a] < 0) continue;
      Complex* const row = matrix.row(rows_of_test[a]).data();
      for (std::size_t j = 0; j < real; ++j) {
        if (keep[first + j] == 0.0) continue;
        for (int b = 0; b < 3; ++b) {
          const int column = row_of_vertex[surface.triangles(b, static_cast<Eigen::Index>(first + j))];
          row[column] += Complex(block.system[a][b][0][j], block.system[a][b][1][j]);
        }
      }
      for (Eigen::Index c = 0; c < derivative.cols(); ++c) {
        double re = 0.0, im = 0.0;
        const Complex* const q = at_points.col(c).data() + 3 * first;
        for (std::size_t j = 0; j < real; ++j)
          for (int point = 0; point < 3; ++point) {
            const double k_re = block.source[a][point][0][j], k_im = block.source[a][point][1][j];
            const Complex value = q[3 * j + point];
            re += k_re * value.real() - k_im * value.imag();
            im += k_re * value.imag() + k_im * value.real();
          }
        right(rows_of_test[a], c) += Complex(re, im);
      }
    }
  }
  for (const auto& pair : near.pairs[t]) keep[pair.other] = 1.0;
}

void Assembly::close(int t, const int* rows_of_test) const {
  const double k = wavenumber_per_m;
  const Complex coupling = kI * eta_m;
  for (const auto& pair : near.pairs[t]) {
    const detail::SmoothPart smooth = detail::smooth_part(surface, t, pair.other, k);
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
      if (rows_of_test[a] < 0) continue;
      for (int b = 0; b < 3; ++b) {
        matrix(rows_of_test[a], row_of_vertex[surface.triangles(b, pair.other)]) += system(a, b);
        right.row(rows_of_test[a]) += source(a, b) * derivative.row(3 * pair.other + b);
      }
    }
  }
}

void Assembly::rows(std::size_t begin, std::size_t end) const {
  std::vector<double> keep(columns.n_padded, 1.0);
  std::fill(keep.begin() + surface.n_triangles(), keep.end(), 0.0);
  const auto block = std::make_unique<detail::FarBlock>();
  std::vector<int> touched;
  for (std::size_t row = begin; row < end; ++row)
    touched.insert(touched.end(), triangles_of_row[row].begin(), triangles_of_row[row].end());
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  // Every row sums its triangles in ascending order, so that the cut into blocks of rows does not show in the bits.
  Eigen::VectorXd lumped = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(end - begin));
  for (const int t : touched) {
    int rows_of_test[3];
    for (int a = 0; a < 3; ++a) {
      const int row = row_of_vertex[surface.triangles(a, t)];
      const bool own = row >= static_cast<int>(begin) && row < static_cast<int>(end);
      rows_of_test[a] = own ? row : -1;
      if (own) lumped[row - static_cast<int>(begin)] += surface.areas_m2[t] / 3.0;
    }
    far(t, rows_of_test, keep, *block);
    close(t, rows_of_test);
  }
  // Rows of equal size whatever the triangles.
  for (std::size_t row = begin; row < end; ++row) {
    const double scale = 1.0 / lumped[static_cast<Eigen::Index>(row - begin)];
    matrix.row(static_cast<Eigen::Index>(row)) *= scale;
    right.row(static_cast<Eigen::Index>(row)) *= scale;
  }
}

}  // namespace

BemResult HelmholtzBem::solve(double frequency_hz, const Eigen::MatrixXcd& velocity_m_s, const BemOptions& options,
                              Monitor& monitor) const {
  options.validate();
  checked("boundary elements", "frequency_hz", frequency_hz, 1e-3, 1e7);
  const RadiatingSurface& s = data_->surface;
  KLANG_CHECK(velocity_m_s.rows() == 3 * s.n_triangles(), "a velocity at each corner of each triangle");
  if (!velocity_m_s.allFinite()) throw InputError("boundary elements", "a velocity is not finite");
  const Stopwatch total;
  BemResult result;
  result.frequency_hz = frequency_hz;
  result.medium = options.medium;
  result.elements_per_wavelength = check_resolution(s, frequency_hz, options);
  result.wavenumber_per_m = options.medium.wavenumber_per_m(frequency_hz);
  result.velocity_m_s = velocity_m_s;
  result.n_elements = s.n_triangles();
  result.n_unknowns = s.n_vertices();
  const double k = result.wavenumber_per_m;
  const auto n = static_cast<std::size_t>(s.n_vertices());
  const Eigen::MatrixXcd derivative =
      (-kI * (k * options.medium.sound_speed_m_s * options.medium.density_kg_m3)) * velocity_m_s;

  la::RowMatrixXcd matrix = la::RowMatrixXcd::Zero(s.n_vertices(), s.n_vertices());
  Eigen::MatrixXcd right = Eigen::MatrixXcd::Zero(s.n_vertices(), velocity_m_s.cols());
  Eigen::MatrixXcd at_points(derivative.rows(), derivative.cols());
  for (int t = 0; t < s.n_triangles(); ++t) {
    const auto corners = derivative.middleRows(3 * t, 3);
    at_points.middleRows(3 * t, 3) = (0.5 * corners).rowwise() + corners.colwise().sum() / 6.0;
  }
  const Assembly assembly{s,
                          data_->row_of_vertex,
                          data_->triangles_of_row,
                          data_->columns,
                          data_->near,
                          data_->curls,
                          k,
                          1.0 / std::max(k, 1.0 / s.radius_m),
                          derivative,
                          std::move(at_points),
                          matrix,
                          right};
  const std::size_t grain =
      options.alone ? std::clamp<std::size_t>(n / (6 * static_cast<std::size_t>(thread_count())), 24, 400) : 4000;
  std::atomic<std::size_t> done = 0;
  parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    if (monitor.stop_requested()) return;
    assembly.rows(begin, end);
    done += end - begin;
    monitor.progress("boundary elements", 0.7 * static_cast<double>(done) / static_cast<double>(n));
  });
  monitor.throw_if_stopped();
  result.wall_time_s["assemble"] = total.seconds();

  const BlasThreads blas(options.n_blas_threads > 0 ? options.n_blas_threads : thread_count());
  const la::DenseSolution solution = la::dense_solve(matrix, right, options.tolerance, options.max_refinements);
  result.relative_residual = solution.relative_residual;
  result.n_refinements = solution.n_refinements;
  result.double_factor = solution.double_factor;
  result.wall_time_s["factor"] = solution.factor_s;
  result.wall_time_s["refine"] = solution.refine_s;
  result.wall_time_s["total"] = total.seconds();
  if (!solution.solved) {
    result.status = BemStatus::kFailed;
    result.message = "the boundary-element system of " + std::to_string(n) + " unknowns at " + to_text(frequency_hz) +
                     " Hz was not solved: relative residual " + to_text(solution.relative_residual.value_or(NAN));
    return result;
  }
  result.pressure_pa.resize(s.n_vertices(), right.cols());
  for (int v = 0; v < s.n_vertices(); ++v) result.pressure_pa.row(v) = solution.x.row(data_->row_of_vertex[v]);
  result.radiated_power_w = Eigen::VectorXd::Zero(right.cols());
  result.power_scale_w = Eigen::VectorXd::Zero(right.cols());
  for (int t = 0; t < s.n_triangles(); ++t)
    for (Eigen::Index c = 0; c < right.cols(); ++c)
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          const double mass = s.areas_m2[t] / (a == b ? 6.0 : 12.0);
          const Complex p = result.pressure_pa(s.triangles(a, t), c), v = velocity_m_s(3 * t + b, c);
          result.radiated_power_w[c] += 0.5 * mass * (p * std::conj(v)).real();
          result.power_scale_w[c] += 0.5 * mass * std::abs(p) * std::abs(v);
        }
  result.status = BemStatus::kSolved;
  monitor.progress("boundary elements", 1.0);
  return result;
}

void HelmholtzBem::check_outside(const Eigen::Matrix3Xd& points_m) const {
  const RadiatingSurface& s = data_->surface;
  std::vector<char> inside(static_cast<std::size_t>(points_m.cols()), 0);
  parallel_for(inside.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3d x = points_m.col(static_cast<Eigen::Index>(i));
      double turns = 0.0;  // solid angles / 2 of all triangles: 2 pi from inside, 0 from outside
      for (int t = 0; t < s.n_triangles(); ++t) {
        const Vector3d a = s.corner(t, 0) - x, b = s.corner(t, 1) - x, c = s.corner(t, 2) - x;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        turns += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
      }
      inside[i] = turns > kPi ? 1 : 0;
    }
  });
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const Vector3d x = points_m.col(static_cast<Eigen::Index>(i));
    const std::string text = to_text(x[0]) + " " + to_text(x[1]) + " " + to_text(x[2]);
    if (!x.allFinite()) throw InputError("point " + std::to_string(i), "is not finite", text);
    if (inside[i] != 0) throw InputError("point " + std::to_string(i), "lies inside the body", text, "points outside");
  }
}

Eigen::VectorXcd HelmholtzBem::pressure_at(const BemResult& result, const Eigen::Matrix3Xd& points_m,
                                           int column) const {
  KLANG_CHECK(result.usable() && column >= 0 && column < result.pressure_pa.cols(),
              "a solution and one of its columns");
  const RadiatingSurface& s = data_->surface;
  const double k = result.wavenumber_per_m;
  Eigen::VectorXcd pressure(points_m.cols());
  std::vector<detail::FlatTriangle> triangles;
  triangles.reserve(static_cast<std::size_t>(s.n_triangles()));
  for (int t = 0; t < s.n_triangles(); ++t) triangles.emplace_back(s.corner(t, 0), s.corner(t, 1), s.corner(t, 2));
  const Complex to_derivative = -kI * (k * result.medium.sound_speed_m_s * result.medium.density_kg_m3);
  parallel_for(static_cast<std::size_t>(points_m.cols()), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3d x = points_m.col(static_cast<Eigen::Index>(i));
      Complex sum = 0.0;
      for (int t = 0; t < s.n_triangles(); ++t) {
        const bool near = (x - s.centroids_m.col(t)).norm() < 4.0 * s.radii_m[t];
        const Vector3d normal = s.normals.col(t);
        Eigen::Vector3cd p, q;
        for (int c = 0; c < 3; ++c) {
          p[c] = result.pressure_pa(s.triangles(c, t), column);
          q[c] = to_derivative * result.velocity_m_s(3 * t + c, column);
        }
        if (near) {
          const detail::StaticIntegrals inner =
              detail::static_integrals(triangles[static_cast<std::size_t>(t)], x, false);
          sum += inner.twice.cast<Complex>().cwiseProduct(p).sum() - inner.single.cast<Complex>().cwiseProduct(q).sum();
        }
        for (const TrianglePoint& point : seven_points()) {
          const Eigen::Map<const Vector3d> hats(point.at.data());
          const Vector3d d = x - (hats[0] * triangles[t].corners[0] + hats[1] * triangles[t].corners[1] +
                                  hats[2] * triangles[t].corners[2]);
          const double r = d.norm(), weight = point.weight * s.areas_m2[t];
          if (!(r > 0.0)) continue;
          const double static_part = near ? 0.0 : 1.0;
          const Complex g = (detail::wave_less_one(k * r) + static_part) * (weight / r);
          const Complex h = (detail::slope_less_one(k * r) + static_part) * (weight * normal.dot(d) / (r * r * r));
          sum += h * (hats.cast<Complex>().cwiseProduct(p).sum()) - g * (hats.cast<Complex>().cwiseProduct(q).sum());
        }
      }
      pressure[static_cast<Eigen::Index>(i)] = sum / (4.0 * kPi);
    }
  });
  return pressure;
}

SurfaceField HelmholtzBem::field(const BemResult& result, int column) const {
  KLANG_CHECK(result.usable() && column >= 0 && column < result.pressure_pa.cols(),
              "a solution and one of its columns");
  const RadiatingSurface& s = data_->surface;
  SurfaceField field;
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(s.n_triangles());
  field.points_m.resize(3, n);
  field.normals.resize(3, n);
  field.weights_m2.resize(n);
  field.pressure_pa.resize(n);
  field.normal_velocity_m_s.resize(n);
  const auto points = three_points();
  for (int t = 0; t < s.n_triangles(); ++t)
    for (int i = 0; i < 3; ++i) {
      const Eigen::Index at = 3 * t + i;
      field.points_m.col(at).setZero();
      field.normals.col(at) = s.normals.col(t);
      field.weights_m2[at] = points[i].weight * s.areas_m2[t];
      field.pressure_pa[at] = 0.0;
      field.normal_velocity_m_s[at] = 0.0;
      for (int c = 0; c < 3; ++c) {
        field.points_m.col(at) += points[i].at[c] * s.corner(t, c);
        field.pressure_pa[at] += points[i].at[c] * result.pressure_pa(s.triangles(c, t), column);
        field.normal_velocity_m_s[at] += points[i].at[c] * result.velocity_m_s(3 * t + c, column);
      }
    }
  return field;
}

}  // namespace klang::acoustics
