#include "core/sound/bem/helmholtz_bem.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/math/triangle_rules.hpp"
#include "core/sound/bem/detail/assembly.hpp"
#include "core/sound/bem/detail/bem_solve.hpp"
#include "core/sound/bem/detail/near_field.hpp"
#include "core/sound/bem/detail/static_integrals.hpp"

namespace klang::acoustics {

using Complex = std::complex<double>;
using Eigen::Vector3d;

namespace {

constexpr Complex kI{0.0, 1.0};

}  // namespace

void BemOptions::validate() const { validate_fields("boundary elements", *this); }

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
  explicit Data(RadiatingSurface radiating) : geometry(std::move(radiating)) {}
  detail::BemGeometry geometry;

  /// Without mirrors: devices know none.
  const detail::BemGeometry& whole() const {
    if (geometry.surface.mirrors.planes.axes.empty()) return geometry;
    std::call_once(made_whole, [&] {
      RadiatingSurface surface = geometry.surface;
      surface.mirrors = {};
      without_mirrors = std::make_unique<const detail::BemGeometry>(std::move(surface));
    });
    return *without_mirrors;
  }

 private:
  mutable std::once_flag made_whole;
  mutable std::unique_ptr<const detail::BemGeometry> without_mirrors;
};

HelmholtzBem::HelmholtzBem(RadiatingSurface surface) : data_(std::make_unique<const Data>(std::move(surface))) {}

HelmholtzBem::~HelmholtzBem() = default;
HelmholtzBem::HelmholtzBem(HelmholtzBem&&) noexcept = default;

const RadiatingSurface& HelmholtzBem::surface() const { return data_->geometry.surface; }

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

BemResult HelmholtzBem::solve(double frequency_hz, const Eigen::MatrixXcd& velocity_m_s, const BemOptions& options,
                              Monitor& monitor) const {
  options.validate();
  checked("boundary elements", "frequency_hz", frequency_hz, 1e-3, 1e7);
  const RadiatingSurface& s = data_->geometry.surface;
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
  const Eigen::MatrixXcd derivative =
      (-kI * (k * options.medium.sound_speed_m_s * options.medium.density_kg_m3)) * velocity_m_s;

  const Eigen::Index n_columns = velocity_m_s.cols();
  detail::BemSolution solution;
  if (options.device.used) {
    const detail::Assembly assembly(data_->whole(), k, derivative);
    solution = detail::solve_on_device({data_->whole(), assembly, n_columns, options, monitor});
  }
  if (!solution.done) {
    const std::string message = solution.message;
    const detail::MirrorClasses::Parts parts = data_->geometry.classes.split(derivative);
    const detail::Assembly assembly(data_->geometry, k, parts.at_corner);
    solution = detail::solve_on_processor({data_->geometry, assembly, n_columns, options, monitor}, parts.list);
    solution.message = message;
  }
  result.relative_residual = solution.relative_residual;
  result.n_refinements = solution.n_refinements;
  result.double_factor = solution.double_factor;
  result.n_products = solution.n_products;
  result.device = solution.device;
  result.device_message = solution.message;
  result.wall_time_s = solution.wall_time_s;
  result.wall_time_s["total"] = total.seconds();
  if (!solution.solved) {
    result.status = BemStatus::kFailed;
    result.message = "the boundary-element system of " + std::to_string(s.n_vertices()) + " unknowns at " +
                     to_text(frequency_hz) + " Hz was not solved: relative residual " +
                     to_text(solution.relative_residual.value_or(NAN));
    return result;
  }
  result.pressure_pa = std::move(solution.x);
  result.radiated_power_w = Eigen::VectorXd::Zero(n_columns);
  result.power_scale_w = Eigen::VectorXd::Zero(n_columns);
  for (int t = 0; t < s.n_triangles(); ++t)
    for (Eigen::Index c = 0; c < n_columns; ++c)
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
  const RadiatingSurface& s = data_->geometry.surface;
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
  const RadiatingSurface& s = data_->geometry.surface;
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
  const RadiatingSurface& s = data_->geometry.surface;
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
