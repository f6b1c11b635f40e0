#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid/solid.hpp"

/// What a flow begins with and what comes in and goes out.
namespace klang::liquid {

/// A standing wave on a pool: z = level + amplitude cos(m pi x / Lx) cos(n pi y / Ly), at rest.
struct PoolWave {
  double amplitude_m = 0.0;
  int half_waves_x = 1, half_waves_y = 0;
};

/// Liquid that is there at the start: a box; sides at the domain's walls are no surface.
struct Pool {
  Eigen::Vector3d low_m, high_m;
  std::optional<PoolWave> wave;
};

struct Drop {
  double radius_m = 0.0;
  Eigen::Vector3d position_m, velocity_m_s = Eigen::Vector3d::Zero();
};

/// Where liquid comes in: through a disc, or a rectangle across one of the axes.
struct Inlet {
  std::optional<double> radius_m;                    ///< disc
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< rectangle: extent along the axes, 0 along the flow
  Eigen::Vector3d position_m, direction = -Eigen::Vector3d::UnitZ();
  double speed_m_s = 0.0, start_s = 0.0;
  double area_m2() const;
  /// The mouthpiece that it comes out of: solid, two cells long.
  Solid mouthpiece(double cell_m) const;
};

/// Where liquid leaves: what gets into this box is gone.
struct Outlet {
  Eigen::Vector3d low_m, high_m;
  double distance_m(const Eigen::Vector3d& x_m) const;  ///< below 0 inside
};

struct LiquidOptions {
  double gravity_m_s2 = 9.81;
  double density_kg_m3 = 1000.0;
  double surface_tension_n_m = 0.0726;
  bool tension = false;
  double cfl = 2.0, longest_step_s = 1e-3;
  double flip_share = 0.0;     ///< 0: APIC; 0.97: as much FLIP as is usual
  int particles_per_axis = 2;  ///< of a cell: 8 in it
  double pressure_tolerance = 1e-5;
  bool keep_volume = true;
  std::uint64_t seed = 0;  ///< of particles that are added
};

struct LiquidSetup {
  GridShape shape;
  LiquidOptions options;
  std::vector<Pool> pools;
  std::vector<Drop> drops;
  std::vector<Inlet> inlets;
  std::vector<Outlet> outlets;
  std::vector<Solid> solids;
  bool round =
      false;  ///< the same all around the axis x = 0: one layer of cells (ny = 1), no solids, inlets or outlets; volumes are a sector's

  double phi_m(const Eigen::Vector3d& x_m) const;  ///< of pools and drops at the start
  std::vector<Solid> all_solids() const;           ///< and the inlets' mouthpieces after them
};

}  // namespace klang::liquid
