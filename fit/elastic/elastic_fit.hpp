#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "fit/elastic/parameter_space.hpp"
#include "fit/elastic/spectrum_model.hpp"

namespace ceres {
class CostFunction;
}

namespace klang::fit {

using SpectrumModels = std::vector<std::shared_ptr<const SpectrumModel>>;

/// One line of a specimen with the mean of the partials on it.
struct ElasticDatum {
  int specimen = 0;
  std::vector<int> modes;      ///< the line's modes; the model value is the mean of their ln f
  double log_frequency = 0.0;  ///< ln of the measured frequency in Hz
  double sigma = 0.0;          ///< its standard deviation (relative frequency), measurement only
  std::vector<int> over = {};  ///< log_frequency is the ln of a ratio: of the above to the line of these modes
};

struct ElasticFitOptions {
  double model_std = 2.0 * 5.776e-4;
  double model_dof = 4.0;  ///< half-Student: flat towards no scatter
  bool robust = true;
  int max_rounds = 15;
  std::map<std::string, Prior> priors;  ///< by parameter name

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"model_std", "Median scatter of the model beforehand (relative frequency)", above(0.0)}, self.model_std);
    visit({"model_dof", "Degrees of freedom of that belief", above(0.0)}, self.model_dof);
    visit({"robust", "Huber weights beyond 2 standard deviations"}, self.robust);
    visit({"max_rounds", "Of reweighting", at_least(1.0)}, self.max_rounds);
  }
};

/// A number that was given and not fitted.
struct GivenQuantity {
  std::string name;                    ///< "D3.length_m", "D3.mass_kg", "density_kg_m3"
  Eigen::VectorXd pull;                ///< on x (information times shift) of ln of it being larger by 1
  std::optional<double> relative_std;  ///< by its tolerance
};

/// The result of fit_elastic at x. Covariances are of x, scaled to the estimated scatter.
struct ElasticFit {
  bool converged = false;
  Eigen::VectorXd x;
  Eigen::VectorXd residual;    ///< ln measured - ln model, one per datum
  Eigen::VectorXd weight;      ///< robust weights, 0 to 1
  Eigen::MatrixXd derivative;  ///< of ln model by x, a row per datum
  double scatter = 0.0;        ///< estimated model scatter (relative frequency)
  double degrees_of_freedom = 1.0;
  Eigen::MatrixXd information;        ///< of the data alone (inverse covariance)
  Eigen::MatrixXd prior_information;  ///< of the priors
  /// Pull on x (information times shift) of errors that the model's frequencies have in common: each mode off by its
  /// SpectrumModel::relative_error(), and by that growing with frequency. Two columns.
  Eigen::MatrixXd systematic;
  std::vector<GivenQuantity> given;  ///< filled by who knows the specimens
  double cost_initial = 0.0, cost_final = 0.0;
  int n_iterations = 0;
};

/// Least squares over all specimens:
///   sum_i w_i (ln f_i - ln f_model(x))^2 / (sigma_i^2 + s^2) + sum of priors
/// with s the median model scatter given the residuals (scatter_median), and Huber weights w_i, both iterated.
/// @param regularisation  scales the weak pull to the start: 1, or 0 for a coordinate that the data determine
ElasticFit fit_elastic(const ParameterSpace& space, const SpectrumModels& models, const std::vector<ElasticDatum>& data,
                       const Eigen::VectorXd& x0, const Eigen::VectorXd& regularisation,
                       const ElasticFitOptions& options);

/// The residuals that Ceres sees (data, then priors, then regularisation), for the gradient checker. total: standard deviation
/// of each datum.
std::unique_ptr<ceres::CostFunction> elastic_cost(const ParameterSpace& space, const SpectrumModels& models,
                                                  const std::vector<ElasticDatum>& data, const Eigen::VectorXd& total,
                                                  const Eigen::VectorXd& regularisation,
                                                  const std::map<std::string, Prior>& priors);

}  // namespace klang::fit
