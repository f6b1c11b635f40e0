#include "core/sound/scene/scene.hpp"

#include <algorithm>

#include "core/foundation/base/conventions.hpp"

namespace klang::scene {

std::vector<std::filesystem::path> Scene::inputs() const {
  std::vector<std::filesystem::path> files = {file};
  const auto add = [&](const std::filesystem::path& path) {
    if (!path.empty() && std::find(files.begin(), files.end(), path) == files.end()) files.push_back(path);
  };
  for (const SceneMaterial& material : materials)
    for (const std::filesystem::path& path : material.inputs) add(path);
  for (const SceneBody& body : bodies) {
    add(body.mesh);
    if (body.shape) add(body.shape->profile_csv);
  }
  for (const SceneHold& hold : holds) add(hold.csv);
  add(sound.bank);
  return files;
}

bool Scene::has_deforming_bodies() const {
  return std::any_of(bodies.begin(), bodies.end(), [](const SceneBody& b) {
    return b.model == BodyModel::kCracking || b.model == BodyModel::kModal;
  });
}

Eigen::Quaterniond orientation_of(const Eigen::Vector3d& rotation_deg) {
  const Eigen::Vector3d angle = rotation_deg * (kPi / 180.0);
  return Eigen::AngleAxisd(angle.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angle.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Eigen::Vector3d::UnitX());
}

rigid::Skin skin_of(const SceneMaterial& material) {
  rigid::Skin skin;
  skin.restitution = material.restitution;
  skin.friction = material.friction;
  skin.youngs_modulus_pa = material.elastic.youngs_modulus_pa();
  skin.poissons_ratio = material.elastic.poissons_ratio();
  return skin;
}

}  // namespace klang::scene
