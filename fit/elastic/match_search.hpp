#pragma once
#include <Eigen/Core>
#include <vector>

#include "fit/elastic/joint_match.hpp"

namespace klang::fit {

/// Points from which a match is worth refining: for a grid of Poisson's ratios, every frequency factor that puts a strong
/// partial of a specimen on one of its low lines (stiffness factor 0.43 to 2.3), ranked by the log odds of match_partials
/// over all specimens with a prior for the factor (std of ln stiffness 0.35) and for Poisson's ratio (0.12). At most eight,
/// different enough to end in different places, best first.
std::vector<Eigen::VectorXd> match_starts(const ParameterSpace& space, const SpectrumModels& models,
                                          const std::vector<PartialTable>& tables, const JointMatchOptions& options);

}  // namespace klang::fit
