#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/solid/material.hpp"
#include "fit/elastic/joint_match.hpp"
#include "fit/judge/judgement.hpp"
#include "fit/ringdown/partial_table.hpp"
#include "fit/specimen/fit_parameter.hpp"

/// Whether a fit that converged may be believed. A fit absorbs much: a thickness of 6 mm typed for 8 comes out as a stiffness.
/// What speaks against it is gathered here as reasons with numbers (docs/fit.md, "The verdict").
namespace klang::fit {

/// What a specimen brings to the judge.
struct JudgedSpecimen {
  std::string name;
  PartialTable partials;
  std::vector<int> mode_of_partial;          ///< 0-based elastic mode; -1: none
  Eigen::VectorXd frequency_hz;              ///< of the model's modes, ascending
  Eigen::VectorXd visibility;                ///< of the first modes; empty: not known
  std::optional<double> density_kg_m3;       ///< by mass and volume
  int n_takes = 0;                           ///< recordings with partials; 0: a table made elsewhere
  std::optional<double> take_scatter_cents;  ///< typical deviation of one take from another
  std::optional<double> take_share;          ///< least share of a take's strong partials that another take has too
};

enum class GivenKind { kDimension, kModulus, kPoissonsRatio };

/// A number that was given and not fitted, and what an error of it does. Errors are of its logarithm, of Poisson's ratio itself.
struct GivenValue {
  std::string specimen;  ///< empty: of the material
  std::string name;
  double value = 0.0;     ///< m, Pa or 1
  Eigen::VectorXd slope;  ///< of each residual's ln model by the error
  GivenKind kind = GivenKind::kDimension;
  double relative_tolerance = 0.0;  ///< one standard deviation, as the specimen states it; 0: not stated
};

/// The residuals of the fit and of rings that were left out near a mode.
struct JudgedResiduals {
  Eigen::VectorXd residual;              ///< ln measured - ln model
  Eigen::VectorXd sigma;                 ///< relative: the partial's own and the mesh's
  Eigen::MatrixXd derivative;            ///< of ln model by x
  std::vector<std::string> coordinates;  ///< names of x
  Eigen::VectorXd guess_std;             ///< guess_std() of x
  std::vector<std::string> rings;        ///< "mode 5 (7169.8 Hz)" of each
  std::vector<GivenValue> given;
};

struct JudgeInput {
  solid::Material start, found;  ///< start.name: the preset, or empty
  std::vector<FitParameter> parameters;
  std::vector<JudgedSpecimen> specimens;
  JudgedResiduals residuals;
  int n_data = 0, n_free = 0;
  double scatter_cents = 0.0, rms_cents = 0.0, model_std_cents = 2.0;
  std::optional<RivalMatch> rival;
  std::vector<Reason> given;  ///< found while reading: supports that cut, units
};

Judgement judge_fit(const JudgeInput& input);

/// An error of a given number that would explain the residuals.
struct GivenHint {
  std::size_t given = 0;  ///< of JudgedResiduals::given
  double log_odds = 0.0;  ///< for it against no error; beforehand an error has the standard deviation given_error_std()
  double error = 0.0, error_std = 0.0;  ///< of ln true - ln given, of Poisson's ratio true - given
  std::string ring;                     ///< whose residual it takes most from
  Eigen::VectorXd step;                 ///< of x, with it
};

/// Beforehand: 3 % of a dimension, 5 % of a modulus, 0.03 of Poisson's ratio.
double given_error_std(GivenKind kind);

/// All given numbers, likeliest to be wrong first. Marginal likelihoods of a linear model with normal priors and an unknown scatter of at
/// least 0.3 cents (Gelman et al. 2013, Bayesian Data Analysis, chapter 14).
std::vector<GivenHint> given_hints(const JudgedResiduals& residuals, double model_std_cents);

/// d ln E / d ln value (of each given number) at the same measured frequencies, E's coordinate free: -2 for the thickness of a bar
/// of given density, -3 for one of given mass. Empty where E is not free.
std::vector<double> stiffness_powers(const JudgedResiduals& residuals);

}  // namespace klang::fit
