#include "core/sound/scene/detail/held_nodes.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::scene::detail {
namespace {

constexpr double kAway = 0.1;  ///< of the body's size: a place farther from all nodes is none of it

int nearest_node(const mesh::TetMesh& mesh, const Eigen::Vector3d& place_m) {
  Eigen::Index nearest = 0;
  (mesh.nodes_m.rowwise() - place_m.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
  return static_cast<int>(nearest);
}

double size_of(const mesh::TetMesh& mesh) {
  return (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
}

/// As joints_of() takes them for the motion: of the nearest corners of the surface.
int joint_node(const SceneJoint& joint, const mesh::TetMesh& mesh) {
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
  int nearest = surface.triangles(0, 0);
  const auto far = [&](int node) { return (mesh.nodes_m.row(node).transpose() - joint.at_m).norm(); };
  for (const int node : surface.triangles.leftCols(3).reshaped())
    if (far(node) < far(nearest) || (far(node) == far(nearest) && node < nearest)) nearest = node;
  require_near(joint, far(nearest), size_of(mesh));
  return nearest;
}

std::string text_of(const Eigen::Vector3d& x) { return to_text(x[0]) + "," + to_text(x[1]) + "," + to_text(x[2]); }

std::vector<int> nodes_under(const SceneHold& hold, const mesh::TetMesh& mesh) {
  if (!hold.at_m) return solid::held_nodes(solid::parse_support("clamped:" + hold.where), mesh);
  const int nearest = nearest_node(mesh, *hold.at_m);
  const double far = (mesh.nodes_m.row(nearest).transpose() - *hold.at_m).norm();
  if (!(far <= kAway * size_of(mesh)))
    throw InputError("at_m", "is away from the body", to_text(far) + " m", "a place of the body");
  return {nearest};
}

}  // namespace

std::vector<HeldNodes> held_nodes_of(const Scene& scene, int row, const mesh::TetMesh& mesh) {
  std::vector<HeldNodes> found;
  std::vector<bool> is_held(static_cast<std::size_t>(mesh.n_nodes()), false);
  for (const SceneHold& hold : scene.holds) {
    if (hold.body != row) continue;
    located(hold.place, [&] {
      HeldNodes held{&hold, nodes_under(hold, mesh)};
      for (const int node : held.nodes) {
        if (is_held[static_cast<std::size_t>(node)])
          throw InputError(hold.at_m ? "at_m" : "where", "contradicts another hold of the same nodes",
                           scene.bodies[static_cast<std::size_t>(row)].name, "places that only one hold moves");
        is_held[static_cast<std::size_t>(node)] = true;
      }
      found.push_back(std::move(held));
      return 0;
    });
  }
  return found;
}

namespace {

struct Kept {
  int row = -1;
  std::vector<const SceneHold*> holds;
  std::vector<const SceneJoint*> joints;
};

Kept kept_places(const Scene& scene, const SceneBody& body) {
  Kept kept;
  if (body.model != BodyModel::kModal) return kept;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (scene.bodies[i].name == body.name) kept.row = static_cast<int>(i);
  for (const SceneHold& hold : scene.holds)
    if (hold.body == kept.row) kept.holds.push_back(&hold);
  for (const SceneJoint& joint : scene.joints)
    if (joint.body == kept.row && joint.other < 0) kept.joints.push_back(&joint);
  return kept;
}

}  // namespace

void require_near(const SceneJoint& joint, double far_m, double size_m) {
  if (!(far_m <= kAway * size_m))
    throw InputError(joint.place, "at_m is far from every corner of the body's surface mesh", to_text(far_m) + " m",
                     "up to " + to_text(kAway * size_m) + " m, a tenth of its size (max_edge_m has finer meshes)");
}

KeptBy kept_by(const Scene& scene, const SceneBody& body) {
  const Kept kept = kept_places(scene, body);
  const bool starts = !body.velocity_m_s.isZero(0.0) || !body.angular_velocity_rad_s.isZero(0.0);
  if (std::any_of(kept.holds.begin(), kept.holds.end(), [&](const SceneHold* hold) {
        return !hold->path.is_still() || (starts && hold->path.kind() == fracture::HoldKind::kAcceleration);
      }))
    return KeptBy::kMovingPlaces;
  return kept.holds.empty() && kept.joints.empty() ? KeptBy::kNothing : KeptBy::kStillPlaces;
}

std::string kept_key(const Scene& scene, const SceneBody& body) {
  std::string key;
  if (kept_by(scene, body) != KeptBy::kStillPlaces) return key;
  const Kept kept = kept_places(scene, body);
  for (const SceneHold* hold : kept.holds) key += "hold " + (hold->at_m ? text_of(*hold->at_m) : hold->where) + ";";
  for (const SceneJoint* joint : kept.joints) key += "joint " + text_of(joint->at_m) + ";";
  return key;
}

solid::Support still_support_of(const Scene& scene, const SceneBody& body, mesh::TetMesh& mesh) {
  constexpr const char* kSet = "what the world keeps";
  if (kept_by(scene, body) != KeptBy::kStillPlaces) return {};
  const Kept kept = kept_places(scene, body);
  const std::vector<HeldNodes> holds = held_nodes_of(scene, kept.row, mesh);
  if (holds.size() == 1 && kept.joints.empty() && !holds[0].hold->at_m)
    return {solid::SupportKind::kClamped, holds[0].hold->where};  // a whole face of a box is known by polynomials
  std::vector<int>& nodes = mesh.node_sets[kSet];
  for (const HeldNodes& hold : holds) nodes.insert(nodes.end(), hold.nodes.begin(), hold.nodes.end());
  for (const SceneJoint* joint : kept.joints) nodes.push_back(joint_node(*joint, mesh));
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return {solid::SupportKind::kClamped, std::string("set:") + kSet};
}

}  // namespace klang::scene::detail
