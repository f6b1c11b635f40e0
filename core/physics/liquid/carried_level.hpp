#pragma once
#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid/particles.hpp"

namespace klang::liquid {

/// Particles near the surface carry phi along their paths, where nothing smears it (as in Hieber & Koumoutsakos 2005, but only as a memory
/// of what the grid's phi loses at corners and films whenever it is interpolated).

/// How the grid's phi follows what particles carry.
struct CarriedLevel {
  double near_cells = 1.5;  ///< particles whose |phi| is less take part
  double band_cells = 3.0;  ///< and cells whose |phi| is less
  /// Smaller differences do not count: grid and particles see a smooth wave differently, by (k h)^2 / 8 of its height.
  double least_cells = 0.02;
  double most_cells = 0.5;   ///< no difference counts for more than this
  double full_weight = 2.0;  ///< less weight around a centre than this (8 in the bulk) moves it by less
  /// Where the slope of phi is within so much of 1 and its curvature times the cell is below so much, the grid loses nothing; farther than
  /// poor_reach_cells from where that is not so, particles take its phi. With a memory everywhere a wave of 70 cells and 3/4 of a cell
  /// gained 1.5 % of energy per period.
  double resolved_slope = 0.2, resolved_bend = 0.1;
  int poor_reach_cells = 4;
};

/// phi += sum w d_p / max(sum w, full_weight), w trilinear, d_p = phi_p - phi(x_p) where it is larger than least_cells. Nothing happens
/// where particles and grid agree: rest stays rest. To be called when both were carried by one step.
void correct_by_carried(const GridShape& shape, const Particles& particles, const CarriedLevel& options, Field& phi_m);

/// What happened to the surface in a step, as particles are told of it.
struct CarriedStep {
  const MacGrid& u;
  double step_s = 0.0;
};

/// phi_p grows as the flow stretches it along the normal n: d phi_p / dt = phi_p n . (n . grad) u. What the grid does to phi (redistancing,
/// balls of particles that it had lost, shifts of the surface that keep the volume) it is not told: the grid would teach it its own loss.
/// Particles that carry nothing yet (NaN), are deep, or lie where the grid resolves phi, take phi(x_p). No more than a cell from it.
void update_carried(const GridShape& shape, const Field& phi_m, const CarriedStep& step, const CarriedLevel& options,
                    Particles& particles);

}  // namespace klang::liquid
