#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <vector>

#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid/level_set.hpp"
#include "core/physics/liquid/liquid_setup.hpp"
#include "core/physics/liquid/particles.hpp"
#include "core/physics/liquid/pressure.hpp"
#include "core/physics/liquid/solid.hpp"

namespace klang::liquid {

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
