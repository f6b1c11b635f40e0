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
  double tolerance = 0.01;           ///< relative error of interpolated frequencies, 1e-4 to 0.2
  double thinnest = 0.04;            ///< smallest a/c, 0.01 to 0.9
  int n_checked_modes = 10;          ///< 1 to modes_per_cell
  int modes_per_cell = 16;           ///< 1 to 40
  int degree = 14;                   ///< of the polynomials, 6 to 24
  int max_halvings = 20;             ///< depth of the tree, 2 to 30
  int check_shapes = 100;            ///< random shapes a round of independent checks, 1 to 100000
  bool radiation = true;             ///< false: frequencies only
  double boundary_tolerance = 5e-3;  ///< of the radiation, EllipsoidRadiationOptions
  void validate() const;             ///< InputError
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
