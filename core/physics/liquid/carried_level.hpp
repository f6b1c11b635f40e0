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
  /// Differences count as far as they are larger: grid and particles see a smooth wave differently, by (k h)^2 / 8 of its height.
  double least_cells = 0.02;
  double most_cells = 0.5;   ///< and no more than this
  double full_weight = 2.0;  ///< less weight around a centre than this (8 in the bulk) moves it by less
};

/// phi += sum w d_p / max(sum w, full_weight), w trilinear, d_p = phi_p - phi(x_p) less least_cells. Nothing happens
/// where particles and grid agree: rest stays rest. To be called when both were carried by one step.
void correct_by_carried(const GridShape& shape, const Particles& particles, const CarriedLevel& options, Field& phi_m);

/// What was done to phi since (redistancing, volume, inlets) is done to what particles carry: phi_p += now(x_p) - before(x_p). Particles that
/// carry nothing yet (NaN), or are deep, take now(x_p). No more than a cell from it.
/// @param before_m  phi after correct_by_carried()
void update_carried(const GridShape& shape, const Field& before_m, const Field& now_m, const CarriedLevel& options,
                    Particles& particles);

}  // namespace klang::liquid
