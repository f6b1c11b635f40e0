#include "core/sound/scene/detail/held_nodes.hpp"

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::scene::detail {
namespace {

constexpr double kAway = 0.1;  ///< of the body's size: a place farther from all nodes is none of it

std::vector<int> nodes_under(const SceneHold& hold, const mesh::TetMesh& mesh) {
  if (!hold.at_m) return solid::held_nodes(solid::parse_support("clamped:" + hold.where), mesh);
  const Eigen::VectorXd far = (mesh.nodes_m.rowwise() - hold.at_m->transpose()).rowwise().norm();
  Eigen::Index nearest = 0;
  const double size = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  if (!(far.minCoeff(&nearest) <= kAway * size))
    throw InputError("at_m", "is away from the body", to_text(far.minCoeff()) + " m", "a place of the body");
  return {static_cast<int>(nearest)};
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

}  // namespace klang::scene::detail
