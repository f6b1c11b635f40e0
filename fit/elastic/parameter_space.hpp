#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "fit/elastic/spectrum_model.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {

/// The asked parameters as well-scaled coordinates x. Two elastic constants, whichever were asked, move as (ln E, nu),
/// where bending is one axis; a single one moves alone (ln p; lambda as lambda / mu) while its usual partner stays:
/// E with nu, lambda with mu. Density and dimensions are logarithms relative to their start.
class ParameterSpace {
 public:
  explicit ParameterSpace(const FitProblem& problem);

  Eigen::Index size() const { return start_.size(); }
  const Eigen::VectorXd& start() const { return start_; }
  const Eigen::VectorXd& low() const { return low_; }
  const Eigen::VectorXd& high() const { return high_; }
  /// Standard deviation of the weak pull towards the start that keeps undetermined coordinates sane; 0: none.
  const Eigen::VectorXd& regularisation_std() const { return regularisation_std_; }
  const std::vector<std::string>& coordinate_names() const { return names_; }

  /// The point of one specimen and its derivative by x (rows: lambda, mu, ln rho, the specimen's free dimensions).
  struct Local {
    SpectrumPoint point;
    Eigen::MatrixXd derivative;
  };
  Local local(std::size_t specimen, const Eigen::VectorXd& x) const;
  /// Names of the specimen's free dimensions, without its own name.
  const std::vector<std::string>& free_dimensions(std::size_t specimen) const { return dimensions_[specimen]; }

  /// A named number at x with its gradient: the elastic constants, "bulk_modulus_pa", "density_kg_m3",
  /// "D3.length_m", and the ratios "youngs_modulus_pa/density_kg_m3", "lame_mu_pa/density_kg_m3".
  struct Quantity {
    double value = 0.0;
    Eigen::VectorXd gradient;
  };
  Quantity quantity(const std::string& name, const Eigen::VectorXd& x) const;

  bool elastic_is_free() const { return n_elastic_ > 0; }
  bool ratio_is_free() const { return n_elastic_ == 2; }         ///< nu has its own coordinate
  const std::string& single_elastic() const { return single_; }  ///< the elastic name when only one is free, else empty
  bool density_is_free() const { return density_at_ >= 0; }
  /// x with all frequencies multiplied by exp(log_factor), as far as a free stiffness or density can; otherwise x.
  Eigen::VectorXd shifted(const Eigen::VectorXd& x, double log_factor) const;
  bool can_shift() const { return n_elastic_ > 0 || density_at_ >= 0; }
  /// Largest change of ln(dimension) between the start and x; 0 where no dimension is free.
  double largest_dimension_step(const Eigen::VectorXd& x) const;
  Eigen::VectorXd with_poissons_ratio(const Eigen::VectorXd& x, double poissons_ratio) const;
  double start_poissons_ratio() const { return poisson0_; }

 private:
  struct Elastic {
    double young, poisson, lambda, mu;
    Eigen::VectorXd d_young, d_poisson, d_lambda, d_mu;
  };
  Elastic elastic(const Eigen::VectorXd& x) const;
  void add(const std::string& name, double start, double low, double high, double regularisation_std);

  int n_elastic_ = 0;
  std::string single_;  ///< the elastic name when only one is free
  Eigen::Index density_at_ = -1;
  double young0_ = 0.0, poisson0_ = 0.0, lambda0_ = 0.0, mu0_ = 0.0, density0_ = 0.0;
  std::vector<std::vector<std::string>> dimensions_;
  std::vector<std::vector<Eigen::Index>> dimension_at_;
  std::vector<std::vector<double>> dimension0_;
  std::vector<std::string> specimen_names_;
  std::vector<std::string> names_;
  Eigen::VectorXd start_, low_, high_, regularisation_std_;
};

}  // namespace klang::fit
