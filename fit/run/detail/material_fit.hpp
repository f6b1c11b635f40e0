#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "fit/elastic/identifiability.hpp"
#include "fit/elastic/joint_match.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/run/detail/measured_data.hpp"
#include "fit/run/fit.hpp"

namespace klang::fit::detail {

inline constexpr double kLogPerCent = 5.776226504666211e-4;  // ln 2 / 1200

/// One specimen's finite elements and their reduced model.
struct SpecimenModel {
  SpecimenBody body;
  std::shared_ptr<const ReducedSpectrum> spectrum;  ///< null: the specimen has no partials and takes no part
};

/// Material and dimensions that explain the partials of all specimens, and which line of the model each partial is.
struct MaterialFit {
  FitProblem start;                      ///< the problem about whose dimensions the last round's models are expanded
  std::optional<ParameterSpace> space;   ///< of the last round
  std::vector<SpecimenModel> specimens;  ///< in the problem's order
  SpectrumModels spectra;                ///< the same; where a specimen has none, another's stands in unused
  std::vector<Reason> reasons;           ///< of doubt, seen in the bodies
  JointMatch joint;                      ///< of predicted specimens too, once the fit is made
  double models_wall_time_s = 0.0, match_wall_time_s = 0.0;
  /// The problem with its material and dimensions at the solution.
  FitProblem fitted() const;
  /// Where each of a specimen's reduced modes stands among all when they are sorted at the solution.
  std::vector<int> ranks_at_solution(std::size_t specimen) const;
  /// Modes, from the lowest on, among which all are that a partial of the specimen is matched to.
  int n_modes_matched(std::size_t specimen) const;
};

/// Stage 2: models of the specimens, their match with the partials and the fit, in up to three rounds: after a dimension
/// has moved by more than its models' expansion bears, models are made anew. Partials of specimens that are only
/// predicted are matched at the end. joint.n_matched == 0: no partial lies near a mode.
MaterialFit fit_material(const FitProblem& problem, const MeasuredData& data, const FitOptions& options,
                         Monitor& monitor);

/// The asked and derived parameters with their intervals. problem: as asked, for the start values.
ElasticReport material_report(const FitProblem& problem, const MaterialFit& fit);

}  // namespace klang::fit::detail
