#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "fit/damping/damping.hpp"
#include "fit/elastic/budget.hpp"
#include "fit/judge/judgement.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "fit/specimen/fit_parameter.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {

enum class FitStatus { kNotRun, kConverged, kNotConverged, kNoPartials, kNoMatch };
constexpr auto words_of(FitStatus) {
  return std::array{Word{FitStatus::kNotRun, "not_run"}, Word{FitStatus::kConverged, "converged"},
                    Word{FitStatus::kNotConverged, "not_converged"}, Word{FitStatus::kNoPartials, "no_partials"},
                    Word{FitStatus::kNoMatch, "no_match"}};
}

struct PartialMatch {
  int specimen = 0;
  int partial = -1;  ///< row of that specimen's table
  int mode = -1;     ///< 0-based elastic mode
  double frequency_hz = 0.0;
  std::optional<double> frequency_std_hz;
  double model_frequency_hz = 0.0;
  double deviation_cents = 0.0;  ///< measured against model
  std::optional<double> decay_per_s, decay_std_per_s, model_decay_per_s;
  std::optional<double> radiation_decay_per_s;   ///< by the mode's radiated power (boundary elements), when asked for
  std::optional<double> mount_decay_per_kg;      ///< by a damper of 1 N s/m at each mount; empty: the specimen has none
  std::optional<double> model_frequency_std_hz;  ///< of a prediction: material, model scatter and mesh; empty: fitted
};

struct SpecimenResult {
  std::string name;
  bool predicted = false;   ///< took no part in the fit; its matches test it
  RingdownResult ringdown;  ///< not run when partials came from a table
  PartialTable partials;
  modal::ModalModel model;  ///< at the fitted parameters (full solve)
  bool none_missing = false;
  std::vector<int> unmatched_partials;
  std::vector<double> predicted_frequency_hz, predicted_decay_per_s;  ///< all modes in band
  Eigen::VectorXd mesh_relative_error;  ///< estimated error of each of them by the mesh, >= 0
  double rms_deviation_cents = 0.0, max_deviation_cents = 0.0;
  audio::Signal recorded, fitted;  ///< empty without a recording
};

struct FitOptions {
  int n_modes = 0;
  double gate_cents = 60.0;
  double model_std_cents = 2.0;  ///< added to the partials' own
  bool robust = true;
  void validate() const;  ///< @throws InputError listing every violation

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_modes", "Model modes of each specimen; 0: as the partials need", between(0.0, 2000.0)}, self.n_modes);
    visit({"gate_cents", "Widest accepted deviation of a partial from its mode", between(1.0, 600.0)}, self.gate_cents);
    visit({"model_std_cents", "How far the model itself may be off (dimensions, homogeneity), as a standard deviation",
           between(1e-3, 100.0)},
          self.model_std_cents);
    visit({"robust", "A robust loss instead of plain least squares"}, self.robust);
  }
};

struct FitResult {
  FitStatus status = FitStatus::kNotRun;
  std::string message;
  std::optional<solid::Material> material;       ///< at the solution; empty: nothing was fitted
  std::vector<FitParameter> parameters;          ///< asked ones first, then derived ones
  std::vector<std::vector<double>> correlation;  ///< of the identifiable asked parameters
  std::vector<BudgetEntry> budget;               ///< where each parameter's std comes from
  DampingResult damping;
  std::vector<PartialMatch> matches;
  std::vector<SpecimenResult> specimens;
  double cost_initial = 0.0, cost_final = 0.0;
  int n_iterations = 0;
  Judgement judgement;  ///< whether the numbers may be believed
  std::vector<std::string> warnings;
  std::map<std::string, double> wall_time_s;
  bool usable() const { return status == FitStatus::kConverged; }
};

/// The main job: partials of each specimen, matched to its modes, and the parameters that explain them all.
FitResult run_fit(const FitProblem& problem, const FitOptions& options, Monitor& monitor = silent_monitor());

}  // namespace klang::fit
