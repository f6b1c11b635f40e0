#include "core/sound/scene/scene_bodies.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/geometry/shapes/round_surfaces.hpp"
#include "core/geometry/shapes/surface_curvature.hpp"
#include "core/physics/rigid/convex_parts.hpp"
#include "core/sound/scene/detail/link_reader.hpp"

namespace klang::scene {
namespace {

using Eigen::Vector3d;

constexpr double kOverlap = 1e-4;  // of the smaller body's size

std::optional<double> ball_radius_m(const SceneBody& body) {
  if (!body.shape) return {};
  const auto& dims = body.shape->dims;
  if (body.shape->kind == "sphere") return dims.at("radius_m");
  if (body.shape->kind != "ellipsoid" || dims.at("a_m") != dims.at("b_m") || dims.at("b_m") != dims.at("c_m"))
    return {};
  return dims.at("a_m");
}

mesh::TetMesh loaded(const SceneBody& body, double max_edge_m, const SceneNotes& notes, Monitor& monitor) {
  mesh::LoadOptions options;
  options.unit_m = body.unit_m;
  options.max_edge_m = max_edge_m;
  mesh::BodyNotes heard;
  heard.note = [&](const std::string& text) {
    if (notes.note) notes.note("body " + body.name + ": " + text);
  };
  heard.warning = [&](const std::string& text) {
    if (notes.warning) notes.warning("body " + body.name + ": " + text);
  };
  mesh::TetMesh mesh = mesh::load_body(body.mesh, options, &heard, monitor);
  for (const std::string& warning : mesh::body_warnings(mesh, body.unit_m, "unit_m"))
    heard.warning(body.mesh.string() + ": " + warning);
  return mesh;
}

/// As few tetrahedra as the surface allows, for convex parts; a file of tetrahedra as it is.
mesh::TetMesh coarse_mesh(const SceneBody& body, const mesh::TetMesh& loaded, Monitor& monitor) {
  if (!mesh::is_surface_file(body.mesh)) return loaded;
  mesh::SurfaceRepairs repairs;
  mesh::SurfaceMesh surface = mesh::read_mended_surface(body.mesh, repairs);
  surface.vertices_m *= body.unit_m;
  mesh::TetgenOptions options;
  options.order = 1;
  options.radius_edge_ratio = 10.0;
  options.min_dihedral_deg = 0.0;
  options.in_child = true;
  return mesh::mesh_surface(surface, options, body.mesh.string(), monitor);
}

void set_mass(rigid::RigidBodySpec& rigid, const mesh::MassProperties& mass, double volume_m3, double density_kg_m3) {
  rigid.mass_kg = density_kg_m3 * volume_m3;
  rigid.centre_m = mass.centre_m;
  rigid.inertia_kg_m2 = rigid.mass_kg / mass.volume_m3 * mass.inertia_m5;
}

}  // namespace

mesh::TetMesh mesh_of(const SceneBody& body, const SceneNotes& notes, Monitor& monitor) {
  return located(body.place, [&] {
    if (!body.shape) return loaded(body, body.max_edge_m, notes, monitor);
    mesh::ShapeMeshOptions options;
    options.max_edge_m = body.max_edge_m;
    return mesh::mesh_shape(*body.shape, options);
  });
}

rigid::RigidBodySpec rigid_body_of(const Scene& scene, const SceneBody& body, const SceneNotes& notes,
                                   Monitor& monitor) {
  return located(body.place, [&] {
    const SceneMaterial& material = scene.material_of(body);
    rigid::RigidBodySpec rigid;
    rigid.name = body.name;
    if (const auto radius_m = ball_radius_m(body)) {
      rigid = rigid::ball(body.name, *radius_m, material.elastic.density_kg_m3 * mesh::shape_volume_m3(*body.shape));
    } else if (body.shape) {
      const mesh::TetMesh mesh = mesh::mesh_shape(*body.shape);
      set_mass(rigid, mesh::mass_properties(mesh), mesh::shape_volume_m3(*body.shape), material.elastic.density_kg_m3);
      for (const std::string& warning : mesh::body_warnings(mesh, 1.0, {}))
        if (notes.warning) notes.warning("body " + body.name + ": " + warning);
      for (Eigen::Matrix3Xd& corners_m : mesh::convex_parts(*body.shape)) rigid.parts.push_back({std::move(corners_m)});
      rigid.round = mesh::round_surfaces(*body.shape);
      rigid.curvature = mesh::surface_curvature(*body.shape, rigid.touch_radius_m());
    } else {
      const mesh::TetMesh mesh = loaded(body, 0.0, notes, monitor);
      const mesh::MassProperties mass = mesh::mass_properties(mesh);
      set_mass(rigid, mass, mass.volume_m3, material.elastic.density_kg_m3);
      rigid.parts = rigid::convex_parts_of(coarse_mesh(body, mesh, monitor), body.mesh.string());
    }
    rigid.skin = skin_of(material);
    rigid.position_m = body.position_m;
    rigid.orientation = orientation_of(body.rotation_deg);
    rigid.velocity_m_s = body.velocity_m_s;
    rigid.angular_velocity_rad_s = body.angular_velocity_rad_s;
    rigid.fixed = body.fixed;
    if (body.fixed && (body.velocity_m_s.norm() > 0.0 || body.angular_velocity_rad_s.norm() > 0.0))
      throw InputError("velocity_m_s", "a fixed body does not move");
    return rigid;
  });
}

rigid::RigidWorld world_of(const Scene& scene, const SceneNotes& notes, Monitor& monitor) {
  rigid::RigidWorld world(scene.solver);
  double smallest_m = HUGE_VAL;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    monitor.throw_if_stopped();
    monitor.progress("bodies", static_cast<double>(i) / static_cast<double>(scene.bodies.size()));
    const rigid::RigidBodySpec rigid = rigid_body_of(scene, scene.bodies[i], notes, monitor);
    smallest_m = std::min(smallest_m, rigid.size_m());
    located(scene.bodies[i].place, [&] { return world.add(rigid); });
  }
  detail::add_links(scene.links, world);
  if (const auto overlap = world.overlap(kOverlap * smallest_m)) {
    const SceneBody& body = scene.bodies[static_cast<std::size_t>(overlap->a)];
    const std::string other = overlap->b < 0 ? "the floor" : scene.bodies[static_cast<std::size_t>(overlap->b)].name;
    throw InputError(body.place, body.name + " and " + other + " overlap", to_text(overlap->depth_m) + " m deep",
                     "bodies apart or just touching");
  }
  return world;
}

}  // namespace klang::scene
