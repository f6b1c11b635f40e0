#include "core/sound/scene/scene_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/sound/scene/detail/deforming_body.hpp"
#include "core/sound/scene/scene_breaking.hpp"
#include "core/sound/scene/scene_modal.hpp"
#include "core/sound/scene/scene_proxies.hpp"
#include "core/sound/scene/scene_sound.hpp"

namespace klang::scene {

namespace {

/// What a run would refuse of bodies that deform: their meshes, and what holds and joins them. Modes are not computed.
void check_deforming(const Scene& scene, rigid::RigidWorld& world, std::uint64_t seed, Monitor& monitor) {
  for (int row = 0; row < world.n_bodies(); ++row)
    if (scene.bodies[static_cast<std::size_t>(row)].model == BodyModel::kCracking)
      const detail::DeformingBody built(scene, row, world.spec(row), seed, {}, monitor);
  Scene stiff = scene;
  for (SceneBody& body : stiff.bodies) {
    body.modal.n_modes = 0;
    body.modal.residual_flexibility = false;
  }
  const SceneNotes silent;
  const ModalBodies modal(stiff, world, silent, monitor);
}

void warn_of_strangers(const Scene& scene, const SceneNotes& notes) {
  const auto has = [&](BodyModel model) {
    return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                       [&](const SceneBody& body) { return body.model == model; });
  };
  if (notes.warning && has(BodyModel::kModal) && has(BodyModel::kCracking))
    notes.warning("modal and cracking bodies do not feel one another: a run stops where they meet");
}

}  // namespace

void require_rest(const Scene& scene) {
  if (scene.duration_s || scene.floor_material || scene.solver.gravity_m_s2.isZero() || !scene.holds.empty()) return;
  const auto to_world = [](const auto& tie) { return tie.other < 0; };
  if (std::any_of(scene.joints.begin(), scene.joints.end(), to_world) ||
      std::any_of(scene.links.begin(), scene.links.end(), to_world) ||
      std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const SceneBody& body) { return body.fixed; }))
    return;
  throw InputError(scene.file.string(), "never comes to rest: nothing holds its bodies against gravity", "",
                   "duration_s, [world.floor], a body that is fixed, or world.gravity_m_s2 = [0, 0, 0]");
}

SceneCheckDocument check_scene(const Scene& scene, std::uint64_t seed, const SceneNotes& notes, Monitor& monitor) {
  require_rest(scene);
  const SceneProxies proxies(scene);
  rigid::RigidWorld world = world_of(scene, notes, monitor);
  warn_of_contradicted_fits(scene, notes);
  warn_of_assumed_damping(scene, notes);
  warn_of_low_sample_rate(scene, notes);
  require_modes(scene, monitor);
  warn_of_strangers(scene, notes);
  SceneCheckDocument document;
  document.name = scene.name;
  const double step_s = 1.0 / scene.solver.rate_hz;
  for (int i = 0; i < world.n_bodies(); ++i) {
    const SceneBody& body = scene.bodies[static_cast<std::size_t>(i)];
    const rigid::RigidBodySpec& rigid = world.spec(i);
    CheckedBody checked;
    checked.name = body.name;
    checked.material = scene.material_of(body).name;
    checked.sound = !body.sounds()                    ? "none"
                    : body.sound == BodySound::kProxy ? "proxy"
                    : proxies.may_stand_for(body)     ? "modes or proxy"
                                                      : "modes";
    checked.mass_kg = rigid.mass_kg;
    checked.volume_m3 = rigid.mass_kg / scene.material_of(body).elastic.density_kg_m3;
    checked.size_m = rigid.size_m();
    checked.n_parts = static_cast<int>(rigid.parts.size());
    checked.fixed = rigid.fixed;
    document.bodies.push_back(checked);
    if (rigid.fixed) continue;
    const double start = rigid.velocity_m_s.norm();
    const double reach_m = rigid.smallest_half_width_m();
    if (!(start * step_s <= reach_m))
      throw InputError(body.place, body.name + " moves too far in a step", to_text(start * step_s) + " m",
                       "up to half of its smallest width, " + to_text(reach_m) + " m: a higher solver.rate_hz");
    const double tip_m = (start + rigid.angular_velocity_rad_s.norm() * 0.5 * rigid.size_m()) * step_s;
    if (!(tip_m <= reach_m))
      document.header.warnings.push_back("body " + body.name + ": its ends move " + to_text(tip_m) +
                                         " m in a step as it spins, more than half of its smallest width, " +
                                         to_text(reach_m) + " m: thin things may pass through them");
    const double turned = rigid.angular_velocity_rad_s.norm() * step_s;
    if (!(turned <= rigid::kMostTurnPerStep))
      throw InputError(body.place, body.name + " turns too far in a step", to_text(turned) + " rad",
                       "up to " + to_text(rigid::kMostTurnPerStep) + " rad: a higher solver.rate_hz");
    const double fall_m = std::max(0.0, world.centre_m(i).z());
    const double fastest = std::sqrt(start * start + 2.0 * scene.solver.gravity_m_s2.norm() * fall_m);
    if (scene.floor_material && !(fastest * step_s <= reach_m))
      document.header.warnings.push_back("body " + body.name + ": falling, it may move " + to_text(fastest * step_s) +
                                         " m in a step, more than half of its smallest width, " + to_text(reach_m) +
                                         " m; the run is then refused");
  }
  for (std::string& warning : coarse_stress_warnings(scene)) document.header.warnings.push_back(std::move(warning));
  check_deforming(scene, world, seed, monitor);
  if (scene.duration_s) document.n_steps = static_cast<int>(std::ceil(*scene.duration_s * scene.solver.rate_hz - 1e-9));
  return document;
}

}  // namespace klang::scene
