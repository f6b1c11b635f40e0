#pragma once
#include <complex>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/events/event_log.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/scene/scene.hpp"
#include "core/sound/stage/impact_pulses.hpp"

namespace klang::scene {

/// A bending mode of a slab that is pinned along its edges: displacement W sin(m pi x / a) sin(n pi y / b).
struct SlabMode {
  int m = 1, n = 1;
  double angular_frequency_rad_s = 0.0;
  double amplitude = 0.0;  ///< W, mass-normalised [1/sqrt(kg)]
};

/// Modes of the lower branch of a thick plate (shear and rotary inertia, shear coefficient 5/6), by frequency, of the band, the lowest
/// n_modes of them. SB's concrete slab holds 84 plate waves of all kinds below 700 Hz and 5040 below 4 kHz (erratum 54): band and
/// count are given apart.
/// Source: Mindlin 1951, J. Appl. Mech. 18, 31-38, whose determinant for pinned edges is a quadratic in omega^2.
std::vector<SlabMode> slab_modes(const FloorSound& floor, const solid::Material& material);

/// Pressure of a baffled slab that moves in one mode with unit modal velocity, by Rayleigh's integral
///   p = i omega rho / (2 pi) int u e^{-ikr} / r dS [Pa]
/// @param place_m  from the slab's corner, z above it, != 0
std::complex<double> slab_pressure_pa(const SlabMode& mode, const FloorSound& floor, const Eigen::Vector3d& place_m);

/// What the floor itself sounds like: the slab is struck where a body strikes the floor, off its centre (0.37 and 0.43 of its sides; a
/// blow at the centre, as in SB, excites a quarter of the modes), by the force along z. Places of contacts within 0.3 m are
/// taken together, up to twelve of them.
struct FloorHeard {
  audio::Signal sound_pa;
  int n_modes = 0, n_places = 0;
};
/// How long the slab rings on to -60 dB, as ring_time_s() of bodies; 0 without a sounding floor.
double floor_ring_time_s(const Scene& scene);

/// @param pulses  impact_pulses()
FloorHeard floor_sound_of(const Scene& scene, const events::EventLog& log, const stage::ImpactPulses& pulses,
                          double duration_s, Monitor& monitor = silent_monitor());

}  // namespace klang::scene
