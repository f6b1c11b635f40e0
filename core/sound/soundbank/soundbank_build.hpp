#pragma once
#include <functional>
#include <map>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/soundbank/ellipsoid_radiation.hpp"
#include "core/sound/soundbank/soundbank.hpp"

namespace klang::soundbank {

struct BuildOptions {
  solid::Material material;  ///< Poisson's ratio decides about the frequencies, the wave speed about the radiation
  acoustics::Medium medium;
  double tolerance = 0.01;
  double thinnest = 0.04;    ///< smallest a/c
  int n_checked_modes = 10;  ///< at most modes_per_cell
  int modes_per_cell = 16;
  int degree = 14;
  int max_halvings = 20;
  int check_shapes = 100;  ///< of each round of independent checks
  bool radiation = true;
  double boundary_tolerance = 5e-3;  ///< EllipsoidRadiationOptions
  void validate() const;             ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"medium", "The fluid around"}, self.medium);
    visit({"tolerance", "Relative error of interpolated frequencies", between(1e-4, 0.2)}, self.tolerance);
    visit({"thinnest", "Smallest ratio of the shortest axis to the longest", between(0.01, 0.9)}, self.thinnest);
    visit({"n_checked_modes", "Modes to which the tolerance applies", between(1.0, 40.0)}, self.n_checked_modes);
    visit({"modes_per_cell", "Modes of each cell", between(1.0, 40.0)}, self.modes_per_cell);
    visit({"degree", "Of the polynomials of the displacements", between(6.0, 24.0)}, self.degree);
    visit({"max_halvings", "Depth of the tree of shapes", between(2.0, 30.0)}, self.max_halvings);
    visit({"check_shapes", "Unseen shapes of the last check", between(1.0, 100000.0)}, self.check_shapes);
    visit({"radiation", "The sound of the modes, too; otherwise modes and frequencies only"}, self.radiation);
    visit({"boundary_tolerance", "Relative error of the normal velocity of the radiation", between(1e-8, 0.1)},
          self.boundary_tolerance);
  }
};

/// What a stopped build has already done; good for the same options only.
struct BuildProgress {
  std::map<ShapePoint, ClassFrequencies> frequencies;
  std::map<ShapePoint, Cell> cells;
};

enum class BuildStatus { kNotRun, kDone, kToleranceNotReached };
struct BuildResult {
  BuildStatus status = BuildStatus::kNotRun;
  std::string message;
  Soundbank bank;
  int n_eigen_solves = 0;
};

/// Samples the shapes adaptively. The triangle sphere-pancake-cigar in (ln a/c, ln b/c) is halved (newest vertex, conforming) wherever
/// the quadratic interpolation of ln(frequency), class by class, misses the direct solution at four points inside a triangle by more than 0.6
/// tolerance; then random shapes are solved directly and the triangles that miss one are halved, until a round of fresh shapes
/// passes: its largest error is reported. Cells with sound stand at the corners of the triangles.
/// The same bits on any number of threads.
/// @param saved  called now and then with all that is done (from one thread at a time)
BuildResult build_soundbank(const BuildOptions& options, Monitor& monitor = silent_monitor(),
                            BuildProgress progress = {}, const std::function<void(const BuildProgress&)>& saved = {});

}  // namespace klang::soundbank
