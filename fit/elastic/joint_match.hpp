#pragma once
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/elastic/elastic_fit.hpp"
#include "fit/elastic/matching.hpp"

namespace klang::fit {

struct JointMatchOptions {
  double gate_cents = 60.0;
  ElasticFitOptions elastic;
  bool search = true;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"gate_cents", "Widest accepted deviation of a partial from its mode", above(0.0)}, self.gate_cents);
    visit({"elastic", "The fit to each match"}, self.elastic);
    visit({"search", "Look for starts far from the guess too"}, self.search);
  }
};

/// Partials of all specimens on their modes, and the parameters that make them fit.
struct JointMatch {
  ElasticFit fit;
  Eigen::VectorXd regularisation;
  std::vector<TableMatch> matches;            ///< one per specimen
  std::vector<std::vector<ModelLine>> lines;  ///< one list per specimen, at fit.x
  double score = 0.0;
  int n_matched = 0;
  bool settled = false;  ///< match and fit agree
};

/// Finds the assignment and the parameters together, from a material guess that may be 30 % off.
///   1. For a grid of Poisson's ratios and every frequency factor that puts a strong partial of a specimen on one of its
///      low lines (stiffness factor 0.43 to 2.3), the total log odds of match_partials over all specimens, with a
///      prior for the factor (std of ln stiffness 0.35) and for Poisson's ratio (std 0.12).
///   2. From the best few of these: match, fit, match again with a tolerance that shrinks to what the residuals show, until
///      the match stays. The one of the highest final odds is returned.
JointMatch match_and_fit(const ParameterSpace& space, const SpectrumModels& models,
                         const std::vector<PartialTable>& tables, const JointMatchOptions& options,
                         Monitor& monitor = silent_monitor());

/// The data of a match: of each line the mean of its partials.
std::vector<ElasticDatum> elastic_data(const std::vector<PartialTable>& tables,
                                       const std::vector<std::vector<ModelLine>>& lines,
                                       const std::vector<TableMatch>& matches);

/// Frequencies [Hz] of a specimen's modes at x.
Eigen::VectorXd model_frequencies(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                                  const Eigen::VectorXd& x);

}  // namespace klang::fit
