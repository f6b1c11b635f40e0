#include "core/sound/bem/equivalent_sources.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/sphere_quadrature.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;

// Values (pressure) and normal derivatives of every basis function of every source at the surface points.
struct SourceTable {
  Eigen::MatrixXcd values, slopes;  // n_points x n_columns
};

SourceTable source_table(const SurfaceField& field, double k, const std::vector<Eigen::Vector3d>& points, int order) {
  const HelmholtzBasis basis(order);
  const auto n_points = static_cast<std::size_t>(field.points_m.cols());
  SourceTable table;
  table.values.resize(field.points_m.cols(), basis.size() * static_cast<Eigen::Index>(points.size()));
  table.slopes.resizeLike(table.values);
  parallel_for(n_points, 64, [&](std::size_t begin, std::size_t end) {
    Eigen::VectorXcd values;
    Eigen::MatrixX3cd gradients;
    for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
      for (std::size_t s = 0; s < points.size(); ++s) {
        basis.values_and_gradients(Wave::kSingular, k, field.points_m.col(i) - points[s], values, gradients);
        const auto first = static_cast<Eigen::Index>(s) * basis.size();
        table.values.row(i).segment(first, basis.size()) = values.transpose();
        table.slopes.row(i).segment(first, basis.size()) =
            (gradients * field.normals.col(i).cast<Complex>()).transpose();
      }
    }
  });
  return table;
}

double winding_number(const SurfaceField& field, const Eigen::Vector3d& x) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < field.points_m.cols(); ++i) {
    const Eigen::Vector3d d = field.points_m.col(i) - x;
    const double r = d.norm();
    sum += field.weights_m2[i] * field.normals.col(i).dot(d) / (r * r * r);
  }
  return sum / (4.0 * kPi);
}

double distance_to(const SurfaceField& field, const Eigen::Vector3d& x) {
  return std::sqrt((field.points_m.colwise() - x).colwise().squaredNorm().minCoeff());
}

}  // namespace

void EquivalentSourceOptions::validate() const { validate_fields("equivalent sources", *this); }

EquivalentSources fit_equivalent_sources(const SurfaceField& field, double wavenumber_per_m, const Medium& medium,
                                         const std::vector<Eigen::Vector3d>& points_m,
                                         const EquivalentSourceOptions& options) {
  options.validate();
  medium.validate();
  const double k = checked_open("equivalent sources", "wavenumber_per_m", wavenumber_per_m, 0.0, 1e6);
  const Eigen::Index n_points = field.points_m.cols();
  KLANG_CHECK(field.normals.cols() == n_points && field.weights_m2.size() == n_points &&
                  field.normal_velocity_m_s.size() == n_points &&
                  (field.pressure_pa.size() == 0 || field.pressure_pa.size() == n_points),
              "a surface field has one normal, weight and velocity per point");
  if (points_m.empty()) throw InputError("equivalent sources", "have no point");
  for (const Eigen::Vector3d& x : points_m) {
    if (!(winding_number(field, x) > 0.5)) {
      throw InputError("equivalent sources", "a point is not inside the body",
                       to_text(x.x()) + ", " + to_text(x.y()) + ", " + to_text(x.z()));
    }
  }
  EquivalentSources result;
  const SourceTable table = source_table(field, k, points_m, options.order);
  const Eigen::Index n_columns = table.slopes.cols();
  const Complex by_velocity(0.0, -k * medium.sound_speed_m_s * medium.density_kg_m3);  // dp/dn = -i omega rho v_n
  const Eigen::VectorXd root_weights = field.weights_m2.cwiseSqrt();

  Eigen::MatrixXcd system(n_points + n_columns, n_columns);
  system.topRows(n_points) = root_weights.asDiagonal() * table.slopes;
  const Eigen::VectorXd lengths = system.topRows(n_points).colwise().norm().transpose();
  if (!lengths.allFinite() || !(lengths.minCoeff() > 0.0)) {
    result.status = EquivalentSources::Status::kNumericalFailure;
    result.message = "a source function is not finite on the surface";
    return result;
  }
  system.topRows(n_points) *= lengths.cwiseInverse().asDiagonal();
  system.bottomRows(n_columns) = options.regularisation * Eigen::MatrixXcd::Identity(n_columns, n_columns);
  Eigen::VectorXcd data = Eigen::VectorXcd::Zero(n_points + n_columns);
  data.head(n_points) = by_velocity * root_weights.cwiseProduct(field.normal_velocity_m_s);
  const double data_norm = data.norm();
  // The regularised system has full rank: no pivoting, so that Eigen works in blocks.
  Eigen::VectorXcd solution = system.householderQr().solve(data);
  solution = solution.cwiseQuotient(lengths.cast<Complex>());
  if (!solution.allFinite()) {
    result.status = EquivalentSources::Status::kNumericalFailure;
    result.message = "the least-squares fit is not finite";
    return result;
  }
  const Eigen::Index n_each = basis_size(options.order);
  for (std::size_t s = 0; s < points_m.size(); ++s) {
    result.sources.push_back(
        {points_m[s], k, options.order, solution.segment(static_cast<Eigen::Index>(s) * n_each, n_each)});
  }

  const Eigen::VectorXcd slope_error = root_weights.cwiseProduct(table.slopes * solution) - data.head(n_points);
  result.velocity_residual = data_norm > 0.0 ? slope_error.norm() / data_norm : 0.0;
  // The far field of sources within the radius a is band-limited near k a + order.
  double extent = 0.0;
  for (const Eigen::Vector3d& x : points_m) extent = std::max(extent, (x - points_m[0]).norm());
  const double radius = (field.points_m.colwise() - points_m[0]).colwise().norm().maxCoeff();
  const double ka = k * std::max(radius, extent);
  const int band = static_cast<int>(std::ceil(ka + 6.0 * std::cbrt(ka) + 6.0)) + options.order;
  const SphereQuadrature rule = sphere_quadrature(2 * band);
  Eigen::VectorXcd far(rule.weights.size());
  for (Eigen::Index i = 0; i < far.size(); ++i) far[i] = far_field_pa_m(result.sources, rule.directions.col(i));
  result.radiated_power_w = rule.weights.dot(far.cwiseAbs2()) / (2.0 * medium.density_kg_m3 * medium.sound_speed_m_s);
  if (field.pressure_pa.size() == n_points) {
    const Eigen::VectorXcd error = root_weights.cwiseProduct(table.values * solution - field.pressure_pa);
    const double scale = root_weights.cwiseProduct(field.pressure_pa).norm();
    if (scale > 0.0) result.pressure_residual = error.norm() / scale;
    const double power = surface_power_w(field);
    if (power > 0.0) result.lost_power_fraction = 1.0 - result.radiated_power_w / power;
    const std::vector<Multipole> whole = {
        {points_m[0], k, band, multipole_coefficients(field, k, medium, points_m[0], band)}};
    Eigen::VectorXcd reference(far.size());
    for (Eigen::Index i = 0; i < far.size(); ++i) reference[i] = far_field_pa_m(whole, rule.directions.col(i));
    const double size = rule.weights.dot(reference.cwiseAbs2());
    if (size > 0.0) result.far_field_error = std::sqrt(rule.weights.dot((far - reference).cwiseAbs2()) / size);
  }
  result.status = EquivalentSources::Status::kDone;
  return result;
}

std::vector<Eigen::Vector3d> inner_points(const SurfaceField& field, int count) {
  checked("equivalent sources", "points", count, 1, 1000);
  const Eigen::Index n_points = field.points_m.cols();
  const Eigen::Vector3d middle = field.points_m.rowwise().mean();
  const double extent = (field.points_m.colwise() - middle).colwise().norm().maxCoeff();
  std::vector<Eigen::Vector3d> candidates{middle};
  const Eigen::Index step = std::max<Eigen::Index>(1, n_points / 100);
  for (Eigen::Index i = 0; i < n_points; i += step) {
    for (const double depth : {0.8, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02}) {
      candidates.push_back(field.points_m.col(i) - depth * extent * field.normals.col(i));
    }
  }
  std::vector<double> depths(candidates.size());  // 0: outside
  parallel_for(candidates.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      // The quadrature is rough close to the surface; there the number is no sign of anything.
      const bool inside = std::abs(winding_number(field, candidates[i]) - 1.0) < 0.1;
      depths[i] = inside ? distance_to(field, candidates[i]) : 0.0;
    }
  });
  std::vector<Eigen::Vector3d> chosen;
  std::vector<double> apart(candidates.size(), 2.0 * extent);
  while (static_cast<int>(chosen.size()) < count) {
    std::size_t best = 0;
    double best_score = 0.0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double score = std::min(depths[i], apart[i]) + 1e-3 * depths[i] * (apart[i] > 0.0);
      if (score > best_score * (1.0 + 1e-12)) {
        best_score = score;
        best = i;
      }
    }
    if (!(best_score > 0.0) || !(apart[best] > 0.0)) break;
    chosen.push_back(candidates[best]);
    for (std::size_t i = 0; i < candidates.size(); ++i)
      apart[i] = std::min(apart[i], (candidates[i] - candidates[best]).norm());
  }
  if (chosen.empty())
    throw InputError("equivalent sources", "no point inside the body was found", {},
                     "a closed surface with outward normals");
  return chosen;
}

Complex pressure_pa(const std::vector<Multipole>& sources, const Eigen::Vector3d& x_m) {
  Complex sum = 0.0;
  for (const Multipole& source : sources) sum += pressure_pa(source, x_m);
  return sum;
}

Complex far_field_pa_m(const std::vector<Multipole>& sources, const Eigen::Vector3d& direction) {
  Complex sum = 0.0;
  for (const Multipole& source : sources) {
    sum +=
        std::polar(1.0, source.wavenumber_per_m * direction.dot(source.centre_m)) * far_field_pa_m(source, direction);
  }
  return sum;
}

}  // namespace klang::acoustics
