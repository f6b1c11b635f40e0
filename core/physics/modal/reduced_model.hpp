#pragma once
#include <Eigen/Core>

#include "core/physics/modal/eigen_solver.hpp"

namespace klang::modal {

/// A small model that gives the lowest eigenvalues for any Lame pair without a new large solve: K_lambda,
/// K_mu and M projected onto the modes of a few Poisson ratios (omega^2 is homogeneous of degree 1 in
/// (lambda, mu), so the ratio is all that matters). Eigenvalue errors are of second order in the distance
/// from the anchors; max_relative_error says how large they are midway between anchors, measured by a full
/// solve.
struct ReducedModel {
  Eigen::MatrixXd stiffness_lambda;  ///< n x n, basis is M_1-orthonormal (M_1: unit density)
  Eigen::MatrixXd stiffness_mu;
  int n_modes = 0;    ///< lowest modes that are to be trusted
  int n_skipped = 0;  ///< elastic modes below the band, left out of results
  double poissons_ratio_low = 0.0, poissons_ratio_high = 0.0;
  double max_relative_error = 0.0;  ///< of omega^2 over the trusted modes
  EigenResult nominal;              ///< full solve at the nominal material
};

struct ReducedModelOptions {
  int count = 30;
  Band band;
  std::vector<double> anchor_poissons_ratios = {0.05, 0.25, 0.42};
  bool measure_error = true;
  bool estimate_mesh_error = false;  ///< of the nominal modes: nominal.mesh_relative_error
};

ReducedModel reduce(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled, const solid::Material& nominal,
                    const solid::Support& support, const ReducedModelOptions& options,
                    Monitor& monitor = silent_monitor());

/// omega^2 of the trusted modes, ascending, with their derivatives by lambda and mu (n_modes x 2). Inside a
/// cluster of equal eigenvalues the derivatives are those of the cluster's mean, so that they do not depend
/// on how a basis of it was chosen.
struct ReducedEigenvalues {
  Eigen::VectorXd angular_frequency_sq;  ///< rad^2/s^2
  Eigen::MatrixXd derivative;            ///< by (lambda, mu), at fixed density
  double derivative_log_density = -1.0;  ///< d ln(omega^2) / d ln(rho)
};
ReducedEigenvalues reduced_eigenvalues(const ReducedModel& model, double lame_lambda_pa, double lame_mu_pa,
                                       double density_kg_m3);

}  // namespace klang::modal
