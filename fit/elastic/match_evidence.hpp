#pragma once
#include <Eigen/Core>
#include <vector>

#include "fit/elastic/elastic_fit.hpp"
#include "fit/elastic/joint_match.hpp"
#include "fit/elastic/matching.hpp"

namespace klang::fit {

/// How far the guess of each coordinate may be off, as a standard deviation, for the comparison of matchings: ln of a
/// stiffness or density 0.35, Poisson's ratio 0.12, ln of a dimension 0.02.
Eigen::VectorXd guess_std(const ParameterSpace& space);

/// A match of all specimens, weighed on the tables it came from.
struct WeighedMatch {
  const std::vector<PartialTable>& tables;
  const SpecimenLines& lines;
  const std::vector<TableMatch>& matches;
  const std::vector<ElasticDatum>& data;  ///< elastic_data() of these
  const ElasticFit& fit;                  ///< to that data
};

/// What a match of all specimens says of the data, as the logarithm of a probability up to what all matchings share:
///   sum match_prior_score + ln integral p(s) prod t5(r_i; sigma_i^2 + s^2) ds - ln sqrt det(1 + P F) - |x - guess|^2_P / 2
/// r_i [cents] are the residuals at the best parameters, s the model's scatter, unknown but for p(s), half-Student with
/// ElasticFitOptions::model_dof and median model_std; F is the information that the data hold of x, P the guess's
/// covariance (Laplace's approximation; MacKay 2003, chapter 28). A match that agrees to 0.02 cents is so worth more than
/// one that agrees to 5, and one that uses up the parameters to agree is worth less than one that had to.
double match_evidence(const ParameterSpace& space, const WeighedMatch& weighed, const ElasticFitOptions& options,
                      const MatchOptions& match);

/// The best parameters about fit.x for residuals that another match gives there, to first order, as a fit.
/// @param derivative  of ln model by x, a row per datum
ElasticFit linear_fit(const ParameterSpace& space, const Eigen::VectorXd& x, const Eigen::VectorXd& residual,
                      const Eigen::MatrixXd& derivative, const std::vector<ElasticDatum>& data,
                      const ElasticFitOptions& options);

}  // namespace klang::fit
