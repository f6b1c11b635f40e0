#include "core/sound/scene/detail/breakable.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/tet_geometry.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/sound/scene/scene_bodies.hpp"

namespace klang::scene::detail {
namespace {

constexpr double kMostStressElements = 60000.0;
constexpr int kLayers = 2;  // of elements through a wall: through one the stress at its surface comes out a fifth low

mesh::TetMesh stress_mesh(const SceneBody& body) {
  SceneBody meshed = body;
  meshed.max_edge_m = stress_edge_m(body);
  if (!body.shape) return mesh_of(meshed);
  mesh::ShapeMeshOptions options;
  options.max_edge_m = meshed.max_edge_m;
  mesh::ShapeDivisions divisions = mesh::shape_divisions(*body.shape, options);
  if (body.shape->kind == "revolution")
    // Its counts are around, over the extent of the section, and halvings of the section's triangles: one, of triangles twice as long.
    divisions.counts = {divisions.counts[0], (divisions.counts[1] + 1) / 2, 1};
  else
    for (int& count : divisions.counts) count = std::max(count, kLayers);
  return mesh::mesh_shape(*body.shape, divisions, options.order);
}

fracture::FreeBodySolver& usable(fracture::FreeBodySolver& solver) {
  if (!solver.usable()) throw NumericalError(solver.message());
  return solver;
}

}  // namespace

double wall_m(const mesh::ShapeSpec& shape) { return 2.0 * mesh::shape_volume_m3(shape) / mesh::shape_area_m2(shape); }

double stress_edge_m(const SceneBody& body) {
  if (body.stress_edge_m > 0.0 || !body.shape) return body.stress_edge_m;
  // A prism of a face's side h is three tetrahedra, two of them are over a square; a wall has two faces.
  const double area_m2 = mesh::shape_area_m2(*body.shape);
  return std::max(wall_m(*body.shape), std::sqrt(3.0 * kLayers * area_m2 / kMostStressElements));
}

Breakable::Stress::Stress(const mesh::TetMesh& mesh, const solid::Material& material)
    : solver(mesh, material), responses(usable(solver)), surface(solver.mesh()), breaking(solver.mesh()) {}

Breakable::Breakable(const Scene& scene, int body) : root_(body) {
  const SceneBody& given = scene.bodies[static_cast<std::size_t>(body)];
  parent_.mesh = stress_mesh(given);
  material_ = scene.material_of(given).elastic;
  parent_.score = given.score;
  if (given.shape)
    for (Eigen::Matrix3Xd& corners_m : mesh::convex_parts(*given.shape))
      parent_.parts.push_back({std::move(corners_m)});
  const double volume_m3 =
      given.shape ? mesh::shape_volume_m3(*given.shape) : mesh::mass_properties(mesh_of(given)).volume_m3;
  set_parent(scene.material_of(given), given.name, material_.density_kg_m3 * volume_m3);
}

Breakable::Breakable(const Scene& scene, UnmeshedPiece piece, const mesh::SurfaceMesh& surface)
    : root_(piece.root), generation_(piece.generation) {
  const SceneBody& root = scene.bodies[static_cast<std::size_t>(piece.root)];
  mesh::TetgenOptions options;
  options.max_edge_m = root.stress_edge_m;
  options.in_child = true;  // TetGen ends the process on some pieces
  parent_.mesh = mesh::mesh_surface(surface, options, piece.name);
  parent_.parts = std::move(piece.parts);
  material_ = scene.material_of(root).elastic;
  material_.density_kg_m3 = piece.mass_kg / mesh::mass_properties(parent_.mesh).volume_m3;
  set_parent(scene.material_of(root), piece.name, piece.mass_kg);
}

/// @param mass_kg  of the body, which its pieces have together, whatever straight elements leave out
void Breakable::set_parent(const SceneMaterial& material, const std::string& name, double mass_kg) {
  parent_.toughness_j_m2 = *material.fracture_energy_j_m2;
  parent_.tensile_strength_pa = *material.tensile_strength_pa;
  parent_.youngs_modulus_pa = material_.youngs_modulus_pa();
  parent_.poissons_ratio = material_.poissons_ratio();
  parent_.name = name;
  // Of straight elements, as fracture_body() counts; a score is taken to run everywhere.
  const mesh::TetMesh straight = mesh::to_linear(parent_.mesh);
  Eigen::VectorXd volume_m3(straight.n_elements());
  for (int e = 0; e < straight.n_elements(); ++e) volume_m3[e] = mesh::tet_volume_m3(straight, e);
  parent_.density_kg_m3 = mass_kg / volume_m3.sum();
  parent_.validate();
  const double weakest_pa =
      parent_.tensile_strength_pa * (parent_.score ? std::min(1.0, parent_.score->strength_factor) : 1.0);
  least_j_ = fracture::BreakingStress(parent_.mesh).least_energy_j(material_, weakest_pa);
}

void Breakable::factor() {
  if (stress_) return;
  try {
    stress_ = std::make_unique<Stress>(parent_.mesh, material_);
  } catch (const NumericalError& error) {
    throw NumericalError("stress of " + parent_.name + ": " + error.what());
  }
  parent_.mesh = stress_->solver.mesh();
}

fracture::ContactResponses& Breakable::responses() {
  factor();
  return stress_->responses;
}

const fracture::SurfacePlaces& Breakable::surface() {
  factor();
  return stress_->surface;
}

const fracture::BreakingStress& Breakable::breaking_stress() {
  factor();
  return stress_->breaking;
}

}  // namespace klang::scene::detail
