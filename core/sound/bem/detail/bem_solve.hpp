#pragma once
#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>

#include "core/sound/bem/detail/assembly.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"

namespace klang::acoustics::detail {

struct BemSystem {
  const BemGeometry& geometry;
  const Assembly& assembly;
  Eigen::Index n_columns;  ///< of the velocities
  const BemOptions& options;
  Monitor& monitor;
};

struct BemSolution {
  bool done = false;    ///< an answer, solved or not; false: the device could not do it, and message says why
  bool solved = false;  ///< to the tolerance
  std::string message, device = "processor";
  Eigen::MatrixXcd x;  ///< n_vertices x n_columns
  std::optional<double> relative_residual;
  int n_refinements = 0, n_products = 0;
  bool double_factor = false;
  std::map<std::string, double> wall_time_s;
};

/// @param parts  what the assembly's columns are: parts of the system's columns, by class
BemSolution solve_on_processor(const BemSystem& system, const std::vector<MirrorClasses::Part>& parts);

/// The surface must be without mirrors. Calls from several threads take turns on the device; what the processor does for them runs beside it.
BemSolution solve_on_device(const BemSystem& system);

}  // namespace klang::acoustics::detail
