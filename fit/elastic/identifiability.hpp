#pragma once
#include <string>
#include <vector>

#include "fit/elastic/budget.hpp"
#include "fit/elastic/elastic_fit.hpp"
#include "fit/specimen/fit_parameter.hpp"

namespace klang::fit {

/// A quantity counts as determined by the data when its relative standard deviation is below kDeterminedStd and the part
/// of it that an assumption (the regularisation, e.g. Poisson's ratio within 0.1 of the guess) leaves open is below
/// kAssumedStd. At 20 % a 95 % interval spans a factor of 2.3 for Student's t with few degrees of freedom: beyond that a
/// number says less than a handbook does. 2 % keeps a quantity that the assumption merely touches (E in the shear
/// correction of bending) and drops one that it carries (mu from bending alone).
inline constexpr double kDeterminedStd = 0.2;
inline constexpr double kAssumedStd = 0.02;
/// A dimension is known to a few per cent before any fit; less is no determination.
inline constexpr double kDeterminedDimensionStd = 0.03;

/// Factor on the regularisation of each coordinate: 0 where the data alone determine it, 1 elsewhere.
Eigen::VectorXd regularisation_factors(const ParameterSpace& space, const ElasticFit& fit);

struct ElasticReport {
  std::vector<FitParameter> parameters;          ///< asked ones, then derived ones
  std::vector<std::vector<double>> correlation;  ///< of the identifiable asked ones, in their order
  std::vector<BudgetEntry> budget;               ///< of each parameter that has a std, in their order
};

/// Values, standard deviations and 95 % intervals (Student's t) of the asked and derived quantities at fit.x, by the
/// delta method.
/// @param regularisation  the factors the fit was made with
ElasticReport elastic_report(const ParameterSpace& space, const ElasticFit& fit, const Eigen::VectorXd& regularisation,
                             const FitProblem& problem);

/// Relative standard deviation of each predicted frequency of a specimen at fit.x, by the delta method: the posterior of the
/// parameters, the model's scatter and the mesh's error.
/// @param regularisation  the factors the fit was made with
Eigen::VectorXd prediction_std(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                               const ElasticFit& fit, const Eigen::VectorXd& regularisation);

}  // namespace klang::fit
