#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid/solid.hpp"

namespace klang::liquid {

struct PressureOptions {
  double kick_s = 1e-3;           ///< for how long the pressure acts
  double density_kg_m3 = 1000.0;  ///< of the liquid; moves free solids
  double tension_m3_s2 = 0.0;     ///< surface tension over density; 0: none
  double source_per_s = 0.0;      ///< divergence that is asked for, where a free surface lets it out
  double tolerance = 1e-5;  ///< of the flux that is left in a cell, over the largest speed and the kick of gravity
  int most_iterations = 2000;
};

struct PressureSolve {
  bool converged = false;
  int iterations = 0;
  double max_divergence = 0.0;  ///< max |div u| times kick_s, what was asked for included
  std::size_t n_unknowns = 0;
};

/// What the pressure changes.
struct Flowing {
  MacGrid& u;
  Field& pressure;  ///< [m2/s2], kinematic, at centres: first guess and result; 0 in air
};

/// Makes the velocity free of divergence where phi < 0 (Batty et al. 2007: shares of faces that solids leave open; Gibou et al. 2002:
/// p is that of the surface where phi = 0; Kang et al. 2000: tension as a jump there). Conjugate gradients with modified incomplete
/// Cholesky (Bridson 2015, sec. 5.3). Free solids take part: the pressure's force moves them in the same solve.
/// @param solids  velocities of free ones are changed
PressureSolve project(const GridShape& shape, const Field& phi_m, const SolidField& open, std::vector<Solid>& solids,
                      const Flowing& flow, const PressureOptions& options);

/// Whether a cell is liquid to the solver: phi < 0 and some face open.
Grid3<std::uint8_t> liquid_cells(const GridShape& shape, const Field& phi_m, const SolidField& open);

}  // namespace klang::liquid
