#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/rigid/recording.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene {

/// A body that broke.
struct BreakEvent {
  double time_s = 0.0;
  int body = 0, n_pieces = 0;
  fracture::FractureEnergies energies;
  double crack_area_m2 = 0.0, largest_stress_pa = 0.0;
};

/// A piece, in the frame of the body that it comes from.
struct ScenePiece {
  int body = 0, parent = 0;           ///< in the world
  mesh::SurfaceMesh surface;          ///< closed; what its modes are meshed from, unless there is a mesh
  std::optional<mesh::TetMesh> mesh;  ///< of a cracking body's: its own tetrahedra, straight; slits are open
};

/// Of breakable bodies whose mesh for stress is too coarse to find what opens them across from a blow; one line each.
std::vector<std::string> coarse_stress_warnings(const Scene& scene);

/// Breaks the breakable bodies of a scene while its world moves (SB sections 3.1 to 3.3, docs/fracture.md).
///
/// After each step the impacts on a breakable body ask for its quasistatic stress at the peaks of their Hertz forces. They may put at most
/// the energy of their compression into it; where that cannot strain it up to its strength (breaking_stress.hpp) nothing is
/// solved. Where the largest tension (BreakingStress) reaches the strength and two pieces at least
/// can be paid for, the body breaks at the end of the step: it broke when it was compressed most, so what restitution gave to both bodies
/// afterwards is taken back (J / (1 + e)), and the strain energy comes out of what contacts took in this step. What is spent is booked
/// as fracture, motion of the pieces, and vibration.
class Breaking {
 public:
  /// The scene must outlive it. Factors each breakable body's stiffness. @throws InputError; NumericalError
  Breaking(const Scene& scene, std::uint64_t seed);
  ~Breaking();
  bool has_bodies() const;
  /// For rigid::RunOptions::after_step.
  std::vector<rigid::Breakage> after_step(rigid::RigidWorld& world, rigid::StepRecord& step);
  const std::vector<BreakEvent>& events() const;
  std::vector<ScenePiece> take_pieces();
  std::int64_t n_stress_solves() const;
  /// A line per breakage of which something was not found, and per body that reached its strength and stayed whole.
  std::vector<std::string> warnings() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace klang::scene
