#pragma once
#include <memory>
#include <vector>

#include "core/physics/fracture/event/fracture_body.hpp"
#include "core/physics/fracture/quasistatic/breaking_stress.hpp"
#include "core/physics/fracture/quasistatic/contact_responses.hpp"
#include "core/physics/fracture/quasistatic/surface_places.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene::detail {

/// A piece that may break in its turn, before it is asked for the first time.
struct UnmeshedPiece {
  std::size_t piece = 0;  ///< row of the run's pieces, which hold its surface
  std::vector<rigid::ConvexPart> parts;
  std::string name;
  double mass_kg = 0.0;
  int root = 0;        ///< body of the scene that it comes from
  int generation = 1;  ///< 1: a piece of a body of the scene
};

/// Edge of a breakable body's mesh for stress: the scene's, or the wall (twice the volume over the surface) as long as that makes no more
/// than some 60,000 elements; 0 of a file without one, whose own elements are taken.
double stress_edge_m(const SceneBody& body);
/// Twice the volume over the surface: the thickness of what is thin.
double wall_m(const mesh::ShapeSpec& shape);

/// What one breakable body needs to be asked for its stress. Its stiffness is factored when that is first needed.
class Breakable {
 public:
  /// A body of the scene. @throws InputError
  Breakable(const Scene& scene, int body);
  /// A piece, meshed anew from its surface; its density is such that the mesh has the piece's mass. @throws InputError: no mesher takes it
  Breakable(const Scene& scene, UnmeshedPiece piece, const mesh::SurfaceMesh& surface);

  const solid::Material& material() const { return material_; }
  const fracture::ParentBody& parent() const { return parent_; }
  int root() const { return root_; }
  int generation() const { return generation_; }
  /// With less strain energy than that it does not break, whatever the load (breaking_stress.hpp).
  double least_energy_j() const { return least_j_; }

  /// @throws InputError; NumericalError: the stiffness cannot be factored
  void factor();
  fracture::ContactResponses& responses();
  const fracture::SurfacePlaces& surface();
  const fracture::BreakingStress& breaking_stress();

 private:
  struct Stress {
    Stress(const mesh::TetMesh& mesh, const solid::Material& material);
    fracture::FreeBodySolver solver;
    fracture::ContactResponses responses;
    fracture::SurfacePlaces surface;
    fracture::BreakingStress breaking;
  };
  void set_parent(const SceneMaterial& material, const std::string& name, double mass_kg);

  solid::Material material_;
  fracture::ParentBody parent_;
  int root_ = 0, generation_ = 0;
  double least_j_ = 0.0;
  std::unique_ptr<Stress> stress_;
};

}  // namespace klang::scene::detail
