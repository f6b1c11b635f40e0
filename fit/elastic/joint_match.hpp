#pragma once
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/elastic/elastic_fit.hpp"
#include "fit/elastic/matching.hpp"

namespace klang::fit {

using SpecimenLines = std::vector<std::vector<ModelLine>>;  ///< one list per specimen

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

/// The best match that puts the partials on other modes.
struct RivalMatch {
  double log_odds = 0.0;  ///< for the chosen one against this one; below 3 (20 to 1) they are nearly equal
  int n_matched = 0;
  double scatter = 0.0;  ///< relative frequency
  double youngs_modulus_pa = 0.0, poissons_ratio = 0.0;
  std::vector<int> modes;  ///< first mode of each partial's line, specimen after specimen; -1: none
};

/// Partials of all specimens on their modes, and the parameters that make them fit.
struct JointMatch {
  ElasticFit fit;
  Eigen::VectorXd regularisation;
  std::vector<TableMatch> matches;  ///< one per specimen
  SpecimenLines lines;              ///< one list per specimen, at fit.x
  double evidence = 0.0;            ///< match_evidence()
  int n_matched = 0;
  bool settled = false;             ///< no other match that was tried about it is better
  std::optional<RivalMatch> rival;  ///< empty: no other match came near
};

/// Finds the assignment and the parameters together, from a material guess that may be 30 % off.
///   1. Starts: match_starts().
///   2. From each: match, fit, match again with a tolerance that shrinks to what the residuals show, until the match stays.
///   3. About the best end so far, other matches: a partial on another line in reach, two partials changed over, one left
///      out. Those that promise most to first order are fitted and settled; a better one takes the place, and so on.
/// Ends are compared by match_evidence(): the same answer whatever the start.
JointMatch match_and_fit(const ParameterSpace& space, const SpectrumModels& models,
                         const std::vector<PartialTable>& tables, const JointMatchOptions& options,
                         Monitor& monitor = silent_monitor());

/// The data of a match: of each line the mean of its partials.
std::vector<ElasticDatum> elastic_data(const std::vector<PartialTable>& tables, const SpecimenLines& lines,
                                       const std::vector<TableMatch>& matches);

/// The lines of all specimens at x.
SpecimenLines lines_at(const ParameterSpace& space, const SpectrumModels& models, const Eigen::VectorXd& x,
                       double cluster_cents);

/// Frequencies [Hz] of a specimen's modes at x.
Eigen::VectorXd model_frequencies(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                                  const Eigen::VectorXd& x);

}  // namespace klang::fit
