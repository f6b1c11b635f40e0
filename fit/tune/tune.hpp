#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {

/// A mode that is to sound at a frequency.
struct TuneTarget {
  std::string mode = "0";  ///< elastic mode index from 0, or "bending 1" (tube, rod, box: n-th flexural frequency)
  double frequency_hz = 0.0;
  std::string over = {};  ///< another mode; then ratio is what counts
  double ratio = 0.0;     ///< of the frequencies of mode and over

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"mode", "Index of the elastic mode from 0, or \"bending N\""}, self.mode);
    visit({"frequency_hz", "What it is to sound at", between(0.0, 1e6)}, self.frequency_hz);
    visit({"over", "Another mode; then the ratio is what counts"}, self.over);
    visit({"ratio", "Of the two", between(0.0, 1e3)}, self.ratio);
  }
};

struct TuneOptions {
  std::vector<std::string> dimensions;  ///< of the shape, e.g. {"length_m"}
  std::vector<TuneTarget> targets;
  double widest_change = 0.2;
  double tolerance_cents = 0.05;  ///< of the full model
  int max_rounds = 8;
  void validate(const Specimen& specimen) const;  ///< @throws InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"dimensions", "Dimensions that may change"}, self.dimensions);
    visit({"targets", "Modes and what they are to sound at"}, self.targets);
    visit({"widest_change", "Share of its start that a dimension may change by", between(0.001, 0.5)},
          self.widest_change);
    visit({"tolerance_cents", "Accepted deviation", between(1e-4, 100.0)}, self.tolerance_cents);
    visit({"max_rounds", "Rounds of meshing anew", between(1.0, 50.0)}, self.max_rounds);
  }
};

enum class TuneStatus { kNotRun, kReached, kNotReached };
constexpr auto words_of(TuneStatus) {
  return std::array{Word{TuneStatus::kNotRun, "not_run"}, Word{TuneStatus::kReached, "reached"},
                    Word{TuneStatus::kNotReached, "not_reached"}};
}

struct TunedDimension {
  std::string name;
  double start_m = 0.0, value_m = 0.0, low_m = 0.0, high_m = 0.0;
  bool at_bound = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the dimension"}, self.name);
    visit({"start_m", "as it was"}, self.start_m);
    visit({"value_m", "as it should be"}, self.value_m);
    visit({"low_m", "its lower bound"}, self.low_m);
    visit({"high_m", "its upper bound"}, self.high_m);
    visit({"at_bound", "it could not go further"}, self.at_bound);
  }
};

struct TunedTarget {
  std::string mode;
  int mode_index = -1;
  double wanted_hz = 0.0, start_hz = 0.0, reached_hz = 0.0;
  double residual_cents = 0.0;             ///< reached against wanted
  std::vector<double> hz_per_mm;           ///< one per dimension
  std::vector<double> cents_per_tenth_mm;  ///< what a cut 0.1 mm off costs
};

struct TuneResult {
  TuneStatus status = TuneStatus::kNotRun;
  std::string message;
  std::vector<TunedDimension> dimensions;
  std::vector<TunedTarget> targets;
  mesh::ShapeSpec shape;  ///< the tuned body
  int n_rounds = 0;
  std::map<std::string, double> wall_time_s;
  bool usable() const { return status == TuneStatus::kReached; }
};

/// Dimensions that bring modes to wanted frequencies. Each round meshes the body, projects it with its neighbours
/// (ReducedSpectrum), solves there for the dimensions, and ends when the mesh at the solution agrees within
/// tolerance_cents. With fewer targets than dimensions the smallest relative change is taken.
/// @throws InputError: no shape, unknown dimension or mode, frequency not positive, more targets than dimensions by which
///         nothing can be solved for
TuneResult tune_dimensions(const Specimen& specimen, const solid::Material& material, const TuneOptions& options,
                           Monitor& monitor = silent_monitor());

/// Modes of the flexural families of a long body, by their n: families[n - 1] lists the (one or two, or more for a flat
/// bar) modes in which cross-sections move sideways as a whole with n + 1 nodes. Empty for other shapes.
std::vector<std::vector<int>> bending_modes(const mesh::ShapeSpec& shape, const modal::ModalModel& model);

}  // namespace klang::fit
