#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "validate/claim/claim.hpp"
#include "validate/claim/order_estimate.hpp"
#include "validate/studies/fields.hpp"

namespace klang::validate {

/// A place at which a level was held against its reference.
struct LevelPoint {
  double x_over_l = 0.0, z_over_h = 0.0, value = 0.0, exact = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"x_over_l", "across, over the width"}, self.x_over_l);
    visit({"z_over_h", "up, over the height"}, self.z_over_h);
    visit({"value", "found"}, self.value);
    visit({"exact", "of the reference"}, self.exact);
  }
};

/// One mesh, time step or order of approximation.
struct Level {
  std::optional<double> h_m;                        ///< element size [m]; studies in space have it
  std::optional<double> n;                          ///< samples per second, order of an expansion; the others have it
  double error = 0.0;                               ///< against the series' reference, >= 0
  std::optional<std::array<double, 2>> error_ci95;  ///< of the error, where it is a mean over random repeats
  std::optional<double> value;                      ///< a number that converges, for the grid convergence index
  std::optional<double> exact;                      ///< what it should be
  std::optional<double> shape_error;                ///< of a shape that comes back: what differs, over its volume
  std::vector<LevelPoint> points;                   ///< places of the error
  double n_unknowns = 0.0;                          ///< cost that does not depend on the machine
  double wall_time_s = 0.0;
  double step() const { return h_m ? *h_m : n.value_or(0.0); }
};

/// Levels of one method on one problem, coarse to fine, and what was found.
struct Series {
  // What is asked.
  std::string id;           ///< "ball-p2"
  std::string title;        ///< "Elastic ball, quadratic elements"
  std::string reference;    ///< in words, with its accuracy: "Lamb's characteristic equation (1e-13)"
  std::string step_words;   ///< axis: "element size [m]"
  std::string error_words;  ///< axis: "relative error of the eigenvalues"
  Convergence kind = Convergence::kAlgebraic;
  double expected_order = 0.0;        ///< unused for round-off; NaN: none, the error alone is judged
  double order_tolerance = 0.3;       ///< |observed - expected| <= this
  bool higher_is_fine = false;        ///< a higher order than expected passes too
  double error_tolerance = 0.0;       ///< largest error of the finest level (round-off: of any level)
  double error_floor = 0.0;           ///< levels at or below are left out of the fit
  std::string floor_words;            ///< what the floor is
  bool counts = true;                 ///< false: shown for comparison, no part of the verdict
  std::optional<double> exact_value;  ///< what Level::value converges to, where it is known

  // What was found.
  std::vector<Level> levels;
  OrderEstimate order;
  std::optional<GridConvergence> gci;  ///< of the values of the three finest levels in the fit
  bool passed = false;
  std::string verdict;  ///< one sentence
};

/// Fills order, gci, passed and verdict from the levels. Passed: the observed order within its band, and the error of the
/// finest level within its tolerance. A series whose levels all sank to the floor passes on its error alone where at least
/// two levels are there, and says so.
void judge(Series& series);

enum class StudyStatus { kNotRun, kDone };

struct Study {
  std::string name;      ///< "fem"
  std::string title;     ///< "Eigenvalues of the finite elements"
  std::string question;  ///< one or two sentences on what is shown
  StudyStatus status = StudyStatus::kNotRun;
  std::vector<Series> series;  ///< the first is the main one
  std::vector<Claim> claims;   ///< beyond the orders: reference values, tables
  Fields fields;
  bool passed() const;  ///< every series that counts and every claim
};

struct StudyOptions {
  int levels = 0;
  std::string only;
  bool fields = true;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"levels", "Only the coarsest N levels of each series, 3 or more; 0: all"}, self.levels);
    visit({"only", "Only series whose name contains TEXT"}, self.only);
    visit({"fields", "Compute what the pictures show"}, self.fields);
  }
};

/// "fem", "bem", ...: what run_study knows.
const std::vector<std::string>& study_names();

/// Runs a study; tolerances of the finest level grow by the expected order where options.levels leaves it out.
/// @throws InputError for an unknown name; NumericalError when a solver does not converge; Interrupted
Study run_study(const std::string& name, const StudyOptions& options = {}, Monitor& monitor = silent_monitor());

/// Whether options.only lets a series of this id through.
bool wanted(const StudyOptions& options, const std::string& id);

/// How many of a series' n levels are run: options.levels, at most n.
std::size_t level_count(const StudyOptions& options, std::size_t n);

/// Claims of a study: two for each series that counts (order, error), then its own.
std::vector<Claim> all_claims(const Study& study);

}  // namespace klang::validate
