#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/la/block_mass.hpp"
#include "core/foundation/la/block_ordering.hpp"
#include "core/foundation/la/sparse_cholesky.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::modal::detail {

/// Eigenvalues omega^2, ascending, and M-orthonormal vectors.
struct Pairs {
  Eigen::VectorXd value;
  Eigen::MatrixXd vector;  ///< n_dofs x n
  bool converged = false;
  std::string message;
  Eigen::Index size() const { return value.size(); }
};

/// Sorted union of two sets.
Pairs merged(const Pairs& a, const Pairs& b);

/// K u = omega^2 M u of one body with its rigid motions known.
class EigenProblem {
 public:
  EigenProblem(const mesh::TetMesh& mesh, const solid::AssembledSolid& assembled, const solid::Material& material);

  Eigen::Index n_dofs() const { return stiffness_.rows(); }
  int n_rigid() const { return static_cast<int>(rigid_.cols()); }
  /// Elastic modes there are at all.
  Eigen::Index n_elastic() const { return n_dofs() - n_rigid(); }

  /// Factors K - shift M; false (see message) when it is not positive definite.
  bool factor(std::string& message);
  /// factor() and n_below() at the same time, on a thread each.
  bool factor_and_count(double omega_sq, std::string& message);

  /// The n lowest elastic pairs that are M-orthogonal to the columns of `known`; Lanczos (Spectra) on the
  /// inverse. attempt changes the start vector and widens the search space.
  Pairs lowest(Eigen::Index n, double tolerance, int max_restarts, const Eigen::MatrixXd& known, int attempt);
  /// The same, with blocks of start vectors: fewer passes through the factor, for large bodies.
  /// @param watch  told the eigenvalues so far, ascending, and how far off each may be at most
  using Watch = std::function<void(const Eigen::VectorXd& value, const Eigen::VectorXd& error)>;
  Pairs lowest_block(Eigen::Index n, Eigen::Index block, double tolerance, int max_restarts, const Watch& watch = {});
  /// The same by a dense solver (LAPACK), all at once; needs no factor.
  Pairs lowest_dense(Eigen::Index n) const;

  /// One step of inverse iteration with all pairs at once, then Rayleigh-Ritz on what it gives; needs the
  /// factor.
  void polish(Pairs& pairs);
  /// polish() and n_below() at the same time, on a thread each.
  void polish_and_count(Pairs& pairs, double omega_sq);

  /// (K - shift M)^-1 f for each column, without rigid part; needs the factor.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& force);

  /// Sturm count: eigenvalues below omega_sq, rigid ones included. The last one is remembered.
  std::optional<long> n_below(double omega_sq);

  /// ||K u - w^2 M u|| / (w^2 ||M u||) of each pair, and what of it is the round-off of the products alone.
  void residuals(const Pairs& pairs, Eigen::VectorXd& relative, Eigen::VectorXd& round_off) const;

  int n_operations() const { return n_operations_; }
  double seconds_factor = 0, seconds_sturm = 0;

 private:
  friend class ShiftInvert;
  const la::FactorPattern& pattern();

  solid::SparseMatrix stiffness_;         // lower
  const solid::SparseMatrix& unit_mass_;  // lower, unit density
  double density_kg_m3_;
  la::BlockMass mass_;
  Eigen::MatrixXd rigid_, mass_rigid_;  // M-orthonormal
  double shift_ = 0;                    // <= 0, rad^2/s^2
  la::NodeEnds ends_;
  std::optional<la::FactorPattern> pattern_;
  la::SparseCholesky factor_;
  int n_operations_ = 0;
  double counted_at_ = -1;
  std::optional<long> counted_;
};

/// A Sturm count at a gap at or above pairs.value[wanted - 1] and what it says.
struct Proof {
  double omega_sq = 0;              ///< where it was counted
  Eigen::Index n_found_below = 0;   ///< elastic pairs found below it
  std::optional<long> sturm_count;  ///< rigid ones included
  std::optional<bool> none_missing;
};

/// Middle of the widest gap between neighbours from pairs.value[wanted - 1] on; 0 when all the rest is one
/// cluster.
double gap_above(const Pairs& pairs, Eigen::Index wanted);

/// The same of values that are still on their way, each off by its error at most: only gaps that stand for sure, ten times as wide as their ends
/// may be off.
double sure_gap_above(const Eigen::VectorXd& value, const Eigen::VectorXd& error, Eigen::Index wanted);

/// Counts at omega_sq; while modes are missing there, looks for them among what is M-orthogonal to those
/// found (at most max_searches times) and merges them in.
Proof prove(EigenProblem& problem, Pairs& pairs, double omega_sq, double tolerance, int max_restarts, int max_searches);

}  // namespace klang::modal::detail
