#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/physics/liquid/grid.hpp"

namespace klang::liquid {

/// Particles of liquid, sorted by cell. Velocities in single precision: they are differences of places in double.
struct Particles {
  std::vector<Eigen::Vector3d> x_m;
  std::vector<Eigen::Vector3f> v_m_s;
  std::vector<Eigen::Matrix3f> affine_per_s;  ///< row a: gradient of component a (APIC)
  std::vector<double> phi_m;                  ///< carried distance to the surface (carried_level.hpp); NaN: none yet
  std::vector<std::uint32_t> begin;           ///< n_cells + 1: where the particles of each cell begin, after sort()

  std::size_t size() const { return x_m.size(); }
  void add(const Eigen::Vector3d& x, const Eigen::Vector3f& v, const Eigen::Matrix3f& c = Eigen::Matrix3f::Zero());
  /// Counting sort by cell; particles of one cell keep their order. Those with keep = 0 are dropped.
  void sort(const GridShape& shape, const std::vector<std::uint8_t>* keep = nullptr);

 private:
  std::vector<std::uint32_t> cell_;
  std::vector<Eigen::Vector3d> x_other_;
  std::vector<Eigen::Vector3f> v_other_;
  std::vector<Eigen::Matrix3f> affine_other_;
  std::vector<double> phi_other_;
};

/// Momentum of the particles on the faces: u = sum w (v + C (x_face - x)) / sum w, w trilinear (Jiang et al. 2015). Faces out of every
/// particle's reach get 0 and no weight. Same bits on any number of threads: slabs of cells that share no face run side by side.
void particles_to_faces(const GridShape& shape, const Particles& particles, MacGrid& u, MacGrid& weight);

/// What the faces give to the particles.
struct ParticleUpdate {
  const MacGrid& u;
  const MacGrid* change;                 ///< with flip_share > 0: u after less u before
  double flip_share;                     ///< 0: APIC
  const Grid3<std::uint8_t>& at_liquid;  ///< cells in or next to the liquid; elsewhere particles fly on their own
  Eigen::Vector3f kick_m_s;              ///< what gravity gives to these
};
void faces_to_particles(const GridShape& shape, const ParticleUpdate& update, Particles& particles);

/// faces_to_particles() and advect_particles() of particles [begin, end) in one pass.
void move_particles(const GridShape& shape, const ParticleUpdate& update, double step_s, std::size_t begin,
                    std::size_t end, Particles& particles);

/// Along u, third order (Ralston); particles off the liquid straight on.
void advect_particles(const GridShape& shape, const MacGrid& u, const Grid3<std::uint8_t>& at_liquid, double step_s,
                      Particles& particles);

}  // namespace klang::liquid
