#pragma once
#include <complex>
#include <string>
#include <vector>

#include "core/sound/dual_domain/detail/liquid_functions.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"

namespace klang::bubble::detail {

/// As many points as the boundary's samples support.
/// @throws InputError: too few samples for a single source
SourcePoints supported_points(const LiquidBoundary& boundary, SourcePoints points, Literature literature);

/// The liquid's field by least squares: values on the free surface, slopes on walls and wet solids.
class LiquidSolver {
 public:
  /// Both are kept by reference.
  LiquidSolver(const LiquidBoundary& boundary, double frequency_hz, const SourcePoints& points,
               const DualDomainOptions& options);
  std::complex<double> wavenumber_per_m() const { return k_; }
  int order() const { return order_; }  ///< of the waves about the centre; -1: sources
  const std::vector<Eigen::Vector3d>& points_m() const { return fluid_points_; }
  const FluidFunctions& functions() const { return functions_; }
  double alpha_m() const { return alpha_; }
  const Eigen::VectorXd& weights() const { return weights_; }  ///< of the samples: rows and data carry them

  struct Solution {
    bool solved = false;
    std::string message;
    Eigen::MatrixXcd coefficients;  ///< n_functions x n_columns
    Eigen::MatrixXcd error;         ///< n_samples x n_columns: weighted, what is there less what was asked
    Eigen::VectorXd ridge_sq;       ///< ||eps c||^2 of each column
    int n_iterations = 0;
    double assemble_s = 0.0, solve_s = 0.0;
  };
  bool counts(Eigen::Index sample) const {
    return options_.sample_counts.size() == 0 || options_.sample_counts[sample] > 0.0;
  }
  /// i k_0 beta at walls, 0 elsewhere: there the slope along the normal plus this times the value is asked to be 0.
  std::complex<double> give(const BoundarySample& sample) const {
    return sample.region == BoundaryRegion::kRigidWall ? wall_give_ : 0.0;
  }
  /// What a bubble and its images do to the condition at a sample: their value on the free surface, elsewhere slope and give.
  std::complex<double> incident_condition(const FluidField& field, const BoundarySample& sample) const;
  /// @param data  weighted, n_samples x n_columns
  Solution solve(const Eigen::MatrixXcd& data) const;
  /// Slope along the normal, or value, of a solution's columns at a sample.
  Eigen::VectorXcd at_sample(const BoundarySample& sample, bool slope, const Eigen::MatrixXcd& coefficients) const;

 private:
  double wall_weight_m() const;
  template <class Scalar>
  Solution solve_as(const Eigen::MatrixXcd& data) const;

  const LiquidBoundary& boundary_;
  const SourcePoints& points_;
  const DualDomainOptions options_;
  const std::complex<double> k_, wall_give_;
  const int order_;
  const std::vector<Eigen::Vector3d> fluid_points_;
  const FluidFunctions functions_;
  const double alpha_;
  Eigen::VectorXd weights_;
};

}  // namespace klang::bubble::detail
