#include "core/sound/dual_domain/dual_domain.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/la/ridge.hpp"
#include "core/sound/dual_domain/detail/conditions.hpp"
#include "core/sound/dual_domain/detail/liquid_solver.hpp"
#include "core/sound/dual_domain/detail/slope_kernel.hpp"
#include "core/sound/dual_domain/detail/wave_rows.hpp"

namespace klang::bubble {
namespace {

using Complex = std::complex<double>;
using detail::Conditions;
using Eigen::Index;
using Eigen::Vector3d;
using la::Matrix;

void fail(std::vector<DualDomainResult>& results, const std::string& message) {
  for (DualDomainResult& r : results) {
    r.status = DualDomainResult::Status::kFailed;
    r.message = message;
  }
}

/// One call of solve_dual_domain(): the liquid with the bubbles, the surface's motion, the air that it moves.
class TwoPasses {
 public:
  TwoPasses(const LiquidBoundary& boundary, double frequency_hz, const SourcePoints& points,
            const DualDomainOptions& options, Monitor& monitor);
  std::vector<DualDomainResult> solve(const std::vector<SwingingBubble>& bubbles);

 private:
  DualDomainResult unsolved(const SwingingBubble& bubble) const;
  /// What the bubble (with its images) asks of the liquid's functions.
  void liquid_data(const FluidField& field, Index column, Eigen::MatrixXcd& data) const;
  /// The passes; false: results say why it failed.
  bool solve_liquid(const Eigen::MatrixXcd& data, std::vector<DualDomainResult>& results);
  bool solve_air(std::vector<DualDomainResult>& results);
  /// Square of the bubble's own conditions without images, so that errors with and without compare.
  double alone_sq(const Vector3d& bubble_m) const;
  /// The surface's motion, for a unit source.
  void surface_motion(std::vector<DualDomainResult>& results) const;
  Conditions<Complex> air_conditions(const Eigen::VectorXd& weights) const;  // of the samples
  void finish_air(const Conditions<Complex>& conditions, const la::RidgeSolution<Complex>& solution,
                  const Matrix<Complex>& data, std::vector<DualDomainResult>& results);

  const LiquidBoundary& boundary_;
  const std::vector<BoundarySample>& samples_;
  const double frequency_hz_;
  const SourcePoints& points_;
  const DualDomainOptions& options_;
  Monitor& monitor_;
  const Stopwatch total_;
  Stopwatch lap_;
  std::map<std::string, double> times_;
  const bool paper_;
  const double ka_;
  const detail::LiquidSolver liquid_;
  const Index n_air_, n_samples_;
};

TwoPasses::TwoPasses(const LiquidBoundary& boundary, double frequency_hz, const SourcePoints& points,
                     const DualDomainOptions& options, Monitor& monitor)
    : boundary_(boundary),
      samples_(boundary.samples()),
      frequency_hz_(frequency_hz),
      points_(points),
      options_(options),
      monitor_(monitor),
      paper_(options.literature == Literature::kPaper),
      ka_(options.air.wavenumber_per_m(frequency_hz)),
      liquid_(boundary, frequency_hz, points, options),
      n_air_(detail::kQuadrupoleSize * static_cast<Index>(points.air_m.size())),
      n_samples_(static_cast<Index>(samples_.size())) {}

std::vector<DualDomainResult> TwoPasses::solve(const std::vector<SwingingBubble>& bubbles) {
  std::vector<DualDomainResult> results;
  Eigen::MatrixXcd data(n_samples_, static_cast<Index>(bubbles.size()));
  for (std::size_t b = 0; b < bubbles.size(); ++b) {
    results.push_back(unsolved(bubbles[b]));
    if (options_.images) detail::add_images(boundary_, results[b].fluid);
    liquid_data(results[b].fluid, static_cast<Index>(b), data);
  }
  lap_.restart();
  monitor_.throw_if_stopped();
  monitor_.progress("liquid", 0.0);
  if (!solve_liquid(data, results)) return results;
  monitor_.throw_if_stopped();
  monitor_.progress("air", 0.4);
  lap_.restart();
  surface_motion(results);
  if (!solve_air(results)) return results;
  monitor_.progress("air", 1.0);
  return results;
}

DualDomainResult TwoPasses::unsolved(const SwingingBubble& bubble) const {
  DualDomainResult r;
  r.frequency_hz = frequency_hz_;
  r.source_strength =
      (paper_ ? -1.0 : 1.0) * bubble_source_strength(bubble.radius_m, frequency_hz_, options_.liquid.density_kg_m3);
  r.alpha_m = liquid_.alpha_m();
  r.fluid.wavenumber_per_m = liquid_.wavenumber_per_m();
  r.fluid.bubble_m = bubble.position_m;
  r.fluid.order = liquid_.order();
  r.fluid.points_m = liquid_.points_m();
  r.fluid.solid_m = points_.solid_m;
  r.air.wavenumber_per_m = ka_;
  r.air.points_m = points_.air_m;
  r.n_fluid_sources = static_cast<int>(points_.fluid_m.size());
  r.n_air_sources = static_cast<int>(points_.air_m.size());
  r.n_fluid_unknowns = static_cast<int>(liquid_.functions().size());
  r.n_air_unknowns = static_cast<int>(n_air_);
  return r;
}

void TwoPasses::liquid_data(const FluidField& field, Index column, Eigen::MatrixXcd& data) const {
  const Eigen::VectorXd& weights = liquid_.weights();
  parallel_for(samples_.size(), detail::kSamplesPerRange, [&](std::size_t begin, std::size_t end) {
    for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i) {
      const BoundarySample& s = samples_[static_cast<std::size_t>(i)];
      const bool free = s.region == BoundaryRegion::kFreeSurface;
      Complex value = weights[i] == 0.0 ? 0.0 : liquid_.incident_condition(field, s);
      if (free && options_.surface_pressure.size() != 0) value -= options_.surface_pressure[i];
      data(i, column) = -weights[i] * value;
    }
  });
}

double TwoPasses::alone_sq(const Vector3d& bubble_m) const {
  const Eigen::VectorXd& weights = liquid_.weights();
  const Complex k = liquid_.wavenumber_per_m();
  double alone = 0.0;
  for (Index i = 0; i < n_samples_; ++i) {
    if (weights[i] == 0.0) continue;
    const BoundarySample& s = samples_[static_cast<std::size_t>(i)];
    const Vector3d x = s.point_m - bubble_m;
    alone += weights[i] * weights[i] *
             std::norm(s.region == BoundaryRegion::kFreeSurface ? detail::monopole(k, x)
                                                                : detail::monopole_slope(k, x, s.normal));
  }
  return alone;
}

bool TwoPasses::solve_liquid(const Eigen::MatrixXcd& data, std::vector<DualDomainResult>& results) {
  const detail::LiquidSolver::Solution solution = liquid_.solve(data);
  times_["assemble_fluid"] = solution.assemble_s;
  times_["solve_fluid"] = solution.solve_s;
  if (!solution.solved) {
    fail(results, "pass 1: " + solution.message);
    return false;
  }
  for (std::size_t b = 0; b < results.size(); ++b) {
    DualDomainResult& r = results[b];
    const auto c = static_cast<Index>(b);
    const double alone = alone_sq(r.fluid.bubble_m), fit_sq = solution.error.col(c).squaredNorm();
    r.fit_error_fluid = std::sqrt(fit_sq / alone);
    r.fluid_residual = std::sqrt((fit_sq + solution.ridge_sq[c]) / alone);
    r.n_fluid_steps = solution.n_iterations;
    r.fluid.coefficients = solution.coefficients.col(c);
  }
  return true;
}

void TwoPasses::surface_motion(std::vector<DualDomainResult>& results) const {
  Eigen::MatrixXcd coefficients(liquid_.functions().size(), static_cast<Index>(results.size()));
  for (std::size_t b = 0; b < results.size(); ++b) {
    results[b].normal_derivative.setZero(n_samples_);
    coefficients.col(static_cast<Index>(b)) = results[b].fluid.coefficients;
  }
  parallel_for(samples_.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const BoundarySample& s = samples_[i];
      if (s.region == BoundaryRegion::kDrySolid || (s.region != BoundaryRegion::kFreeSurface && !options_.wall_slopes))
        continue;
      if (!liquid_.counts(static_cast<Index>(i))) continue;  // what the functions do there means nothing
      const Eigen::VectorXcd slopes = liquid_.at_sample(s, true, coefficients);
      for (std::size_t b = 0; b < results.size(); ++b)
        results[b].normal_derivative[static_cast<Index>(i)] =
            detail::incident(results[b].fluid, s.point_m, &s.normal) + slopes[static_cast<Index>(b)];
    }
  });
}

Conditions<Complex> TwoPasses::air_conditions(const Eigen::VectorXd& weights) const {
  const std::size_t n_sources = points_.air_m.size(),
                    n_padded = (n_sources + detail::kLane - 1) / detail::kLane * detail::kLane;
  std::vector<double> sources(3 * n_padded);
  for (std::size_t i = 0; i < n_padded; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      sources[axis * n_padded + i] = points_.air_m[std::min(i, n_sources - 1)][static_cast<Index>(axis)];
  return detail::assemble<Complex>(
      n_air_, n_samples_, options_.scale_columns,
      [&](Index begin, Index end, Matrix<Complex>& adjoint, Eigen::VectorXd& squares) {
        std::vector<double> r(n_padded), phase(n_padded), cosine(n_padded), sine(n_padded), padded(9 * n_padded, 0.0);
        for (Index i = begin; i < end; ++i) {
          const BoundarySample& s = samples_[static_cast<std::size_t>(i)];
          detail::distances(sources.data(), n_padded, ka_, s.point_m.data(), r.data(), phase.data());
          for (std::size_t j = 0; j < n_padded; ++j) {
            cosine[j] = std::cos(phase[j]);
            sine[j] = std::sin(phase[j]);
          }
          detail::singular_slopes(sources.data(), n_sources, n_padded, ka_, s.point_m.data(), s.normal.data(), r.data(),
                                  cosine.data(), sine.data(), weights[i],
                                  reinterpret_cast<double*>(adjoint.col(i).data()), padded.data());
        }
        for (std::size_t f = 0; f < 9; ++f)
          for (std::size_t j = 0; j < n_sources; ++j)
            squares[static_cast<Index>(f * n_sources + j)] = padded[f * n_padded + j];
      });
}

bool TwoPasses::solve_air(std::vector<DualDomainResult>& results) {
  Matrix<Complex> data = Matrix<Complex>::Zero(n_samples_, static_cast<Index>(results.size()));
  Eigen::VectorXd weights(n_samples_);
  for (Index i = 0; i < n_samples_; ++i) {
    const BoundarySample& s = samples_[static_cast<std::size_t>(i)];
    weights[i] = s.region == BoundaryRegion::kWetSolid ? 0.0 : std::sqrt(s.area_m2);
    if (s.region != BoundaryRegion::kFreeSurface) continue;
    for (std::size_t b = 0; b < results.size(); ++b)
      data(i, static_cast<Index>(b)) = weights[i] * results[b].normal_derivative[i];
  }
  const Conditions<Complex> a = air_conditions(weights);
  times_["assemble_air"] = lap_.seconds();
  lap_.restart();
  const la::RidgeSolution<Complex> solution =
      la::solve_ridge(a.adjoint, a.column_scale, data, options_.ridge * a.frobenius, detail::method(options_.solver));
  if (!solution.solved) {
    fail(results, "pass 2: " + solution.message);
    return false;
  }
  finish_air(a, solution, data, results);
  return true;
}

void TwoPasses::finish_air(const Conditions<Complex>& a, const la::RidgeSolution<Complex>& solution,
                           const Matrix<Complex>& data, std::vector<DualDomainResult>& results) {
  const Matrix<Complex> error = la::times(a.adjoint, Matrix<Complex>(a.column_scale.asDiagonal() * solution.x)) - data;
  times_["solve_air"] = lap_.seconds();
  times_["total"] = total_.seconds();
  const double eps = options_.ridge * a.frobenius;
  const double ratio = paper_ ? 1.0 : options_.air.density_kg_m3 / options_.liquid.density_kg_m3;
  const std::size_t n_sources = points_.air_m.size();
  for (std::size_t b = 0; b < results.size(); ++b) {
    DualDomainResult& r = results[b];
    const auto c = static_cast<Index>(b);
    const double scale_sq = data.col(c).squaredNorm(), fit_sq = error.col(c).squaredNorm();
    r.fit_error_air = std::sqrt(fit_sq / scale_sq);
    r.air_residual = std::sqrt((fit_sq + eps * eps * solution.x.col(c).squaredNorm()) / scale_sq);
    r.n_air_steps = solution.n_iterations;
    r.air.coefficients.resize(n_air_);
    for (std::size_t j = 0; j < n_sources; ++j)
      for (std::size_t f = 0; f < 9; ++f) {
        const auto from = static_cast<Index>(f * n_sources + j);
        r.air.coefficients[static_cast<Index>(9 * j + f)] =
            ratio * r.source_strength * a.column_scale[from] * solution.x(from, c);
      }
    r.normal_derivative *= r.source_strength;
    r.wall_time_s = times_;
    const bool finite = r.air.coefficients.allFinite() && r.normal_derivative.allFinite();
    r.status = finite ? DualDomainResult::Status::kSolved : DualDomainResult::Status::kFailed;
    if (!finite) r.message = "the solution is not finite";
  }
}

}  // namespace

void DualDomainOptions::validate() const { validate_fields("dual domain", *this); }

Complex DualDomainOptions::liquid_wavenumber_per_m(double frequency_hz) const {
  const double k = liquid.wavenumber_per_m(frequency_hz);
  return liquid_loss_factor == 0.0 ? Complex(k) : k * std::sqrt(Complex(1.0, -liquid_loss_factor));
}

DualDomainOptions DualDomainOptions::as_printed() {
  DualDomainOptions options;
  options.fluid_space = FluidSpace::kSources;
  options.literature = Literature::kPaper;
  options.scale_columns = false;
  options.images = false;
  return options;
}

double bubble_source_strength(double radius_m, double frequency_hz, double liquid_density_kg_m3) {
  const double omega = 2.0 * kPi * frequency_hz;
  return 4.0 * kPi * liquid_density_kg_m3 * omega * omega * radius_m * radius_m;
}

std::vector<DualDomainResult> solve_dual_domain(const LiquidBoundary& boundary, double frequency_hz,
                                                const SourcePoints& given_points,
                                                const std::vector<SwingingBubble>& bubbles,
                                                const DualDomainOptions& options, Monitor& monitor) {
  options.validate();
  checked("dual domain", "frequency_hz", frequency_hz, 1.0, 1e5);
  if (bubbles.empty()) return {};
  if (given_points.fluid_m.empty() || given_points.air_m.empty())
    throw InputError("dual domain", "needs sources in both passes");
  const SourcePoints points = detail::supported_points(boundary, given_points, options.literature);
  for (const SwingingBubble& bubble : bubbles) {
    checked("bubble", "radius_m", bubble.radius_m, 1e-6, 0.1);
    boundary.check_bubble(bubble.position_m, 0.1 * bubble.radius_m);
  }
  KLANG_CHECK(options.surface_pressure.size() == 0 ||
                  options.surface_pressure.size() == static_cast<Index>(boundary.samples().size()),
              "a surface pressure has one value per sample");
  return TwoPasses(boundary, frequency_hz, points, options, monitor).solve(bubbles);
}

namespace {

Complex liquid_at(const DualDomainResult& result, const Vector3d& x, const Vector3d* direction) {
  const detail::FluidFunctions functions(result.fluid.wavenumber_per_m, result.fluid.order, result.fluid.points_m,
                                         result.fluid.solid_m);
  auto scratch = functions.scratch();
  Eigen::VectorXcd row(functions.size());
  functions.row(x, direction, scratch, row.data());
  return result.source_strength *
         (detail::incident(result.fluid, x, direction) + row.cwiseProduct(result.fluid.coefficients).sum());
}

Complex air_at(const DualDomainResult& result, const Vector3d& x, const Vector3d* direction) {
  Complex sum = 0.0, row[detail::kQuadrupoleSize];
  for (std::size_t s = 0; s < result.air.points_m.size(); ++s) {
    const Vector3d r = x - result.air.points_m[s];
    if (direction == nullptr) {
      detail::singular_quadrupole(result.air.wavenumber_per_m, r, row);
    } else {
      detail::singular_quadrupole_slopes(result.air.wavenumber_per_m, r, *direction, row);
    }
    for (int j = 0; j < detail::kQuadrupoleSize; ++j)
      sum += row[j] * result.air.coefficients[detail::kQuadrupoleSize * static_cast<Index>(s) + j];
  }
  return sum;
}

}  // namespace

Complex liquid_pressure(const DualDomainResult& result, const Vector3d& x_m) { return liquid_at(result, x_m, nullptr); }
Complex liquid_pressure_slope(const DualDomainResult& result, const Vector3d& x_m, const Vector3d& direction) {
  return liquid_at(result, x_m, &direction);
}
Complex air_pressure(const DualDomainResult& result, const Vector3d& x_m) { return air_at(result, x_m, nullptr); }
Complex air_pressure_slope(const DualDomainResult& result, const Vector3d& x_m, const Vector3d& direction) {
  return air_at(result, x_m, &direction);
}

}  // namespace klang::bubble
