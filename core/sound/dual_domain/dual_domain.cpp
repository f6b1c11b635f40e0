#include "core/sound/dual_domain/dual_domain.hpp"

#include <chrono>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/memory.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/dual_domain/detail/ridge.hpp"
#include "core/sound/dual_domain/detail/row_kernel.hpp"
#include "core/sound/dual_domain/detail/wave_rows.hpp"

namespace klang::bubble {
namespace {

using Complex = std::complex<double>;
using detail::Matrix;
using Eigen::Index;
using Eigen::Vector3d;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kSamplesPerRange = 256;
// With fewer, least squares fits the samples and swings between them.
constexpr std::size_t kSamplesPerFluidUnknown = 2, kSamplesPerAirUnknown = 3;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A matrix of boundary conditions, its rows weighted, and the scale of its columns.
template <class Scalar>
struct Conditions {
  Matrix<Scalar> adjoint;        // n_unknowns (padded) x n_samples
  Eigen::VectorXd column_scale;  // coefficients = scale * solution
  double frobenius = 0.0;        // of the scaled matrix
};

/// fill(begin, end, adjoint, squares) writes the weighted, conjugated rows of samples and adds up the squares of the columns.
template <class Scalar, class Fill>
Conditions<Scalar> assemble(Index n_unknowns, Index n_samples, bool scale_columns, const Fill& fill) {
  Conditions<Scalar> result;
  constexpr Index kMultiple = detail::kMultiple<Scalar>;
  result.adjoint.resize((n_unknowns + kMultiple - 1) / kMultiple * kMultiple, n_samples);
  prefer_huge_pages(result.adjoint.data(), static_cast<std::size_t>(result.adjoint.size()) * sizeof(Scalar));
  std::vector<Eigen::VectorXd> squares((static_cast<std::size_t>(n_samples) + kSamplesPerRange - 1) / kSamplesPerRange);
  parallel_for(static_cast<std::size_t>(n_samples), kSamplesPerRange, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Index>(begin), last = static_cast<Index>(end);
    result.adjoint.middleCols(first, last - first).bottomRows(result.adjoint.rows() - n_unknowns).setZero();
    squares[begin / kSamplesPerRange].setZero(result.adjoint.rows());
    fill(first, last, result.adjoint, squares[begin / kSamplesPerRange]);
  });
  Eigen::VectorXd square = squares[0];
  for (std::size_t r = 1; r < squares.size(); ++r) square += squares[r];
  result.column_scale = Eigen::VectorXd::Ones(square.size());
  if (scale_columns) {
    for (Index j = 0; j < square.size();
         ++j)  // a high order that underflows on the whole boundary counts as no function
      result.column_scale[j] = square[j] > 1e-280 ? 1.0 / std::sqrt(square[j]) : 0.0;
    square.array() *= result.column_scale.array().square();
  }
  result.frobenius = std::sqrt(square.sum());
  return result;
}

void fail(std::vector<DualDomainResult>& results, const std::string& message) {
  for (DualDomainResult& r : results) {
    r.status = DualDomainResult::Status::kFailed;
    r.message = message;
  }
}

detail::RidgeMethod method(LeastSquares solver) {
  return solver == LeastSquares::kDirect ? detail::RidgeMethod::kDirect : detail::RidgeMethod::kSketch;
}

/// Functions of pass 1 at a sample or point: value, or derivative along normal where it is given.
class FluidFunctions {
 public:
  FluidFunctions(double k, int order, const std::vector<Vector3d>& points, const std::vector<Vector3d>& solid)
      : k_(k), points_(points), solid_(solid) {
    if (order >= 0) rows_.emplace(order, k);
  }
  Index size() const { return n_regular() + detail::kQuadrupoleSize * static_cast<Index>(solid_.size()); }
  std::optional<detail::RegularRows::Scratch> scratch() const {
    return rows_ ? std::optional(rows_->scratch()) : std::nullopt;
  }
  void row(const Vector3d& x, const Vector3d* normal, std::optional<detail::RegularRows::Scratch>& scratch,
           double* out) const {
    regular_row(x, normal, scratch, out);
    out += n_regular();
    std::array<Complex, detail::kQuadrupoleSize> wave;
    for (const Vector3d& point : solid_) {
      if (normal == nullptr) {
        detail::singular_quadrupole(k_, x - point, wave.data());
      } else {
        detail::singular_quadrupole_slopes(k_, x - point, *normal, wave.data());
      }
      for (const Complex& value : wave) *out++ = -value.imag();  // h^(2) = j - i y
    }
  }

 private:
  Index n_regular() const {
    return rows_ ? rows_->size() : detail::kQuadrupoleSize * static_cast<Index>(points_.size());
  }
  void regular_row(const Vector3d& x, const Vector3d* normal, std::optional<detail::RegularRows::Scratch>& scratch,
                   double* out) const {
    if (rows_) {
      if (normal == nullptr) {
        rows_->values(x - points_[0], *scratch, out);
      } else {
        rows_->slopes(x - points_[0], *normal, *scratch, out);
      }
      return;
    }
    for (std::size_t s = 0; s < points_.size(); ++s, out += detail::kQuadrupoleSize) {
      if (normal == nullptr) {
        detail::regular_quadrupole(k_, x - points_[s], out);
      } else {
        detail::regular_quadrupole_slopes(k_, x - points_[s], *normal, out);
      }
    }
  }

  double k_;
  const std::vector<Vector3d>& points_;
  const std::vector<Vector3d>& solid_;
  std::optional<detail::RegularRows> rows_;
};

/// Bubble and images: value, or derivative along normal.
Complex incident(const FluidField& field, const Vector3d& x, const Vector3d* normal) {
  const auto one = [&](const Vector3d& at) {
    return normal == nullptr ? detail::monopole(field.wavenumber_per_m, x - at)
                             : detail::monopole_slope(field.wavenumber_per_m, x - at, *normal);
  };
  Complex sum = one(field.bubble_m);
  for (const FluidField::Image& image : field.images) sum += image.amplitude * one(image.position_m);
  return sum;
}

/// Image in the nearest point of a region. Before a plane it is the mirror image, of a pressure-release ball of radius A the
/// exact static one: with the distance d, at A d / (A - d) behind the surface, amplitude A / (A - d). The curvature is that of
/// samples up to 2 d around (walls: plane). It fades out between a quarter and half of the radius of the liquid, and is left out
/// where it would stand in the liquid (a crown, a dimple).
std::optional<FluidField::Image> image_of(const LiquidBoundary& boundary, const Vector3d& x, bool free_surface) {
  const std::optional<Vector3d> nearest = boundary.nearest_point_m(x, free_surface);
  if (!nearest) return std::nullopt;
  const double distance = (*nearest - x).norm(), full = 0.25 * boundary.radius_m();
  const double fade = std::clamp((2.0 * full - distance) / full, 0.0, 1.0);
  if (!(fade > 0.0) || !(distance > 0.0)) return std::nullopt;
  const Vector3d out = (*nearest - x) / distance;
  double above = 0.0, weight = 0.0;  // height = curvature / 2 rho^2 by least squares
  if (free_surface) {
    for (const BoundarySample& s : boundary.samples()) {
      const Vector3d r = s.point_m - *nearest;
      const double near = 1.0 - r.squaredNorm() / (4.0 * distance * distance);
      if (s.region != BoundaryRegion::kFreeSurface || near <= 0.0 || s.normal.dot(out) < 0.3) continue;
      const double height = r.dot(out), rho_sq = r.squaredNorm() - height * height, w = near * near * s.area_m2;
      above += w * rho_sq * height;
      weight += 0.5 * w * rho_sq * rho_sq;
    }
  }
  const double curvature = weight > 0.0 ? std::clamp(above / weight, -0.8 / distance, 2.0 / distance) : 0.0;
  const double stretch = 1.0 / (1.0 + distance * curvature);
  const Vector3d at = *nearest + stretch * distance * out;
  if (boundary.inside_liquid(at) || boundary.distance_m(at) < 0.5 * distance * stretch) return std::nullopt;
  return FluidField::Image{at, free_surface ? -fade * stretch : fade};
}

/// Images in free surface and rigid surface, and the image of the one in the other.
void add_images(const LiquidBoundary& boundary, FluidField& field) {
  const auto free = image_of(boundary, field.bubble_m, true), rigid = image_of(boundary, field.bubble_m, false);
  if (free) field.images.push_back(*free);
  if (!rigid) return;
  field.images.push_back(*rigid);
  if (!free) return;
  const Vector3d across = (rigid->position_m - field.bubble_m).normalized();
  const Vector3d wall = 0.5 * (rigid->position_m + field.bubble_m);
  const Vector3d both = free->position_m - 2.0 * across.dot(free->position_m - wall) * across;
  if (!boundary.inside_liquid(both) && boundary.distance_m(both) > 0.5 * (wall - field.bubble_m).norm())
    field.images.push_back({both, free->amplitude * rigid->amplitude});
}

}  // namespace

void DualDomainOptions::validate() const { validate_fields("dual domain", *this); }

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
                                                const std::vector<Vector3d>& bubbles_m,
                                                const std::vector<double>& radius_m, const DualDomainOptions& options,
                                                Monitor& monitor) {
  options.validate();
  checked("dual domain", "frequency_hz", frequency_hz, 1.0, 1e5);
  KLANG_CHECK(bubbles_m.size() == radius_m.size(), "a bubble has a radius");
  if (bubbles_m.empty()) return {};
  if (given_points.fluid_m.empty() || given_points.air_m.empty())
    throw InputError("dual domain", "needs sources in both passes");
  SourcePoints points = given_points;
  for (const auto& [list, per_unknown] :
       {std::pair(&points.fluid_m, kSamplesPerFluidUnknown), std::pair(&points.air_m, kSamplesPerAirUnknown)}) {
    const std::size_t enough = boundary.samples().size() / (detail::kQuadrupoleSize * per_unknown);
    if (enough == 0)
      throw InputError(boundary.name(), "too few samples of the boundary", std::to_string(boundary.samples().size()),
                       std::to_string(detail::kQuadrupoleSize * per_unknown) + " or more");
    list->resize(std::min(list->size(), enough));
  }
  for (std::size_t b = 0; b < bubbles_m.size(); ++b) {
    checked("bubble", "radius_m", radius_m[b], 1e-6, 0.1);
    boundary.check_bubble(bubbles_m[b], 0.1 * radius_m[b]);
  }
  const auto start = Clock::now();
  const std::vector<BoundarySample>& samples = boundary.samples();
  KLANG_CHECK(
      options.surface_pressure.size() == 0 || options.surface_pressure.size() == static_cast<Index>(samples.size()),
      "a surface pressure has one value per sample");
  const auto n_samples = static_cast<Index>(samples.size()), n_bubbles = static_cast<Index>(bubbles_m.size());
  const bool paper = options.literature == Literature::kPaper;
  const double kf = options.liquid.wavenumber_per_m(frequency_hz), ka = options.air.wavenumber_per_m(frequency_hz);

  // Pass 1.
  const bool flat = options.fluid_space == FluidSpace::kFlatLimit;
  const int order =
      flat ? static_cast<int>(3.0 * std::sqrt(static_cast<double>(points.fluid_m.size())) + 1e-9) - 1 : -1;
  const std::vector<Vector3d> fluid_points = flat ? std::vector{boundary.centre_m()} : points.fluid_m;
  if (paper) points.solid_m.clear();
  points.solid_m.resize(std::min(points.solid_m.size(),
                                 boundary.samples().size() / (2 * detail::kQuadrupoleSize * kSamplesPerFluidUnknown)));
  const FluidFunctions functions(kf, order, fluid_points, points.solid_m);
  const Index n_air = detail::kQuadrupoleSize * static_cast<Index>(points.air_m.size());
  const double length = paper
                            ? 1.0
                            : options.wall_length_m.value_or(
                                  boundary.radius_m() / (3.0 * std::sqrt(static_cast<double>(points.fluid_m.size()))));
  const double alpha =
      boundary.rigid_area_m2() > 0.0 ? length * boundary.rigid_area_m2() / boundary.free_area_m2() : 1.0;
  Eigen::VectorXd weights(n_samples);
  for (Index i = 0; i < n_samples; ++i) {
    const BoundarySample& s = samples[static_cast<std::size_t>(i)];
    weights[i] = std::sqrt(s.area_m2) * (s.region == BoundaryRegion::kFreeSurface ? 1.0
                                         : s.region == BoundaryRegion::kDrySolid  ? 0.0
                                                                                  : alpha);
  }
  std::vector<DualDomainResult> results(bubbles_m.size());
  Matrix<double> data(n_samples, 2 * n_bubbles);
  for (std::size_t b = 0; b < results.size(); ++b) {
    DualDomainResult& r = results[b];
    r.frequency_hz = frequency_hz;
    r.source_strength =
        (paper ? -1.0 : 1.0) * bubble_source_strength(radius_m[b], frequency_hz, options.liquid.density_kg_m3);
    r.alpha_m = alpha;
    r.fluid.wavenumber_per_m = kf;
    r.fluid.bubble_m = bubbles_m[b];
    r.fluid.order = order;
    r.fluid.points_m = fluid_points;
    r.fluid.solid_m = points.solid_m;
    r.air.wavenumber_per_m = ka;
    r.air.points_m = points.air_m;
    r.n_fluid_sources = static_cast<int>(points.fluid_m.size());
    r.n_air_sources = static_cast<int>(points.air_m.size());
    r.n_fluid_unknowns = static_cast<int>(functions.size());
    r.n_air_unknowns = static_cast<int>(n_air);
    if (options.images) add_images(boundary, r.fluid);
    parallel_for(samples.size(), kSamplesPerRange, [&](std::size_t begin, std::size_t end) {
      for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i) {
        const BoundarySample& s = samples[static_cast<std::size_t>(i)];
        Complex value = weights[i] == 0.0 ? 0.0
                                          : incident(r.fluid, s.point_m,
                                                     s.region == BoundaryRegion::kFreeSurface ? nullptr : &s.normal);
        if (s.region == BoundaryRegion::kFreeSurface && options.surface_pressure.size() != 0)
          value -= options.surface_pressure[i];
        data(i, 2 * static_cast<Index>(b)) = -weights[i] * value.real();
        data(i, 2 * static_cast<Index>(b) + 1) = -weights[i] * value.imag();
      }
    });
  }
  auto lap = Clock::now();
  std::map<std::string, double> times;
  monitor.throw_if_stopped();
  monitor.progress("liquid", 0.0);
  {
    const Conditions<double> a =
        assemble<double>(functions.size(), n_samples, options.scale_columns,
                         [&](Index begin, Index end, Matrix<double>& adjoint, Eigen::VectorXd& squares) {
                           auto scratch = functions.scratch();
                           for (Index i = begin; i < end; ++i) {
                             const BoundarySample& s = samples[static_cast<std::size_t>(i)];
                             if (s.region == BoundaryRegion::kDrySolid) {
                               adjoint.col(i).setZero();
                             } else {
                               functions.row(s.point_m, s.region == BoundaryRegion::kFreeSurface ? nullptr : &s.normal,
                                             scratch, adjoint.col(i).data());
                               adjoint.col(i) *= weights[i];
                               squares += adjoint.col(i).cwiseAbs2();
                             }
                           }
                         });
    times["assemble_fluid"] = seconds_since(lap);
    lap = Clock::now();
    const double eps = options.ridge * a.frobenius;
    const detail::RidgeSolution<double> solution =
        detail::solve_ridge(a.adjoint, a.column_scale, data, eps, method(options.solver));
    if (!solution.solved) {
      fail(results, "pass 1: " + solution.message);
      return results;
    }
    const Matrix<double> error =
        detail::times(a.adjoint, Matrix<double>(a.column_scale.asDiagonal() * solution.x)) - data;
    for (std::size_t b = 0; b < results.size(); ++b) {
      DualDomainResult& r = results[b];
      const auto c = 2 * static_cast<Index>(b);
      double alone = 0.0;  // the bubble without its image, so that errors with and without compare
      for (Index i = 0; i < n_samples; ++i) {
        if (weights[i] == 0.0) continue;
        const BoundarySample& s = samples[static_cast<std::size_t>(i)];
        const Vector3d x = s.point_m - r.fluid.bubble_m;
        alone += weights[i] * weights[i] *
                 std::norm(s.region == BoundaryRegion::kFreeSurface ? detail::monopole(kf, x)
                                                                    : detail::monopole_slope(kf, x, s.normal));
      }
      const double fit_sq = error.middleCols(c, 2).squaredNorm(), size_sq = solution.x.middleCols(c, 2).squaredNorm();
      r.fit_error_fluid = std::sqrt(fit_sq / alone);
      r.fluid_residual = std::sqrt((fit_sq + eps * eps * size_sq) / alone);
      r.n_fluid_steps = solution.n_iterations;
      r.fluid.coefficients.resize(functions.size());
      for (Index j = 0; j < functions.size(); ++j)
        r.fluid.coefficients[j] = a.column_scale[j] * Complex(solution.x(j, c), solution.x(j, c + 1));
    }
    times["solve_fluid"] = seconds_since(lap);
  }

  // The surface's motion, for a unit source.
  monitor.throw_if_stopped();
  monitor.progress("air", 0.4);
  lap = Clock::now();
  for (DualDomainResult& r : results) r.normal_derivative.setZero(n_samples);
  parallel_for(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
    auto scratch = functions.scratch();
    Eigen::VectorXd row(functions.size());
    for (std::size_t i = begin; i < end; ++i) {
      const BoundarySample& s = samples[i];
      if (s.region == BoundaryRegion::kDrySolid || (s.region != BoundaryRegion::kFreeSurface && !options.wall_slopes))
        continue;
      functions.row(s.point_m, &s.normal, scratch, row.data());
      for (DualDomainResult& r : results)
        r.normal_derivative[static_cast<Index>(i)] =
            incident(r.fluid, s.point_m, &s.normal) + row.cast<Complex>().dot(r.fluid.coefficients);
    }
  });

  // Pass 2.
  Matrix<Complex> air_data = Matrix<Complex>::Zero(n_samples, n_bubbles);
  const double ratio = paper ? 1.0 : options.air.density_kg_m3 / options.liquid.density_kg_m3;
  for (Index i = 0; i < n_samples; ++i) {
    const BoundarySample& s = samples[static_cast<std::size_t>(i)];
    weights[i] = s.region == BoundaryRegion::kWetSolid ? 0.0 : std::sqrt(s.area_m2);
    if (s.region != BoundaryRegion::kFreeSurface) continue;
    for (std::size_t b = 0; b < results.size(); ++b)
      air_data(i, static_cast<Index>(b)) = weights[i] * results[b].normal_derivative[i];
  }
  const std::size_t n_sources = points.air_m.size(),
                    n_padded = (n_sources + detail::kLane - 1) / detail::kLane * detail::kLane;
  std::vector<double> sources(3 * n_padded);
  for (std::size_t i = 0; i < n_padded; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      sources[axis * n_padded + i] = points.air_m[std::min(i, n_sources - 1)][static_cast<Index>(axis)];
  const Conditions<Complex> a = assemble<Complex>(
      n_air, n_samples, options.scale_columns,
      [&](Index begin, Index end, Matrix<Complex>& adjoint, Eigen::VectorXd& squares) {
        std::vector<double> r(n_padded), phase(n_padded), cosine(n_padded), sine(n_padded), padded(9 * n_padded, 0.0);
        for (Index i = begin; i < end; ++i) {
          const BoundarySample& s = samples[static_cast<std::size_t>(i)];
          detail::distances(sources.data(), n_padded, ka, s.point_m.data(), r.data(), phase.data());
          for (std::size_t j = 0; j < n_padded; ++j) {
            cosine[j] = std::cos(phase[j]);
            sine[j] = std::sin(phase[j]);
          }
          detail::singular_slopes(sources.data(), n_sources, n_padded, ka, s.point_m.data(), s.normal.data(), r.data(),
                                  cosine.data(), sine.data(), weights[i],
                                  reinterpret_cast<double*>(adjoint.col(i).data()), padded.data());
        }
        for (std::size_t f = 0; f < 9; ++f)
          for (std::size_t j = 0; j < n_sources; ++j)
            squares[static_cast<Index>(f * n_sources + j)] = padded[f * n_padded + j];
      });
  times["assemble_air"] = seconds_since(lap);
  lap = Clock::now();
  const double eps = options.ridge * a.frobenius;
  const detail::RidgeSolution<Complex> solution =
      detail::solve_ridge(a.adjoint, a.column_scale, air_data, eps, method(options.solver));
  if (!solution.solved) {
    fail(results, "pass 2: " + solution.message);
    return results;
  }
  const Matrix<Complex> error =
      detail::times(a.adjoint, Matrix<Complex>(a.column_scale.asDiagonal() * solution.x)) - air_data;
  times["solve_air"] = seconds_since(lap);
  times["total"] = seconds_since(start);
  for (std::size_t b = 0; b < results.size(); ++b) {
    DualDomainResult& r = results[b];
    const auto c = static_cast<Index>(b);
    const double scale_sq = air_data.col(c).squaredNorm(), fit_sq = error.col(c).squaredNorm();
    r.fit_error_air = std::sqrt(fit_sq / scale_sq);
    r.air_residual = std::sqrt((fit_sq + eps * eps * solution.x.col(c).squaredNorm()) / scale_sq);
    r.n_air_steps = solution.n_iterations;
    r.air.coefficients.resize(n_air);
    for (std::size_t j = 0; j < n_sources; ++j)
      for (std::size_t f = 0; f < 9; ++f) {
        const auto from = static_cast<Index>(f * n_sources + j);
        r.air.coefficients[static_cast<Index>(9 * j + f)] =
            ratio * r.source_strength * a.column_scale[from] * solution.x(from, c);
      }
    r.normal_derivative *= r.source_strength;
    r.wall_time_s = times;
    const bool finite = r.air.coefficients.allFinite() && r.normal_derivative.allFinite();
    r.status = finite ? DualDomainResult::Status::kSolved : DualDomainResult::Status::kFailed;
    if (!finite) r.message = "the solution is not finite";
  }
  monitor.progress("air", 1.0);
  return results;
}

namespace {

Complex liquid_at(const DualDomainResult& result, const Vector3d& x, const Vector3d* direction) {
  const FluidFunctions functions(result.fluid.wavenumber_per_m, result.fluid.order, result.fluid.points_m,
                                 result.fluid.solid_m);
  auto scratch = functions.scratch();
  Eigen::VectorXd row(functions.size());
  functions.row(x, direction, scratch, row.data());
  return result.source_strength *
         (incident(result.fluid, x, direction) + row.cast<Complex>().dot(result.fluid.coefficients));
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
