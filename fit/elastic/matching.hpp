#pragma once
#include <Eigen/Core>
#include <vector>

#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

/// Modes that sound as one: equal or nearly equal frequencies (a symmetric body's pairs). frequency_hz is their
/// geometric mean. A line takes up to as many partials as it has modes.
struct ModelLine {
  double frequency_hz = 0.0;
  std::vector<int> modes;   ///< ascending in frequency
  double visibility = 1.0;  ///< 0 to 1: how loud a strike makes it, relative to the loudest
};

/// Groups frequencies, in any order, whose neighbours lie within cluster_cents. visibility: per mode, or empty for ones.
/// @param shear_share  of each mode d ln(omega^2) / d ln(mu): modes that differ in it only happen to lie close (a torsion by
///                     a bending) and make lines of their own; empty: not looked at
std::vector<ModelLine> model_lines(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& visibility,
                                   double cluster_cents = 3.0, const Eigen::VectorXd& shear_share = {});

struct MatchOptions {
  double tolerance_cents = 25.0;  ///< scale of the expected deviation, > 0
  double gate_cents = 100.0;      ///< no match beyond, > 0
  double split_cents = 40.0;      ///< widest splitting of one pair into two partials, > 0
};

struct TableMatch {
  std::vector<int> line_of_partial;  ///< -1: unmatched
  int n_matched = 0;
  double score = 0.0;  ///< log posterior odds against "all partials are strangers"
};

/// Assigns partials to lines by the largest total of log odds.
///   partial i on line k, d cents apart:  ln(p_k / (1 - p_k)) + ln t3(d / tolerance) - ln b_i
///   line k without a partial:            ln(1 - p_k), for lines up to the highest partial
/// p_k is the probability that a line is heard: high for loud ones, low where the model has many more lines than the
/// recording has partials, so that a coincidence in a dense spectrum is worth nothing. b_i is the density of partials that
/// have no line (one per octave, more for weak ones). t3 is Student's t with 3 degrees of freedom.
/// @param shift_cents  added to every line
/// @param exact  optimal assignment (Hungarian) when true, otherwise greedy: for searches
TableMatch match_partials(const PartialTable& table, const std::vector<ModelLine>& lines, double shift_cents,
                          const MatchOptions& options, bool exact = true);

/// What a match is worth before it is looked at how well its frequencies agree: of each matched partial ln(p_k / (1 - p_k)) -
/// ln b_i (of a pair's second one its splitting too), of each silent line up to the highest partial ln(1 - p_k).
double match_prior_score(const PartialTable& table, const std::vector<ModelLine>& lines, const TableMatch& match,
                         const MatchOptions& options);

/// Column of each row in the assignment of least total cost (Kuhn-Munkres with potentials, O(rows^2 columns)).
/// @param cost  n_rows x n_columns, n_rows <= n_columns, finite
std::vector<int> least_cost_assignment(const Eigen::MatrixXd& cost);

}  // namespace klang::fit
