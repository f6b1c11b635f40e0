#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <vector>

#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid/level_set.hpp"
#include "core/physics/liquid/particles.hpp"
#include "core/physics/liquid/pressure.hpp"
#include "core/physics/liquid/solid.hpp"

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
};

/// What a step did. Volumes since the start.
struct LiquidStep {
  double time_s = 0.0, step_s = 0.0;
  double volume_m3 = 0.0, inflow_m3 = 0.0, outflow_m3 = 0.0;
  double drift_relative = 0.0;  ///< of the volume against start + inflow - outflow
  double max_speed_m_s = 0.0;
  PressureSolve pressure;
  std::size_t n_particles = 0;
};

/// A liquid with a free surface in a box, by particles and a level set (FLIP/APIC; Zhu & Bridson 2005, Jiang et al. 2015). Places at times
/// t, velocities half a step later (leapfrog: free fall is exact). Same setup, same bits on any number of threads.
class Liquid {
 public:
  explicit Liquid(LiquidSetup setup);

  /// The longest step that options allow now.
  double step_limit_s() const;
  LiquidStep step(double step_s);
  /// One or more steps that end exactly at time_s; after each one on_step is called.
  template <class OnStep>
  void advance_to(double time_s, const OnStep& on_step) {
    while (time_s - time_s_ > 1e-12 * (1.0 + time_s)) {
      const double left = time_s - time_s_;
      const double n = std::ceil(left / step_limit_s() - 1e-9);
      LiquidStep report = step(n <= 1.0 ? left : left / n);
      if (n <= 1.0) report.time_s = time_s_ = time_s;
      on_step(report);
    }
  }

  double time_s() const { return time_s_; }
  const LiquidSetup& setup() const { return setup_; }
  const GridShape& shape() const { return setup_.shape; }
  const Field& phi_m() const { return phi_; }  ///< signed distance out to some cells from the surface
  Field distance_m() const;                    ///< the same to the full depth
  const MacGrid& velocity_m_s() const { return u_; }
  const Field& pressure_m2_s2() const { return pressure_; }
  const Particles& particles() const { return particles_; }
  const SolidField& solid_field() const { return solid_; }
  const std::vector<Solid>& solids() const { return solids_; }
  double volume_m3() const { return volume_; }
  double start_volume_m3() const { return start_volume_; }
  double centre_of_mass_z_m() const;

  /// Everything that the next step depends on, as bytes; load() of the same setup goes on with the same bits.
  void save(std::ostream& out) const;
  /// @throws InputError where the bytes are of another setup or cut off
  void load(std::istream& in);

 private:
  bool streams(const Inlet& inlet) const;
  void seed_particles();
  void set_solid_faces(FaceMask& known);
  void move_solids(double step_s);
  void emit(double step_s);
  void drain();
  void push_out();
  void keep_density();
  void keep_volume();
  void open_carried();  ///< what inlets and outlets did to phi, also to what particles carry of it
  void find_near_liquid(const Grid3<std::uint8_t>& liquid);
  double max_speed() const;

  LiquidSetup setup_;
  std::vector<Solid> solids_;  ///< those of the scene, then the inlets' mouthpieces
  SolidField solid_;
  Particles particles_;
  std::vector<std::uint8_t> keep_;
  Field phi_, pressure_;
  MacGrid u_;
  Grid3<std::uint8_t> at_liquid_;
  double time_s_ = 0.0, pending_kick_s_ = 0.0;
  std::uint64_t n_steps_ = 0;
  double volume_ = 0.0, start_volume_ = 0.0, inflow_ = 0.0, outflow_ = 0.0;
  double source_per_s_ = 0.0;    ///< divergence of the next step's flow, see keep_volume()
  std::vector<double> emitted_;  ///< per inlet: part of a particle that is due
};

}  // namespace klang::liquid
