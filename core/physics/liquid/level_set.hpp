#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid/particles.hpp"
#include "core/physics/liquid/solid.hpp"

namespace klang::liquid {

/// phi < 0 in the liquid, at cell centres.

/// Carries phi along with u where |phi| < band_m: back along the flow (third order), tricubic, within the values around.
/// The sharp kinks that cubic interpolation would ring at keep linear interpolation.
void advect_level_set(const GridShape& shape, const MacGrid& u, double step_s, double band_m, Field& phi_m);

/// Makes phi a signed distance. Next to the surface, and where |phi| < keep_m and its slope is near 1, values stay; the others follow by
/// fast sweeping (Zhao 2005) out to reach_m, beyond which |phi| = reach_m.
void redistance(const GridShape& shape, double keep_m, double reach_m, Field& phi_m);

/// Volume of phi < 0 in the open part of the cells: each cell cut by the plane of phi's value and slope at its centre (exact for planes), put
/// where it halves what the surface bends (drops of 2 cells of radius were 6 % too large without it).
double liquid_volume_m3(const GridShape& shape, const Field& phi_m, const SolidField& solid, double shift_m = 0.0);

/// Share of a cell that is liquid, by the same cut; its sum is that volume.
double wet_share(const Field& phi_m, const SolidField& solid, double cell_m, const std::array<int, 3>& cell,
                 double shift_m = 0.0);

/// Shifts the surface, by most_m at most, so that the volume is the one asked for.
struct VolumeShift {
  double before_m3, volume_m3;  ///< without the shift, and with it
  double shift_m;               ///< that phi grew by
};
VolumeShift shift_to_volume(const GridShape& shape, const SolidField& solid, double volume_m3, double most_m,
                            Field& phi_m);

/// Share of a unit cube around 0 where value + slope . x < 0 (Scardovelli & Zaleski 2000).
double plane_fraction(double value, const Eigen::Vector3d& slope);

/// Slope of phi by central differences; at the box's walls even continuation (contact angle 90 degrees).
Eigen::Vector3d slope_at(const Field& phi_m, double cell_m, int i, int j, int k);

/// div (grad phi / |grad phi|) at a centre: 2/R on a drop.
double curvature_per_m(const Field& phi_m, double cell_m, int i, int j, int k);

/// Fills faces that are not known from those that are, layer by layer with the mean of known neighbours; faces of the box's walls stay.
/// @param slopes  the first layer goes on with the slope across it where two differences agree in sign, by the smaller one
/// @param known   per face of each axis, 1 where it counts; becomes 1 where a value was given
struct FaceMask {
  std::array<Grid3<std::uint8_t>, 3> faces;
  Grid3<std::uint8_t>& operator[](int axis) { return faces[static_cast<std::size_t>(axis)]; }
  const Grid3<std::uint8_t>& operator[](int axis) const { return faces[static_cast<std::size_t>(axis)]; }
};
void extrapolate(const GridShape& shape, int layers, bool slopes, MacGrid& u, FaceMask& known);

/// The first layer of air carries on what the liquid does: div u = 0 there too, the difference put on the faces that lead away from
/// the surface. Without it the surface's speed is of first order. @param liquid  cells of the solver  @param round  see sector_field()
void continue_into_air(const GridShape& shape, const Field& phi_m, const Grid3<std::uint8_t>& liquid,
                       const FaceMask& valid, bool round, MacGrid& u);

/// Where particles know better than the level set.
struct ParticleCorrection {
  double outside_cells =
      0.1;  ///< a particle that is outside by more brings a ball of liquid with it (Enright et al. 2002, inside only)
  double radius_cells = 0.3;  ///< of the ball
  double reach_cells = 0.8;   ///< liquid farther than this from every particle ends
};
/// @return how many cells changed sign
std::size_t correct_by_particles(const GridShape& shape, const Particles& particles, const SolidField& solid,
                                 const ParticleCorrection& correction, Field& phi_m);

}  // namespace klang::liquid
