#include "core/sound/dual_domain/detail/liquid_solver.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/dual_domain/detail/conditions.hpp"

namespace klang::bubble::detail {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Vector3d;

namespace {

// With fewer, least squares fits the samples and swings between them.
constexpr std::size_t kSamplesPerFluidUnknown = 2, kSamplesPerAirUnknown = 3;

/// Order of the regular functions around the liquid's centre that are as many as those of the points; -1: sources.
int flat_order(const SourcePoints& points, FluidSpace space) {
  if (space != FluidSpace::kFlatLimit) return -1;
  return static_cast<int>(3.0 * std::sqrt(static_cast<double>(points.fluid_m.size())) + 1e-9) - 1;
}

}  // namespace

SourcePoints supported_points(const LiquidBoundary& boundary, SourcePoints points, Literature literature) {
  for (const auto& [list, per_unknown] :
       {std::pair(&points.fluid_m, kSamplesPerFluidUnknown), std::pair(&points.air_m, kSamplesPerAirUnknown)}) {
    const std::size_t enough = boundary.samples().size() / (kQuadrupoleSize * per_unknown);
    if (enough == 0)
      throw InputError(boundary.name(), "too few samples of the boundary", std::to_string(boundary.samples().size()),
                       std::to_string(kQuadrupoleSize * per_unknown) + " or more");
    list->resize(std::min(list->size(), enough));
  }
  if (literature == Literature::kPaper) points.solid_m.clear();
  points.solid_m.resize(
      std::min(points.solid_m.size(), boundary.samples().size() / (2 * kQuadrupoleSize * kSamplesPerFluidUnknown)));
  return points;
}

LiquidSolver::LiquidSolver(const LiquidBoundary& boundary, double frequency_hz, const SourcePoints& points,
                           const DualDomainOptions& options)
    : boundary_(boundary),
      points_(points),
      options_(options),
      k_(options.liquid_wavenumber_per_m(frequency_hz)),
      wall_give_(0.0, options.liquid.wavenumber_per_m(frequency_hz) * options.wall_admittance),
      order_(flat_order(points, options.fluid_space)),
      fluid_points_(order_ >= 0 ? std::vector{boundary.centre_m()} : points.fluid_m),
      functions_(k_, order_, fluid_points_, points_.solid_m),
      alpha_(wall_weight_m()),
      weights_(static_cast<Index>(boundary.samples().size())) {
  for (Index i = 0; i < weights_.size(); ++i) {
    const BoundarySample& s = boundary_.samples()[static_cast<std::size_t>(i)];
    weights_[i] = std::sqrt(s.area_m2) * (s.region == BoundaryRegion::kFreeSurface ? 1.0
                                          : s.region == BoundaryRegion::kDrySolid  ? 0.0
                                                                                   : alpha_);
    if (options.sample_counts.size() != 0) weights_[i] *= options.sample_counts[i];
  }
  const Index stride =
      options.most_samples > 0 ? (weights_.size() + options.most_samples - 1) / options.most_samples : 1;
  for (Index i = 0; i < weights_.size() && stride > 1; ++i)
    weights_[i] *= i % stride == 0 ? std::sqrt(static_cast<double>(stride)) : 0.0;
}

double LiquidSolver::wall_weight_m() const {
  const double length =
      options_.literature == Literature::kPaper
          ? 1.0
          : options_.wall_length_m.value_or(boundary_.radius_m() /
                                            (3.0 * std::sqrt(static_cast<double>(points_.fluid_m.size()))));
  return boundary_.rigid_area_m2() > 0.0 ? length * boundary_.rigid_area_m2() / boundary_.free_area_m2() : 1.0;
}

namespace {

/// Complex columns as the real ones of a real matrix, and back.
la::Matrix<double> columns_of(const Eigen::MatrixXcd& m, double) {
  la::Matrix<double> real(m.rows(), 2 * m.cols());
  for (Index c = 0; c < m.cols(); ++c) {
    real.col(2 * c) = m.col(c).real();
    real.col(2 * c + 1) = m.col(c).imag();
  }
  return real;
}
la::Matrix<Complex> columns_of(const Eigen::MatrixXcd& m, Complex) { return m; }
Eigen::MatrixXcd complex_of(const la::Matrix<double>& real) {
  Eigen::MatrixXcd m(real.rows(), real.cols() / 2);
  for (Index c = 0; c < m.cols(); ++c)
    for (Index i = 0; i < m.rows(); ++i) m(i, c) = Complex(real(i, 2 * c), real(i, 2 * c + 1));
  return m;
}
Eigen::MatrixXcd complex_of(const la::Matrix<Complex>& m) { return m; }

}  // namespace

template <class Scalar>
LiquidSolver::Solution LiquidSolver::solve_as(const Eigen::MatrixXcd& data) const {
  const Stopwatch lap;
  Solution result;
  const auto& samples = boundary_.samples();
  const Conditions<Scalar> a =
      assemble<Scalar>(functions_.size(), static_cast<Index>(samples.size()), options_.scale_columns,
                       [&](Index begin, Index end, la::Matrix<Scalar>& adjoint, Eigen::VectorXd& squares) {
                         auto scratch = functions_.scratch();
                         Eigen::VectorXcd values(wall_give_ != 0.0 ? functions_.size() : 0);
                         for (Index i = begin; i < end; ++i) {
                           const BoundarySample& s = samples[static_cast<std::size_t>(i)];
                           if (weights_[i] == 0.0) {
                             adjoint.col(i).setZero();
                             continue;
                           }
                           const bool free = s.region == BoundaryRegion::kFreeSurface;
                           functions_.row(s.point_m, free ? nullptr : &s.normal, scratch, adjoint.col(i).data());
                           if constexpr (std::is_same_v<Scalar, Complex>)
                             if (give(s) != 0.0) {
                               functions_.row(s.point_m, nullptr, scratch, values.data());
                               adjoint.col(i) += give(s) * values;
                             }
                           adjoint.col(i) = weights_[i] * adjoint.col(i).conjugate().eval();
                           squares += adjoint.col(i).cwiseAbs2();
                         }
                       });
  result.assemble_s = lap.seconds();
  const la::Matrix<Scalar> right = columns_of(data, Scalar());
  const double eps = options_.ridge * a.frobenius;
  const la::RidgeSolution<Scalar> solution =
      la::solve_ridge(a.adjoint, a.column_scale, right, eps, method(options_.solver));
  result.message = solution.message;
  result.solved = solution.solved;
  if (!solution.solved) return result;
  const la::Matrix<Scalar> scaled = a.column_scale.asDiagonal() * solution.x;
  result.error = complex_of(la::Matrix<Scalar>(la::times(a.adjoint, scaled) - right));
  result.coefficients = complex_of(la::Matrix<Scalar>(scaled.topRows(functions_.size())));
  result.ridge_sq = eps * eps * complex_of(solution.x).colwise().squaredNorm().transpose();
  result.n_iterations = solution.n_iterations;
  result.solve_s = lap.seconds() - result.assemble_s;
  return result;
}

LiquidSolver::Solution LiquidSolver::solve(const Eigen::MatrixXcd& data) const {
  return k_.imag() == 0.0 && wall_give_ == 0.0 ? solve_as<double>(data) : solve_as<Complex>(data);
}

Complex LiquidSolver::incident_condition(const FluidField& field, const BoundarySample& sample) const {
  if (sample.region == BoundaryRegion::kFreeSurface) return incident(field, sample.point_m, nullptr);
  const Complex slope = incident(field, sample.point_m, &sample.normal), give_here = give(sample);
  return give_here == 0.0 ? slope : slope + give_here * incident(field, sample.point_m, nullptr);
}

Eigen::VectorXcd LiquidSolver::at_sample(const BoundarySample& sample, bool slope,
                                         const Eigen::MatrixXcd& coefficients) const {
  auto scratch = functions_.scratch();
  const Vector3d* const normal = slope ? &sample.normal : nullptr;
  Eigen::VectorXcd row(functions_.size());
  if (k_.imag() == 0.0) {
    Eigen::VectorXd real(functions_.size());
    functions_.row(sample.point_m, normal, scratch, real.data());
    row = real.cast<Complex>();
  } else {
    functions_.row(sample.point_m, normal, scratch, row.data());
  }
  return coefficients.transpose() * row;
}

}  // namespace klang::bubble::detail
