#include "core/sound/scene/scene_sound.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/refinement.hpp"
#include "core/geometry/mesh/surface_coarsening.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/modal/polynomial_modes.hpp"
#include "core/sound/scene/detail/held_nodes.hpp"
#include "core/sound/stage/radiating_voice.hpp"
#include "core/sound/transfer/radiate.hpp"

namespace klang::scene {
namespace {

constexpr int kMostModes = 1000;
constexpr double kMeshError = 0.02;
constexpr int kFewPieceElements = 1000;
constexpr int kMostPieceElements = 20000;

/// What makes two bodies sound alike, as text.
std::string key_of(const Scene& scene, const SceneBody& body) {
  std::string key = detail::kept_key(scene, body) + std::to_string(static_cast<int>(body.sound)) + ";" +
                    std::to_string(body.material) + ";" + to_text(body.max_edge_m) + ";" + to_text(body.unit_m) + ";";
  if (body.modes_to_hz) key += to_text(*body.modes_to_hz) + ";";
  if (!body.shape) return key + body.mesh.string();
  key += body.shape->kind + ";" + body.shape->profile_csv.string();
  for (const auto& [name, value] : body.shape->dims) key += ";" + name + "=" + to_text(value);
  return key;
}

}  // namespace

std::vector<std::optional<int>> sound_model_numbers(const Scene& scene) {
  std::map<std::string, int> known;
  std::vector<std::optional<int>> numbers;
  for (const SceneBody& body : scene.bodies) {
    numbers.emplace_back();
    if (body.sounds())
      numbers.back() = known.try_emplace(key_of(scene, body), static_cast<int>(known.size())).first->second;
  }
  return numbers;
}

void warn_of_assumed_damping(const Scene& scene, const SceneNotes& notes) {
  if (!notes.warning) return;
  std::set<int> heard;
  for (const SceneBody& body : scene.bodies)
    if (body.sounds()) heard.insert(body.material);
  if (scene.floor_sound) heard.insert(*scene.floor_material);
  for (const int number : heard)
    if (const SceneMaterial& material = scene.materials[static_cast<std::size_t>(number)]; !material.damping)
      notes.warning(damping::assumed_damping_words("material " + material.name));
}

void warn_of_low_sample_rate(const Scene& scene, const SceneNotes& notes) {
  const double highest_hz = 0.5 * scene.sound.sample_rate_hz;
  if (!notes.warning || scene.sound.high_hz <= highest_hz) return;
  if (std::none_of(scene.bodies.begin(), scene.bodies.end(), [](const SceneBody& body) { return body.sounds(); }))
    return;
  notes.warning("sound.sample_rate_hz = " + to_text(scene.sound.sample_rate_hz) + " holds nothing above " +
                to_text(highest_hz) + " Hz: modes from there to the end of the band, " + to_text(scene.sound.high_hz) +
                " Hz, are not heard");
}

void warn_of_contradicted_fits(const Scene& scene, const SceneNotes& notes) {
  if (!notes.warning) return;
  for (const SceneMaterial& material : scene.materials)
    if (material.contradiction) notes.warning("material " + material.name + ": " + *material.contradiction);
}

namespace {

struct Meshed {
  const mesh::TetMesh& mesh;
  std::optional<mesh::ShapeSpec> shape;
  solid::Support support = {};
};

/// Where the world keeps a body of the scene, which is heard as kept there.
solid::Support support_of(const Scene& scene, const SceneBody& body, mesh::TetMesh& mesh, const SceneNotes& notes) {
  if (notes.warning && detail::kept_by(scene, body) == detail::KeptBy::kMovingPlaces)
    notes.warning("body " + body.name +
                  " is held by what moves: it is heard by the modes of the free body, its notes as held too quietly");
  return detail::still_support_of(scene, body, mesh);
}

/// Every mesh is stiffer than the body; what its estimate says is taken off (of half a tile of 587 elements 0.24 and 1.18 % remain
/// 0.002 and 0.08 %), and what then lies above the band.
void without_mesh_error(modal::EigenResult& modes, double high_hz) {
  modal::ModalModel& model = modes.model;
  if (modes.mesh_relative_error) model.angular_frequency_rad_s.array() /= 1.0 + modes.mesh_relative_error->array();
  Eigen::Index kept = model.n_modes();
  while (kept > 0 && model.frequency_hz()[kept - 1] > high_hz) --kept;
  if (kept == model.n_modes()) return;
  model.angular_frequency_rad_s.conservativeResize(kept);
  model.shapes.conservativeResize(Eigen::NoChange, kept);
  if (modes.mesh_relative_error) modes.mesh_relative_error->conservativeResize(kept);
}

double largest_mesh_error(const modal::EigenResult& modes) {
  return modes.mesh_relative_error && modes.mesh_relative_error->size() > 0 ? modes.mesh_relative_error->maxCoeff()
                                                                            : 0.0;
}

modal::EigenResult modes_in_band(const Scene& scene, const SceneBody& body, const Meshed& meshed,
                                 const SceneNotes& notes, Monitor& monitor) {
  const modal::ModesBody what{meshed.shape, meshed.support, 2};
  modal::ModesOptions options;
  options.eigen.estimate_mesh_error = true;
  options.eigen.band = {scene.sound.low_hz, scene.sound.high_hz};
  if (body.modes_to_hz) options.eigen.band.high_hz = std::min(scene.sound.high_hz, *body.modes_to_hz);
  const double high_hz = options.eigen.band.high_hz;
  options.eigen.band.high_hz *= 1.0 + kOpenMeshError;  // a mesh's modes lie too high
  options.eigen.most = kMostModes;
  options.mesh_is_wanted = body.max_edge_m > 0.0 && what.shape;
  modal::EigenResult modes = located(body.place, [&] {
    return modal::modes_of(what, meshed.mesh, scene.material_of(body).elastic, options, monitor);
  });
  if (!modes.usable()) throw NumericalError("modes of " + body.name + ": " + modes.message);
  if (modes.n_left_out > 0 && notes.warning)
    notes.warning("body " + body.name + ": " + std::to_string(modes.n_left_out) +
                  " modes of the band, above the lowest " + std::to_string(kMostModes) + ", are left out");
  without_mesh_error(modes, high_hz);
  return modes;
}

/// Whether a convex piece has no mode in the band, which polynomials say long before a mesh would; theirs are some percent too high.
bool surely_above_band(const Scene& scene, const SceneBody& parent, const mesh::SurfaceMesh& surface) {
  if (!parent.shape || scene.fracture.pattern == fracture::PatternKind::kGeodesic ||
      mesh::convex_parts(*parent.shape).size() > 1)
    return false;
  constexpr double kTooHigh = 1.05;
  try {
    return modal::lowest_frequency_hz(surface, scene.material_of(parent).elastic, {8}) > kTooHigh * scene.sound.high_hz;
  } catch (const InputError&) {  // a sliver: its mesh says more
    return false;
  } catch (const NumericalError&) {
    return false;
  }
}

/// Cracks leave edges of a thousandth of the wall, in which elements grow by the hundred thousand. Where that is to be feared, edges
/// shorter than the mean wall, twice the volume over the area, go; the surface moves by at most a hundredth of it (volumes of a wine
/// glass's pieces by 0.2 to 0.5 %; of one that bends at a thin place the lowest mode by 4.6 %, the second by 0.01 %).
/// @return none where there are none, or more than a hundredth of the volume would go
std::optional<mesh::SurfaceMesh> without_slivers(const mesh::SurfaceMesh& surface) {
  constexpr double kExpectedElements = 1e5, kOfWall = 0.01, kOfVolume = 0.01;
  const double volume_m3 = mesh::mass_properties(surface).volume_m3;
  if (!(mesh::expected_elements(surface, volume_m3, {}) > kExpectedElements)) return {};
  mesh::CoarseningOptions options;
  options.edge_m = 2.0 * volume_m3 / mesh::surface_area_m2(surface);
  options.tolerance_m = kOfWall * options.edge_m;
  mesh::SurfaceMesh coarse = mesh::checked_coarsened(surface, options);
  if (coarse.triangles.rows() == surface.triangles.rows() ||  // it cut itself
      !(std::abs(mesh::mass_properties(coarse).volume_m3 - volume_m3) <= kOfVolume * volume_m3))
    return {};
  return coarse;
}

double band_end_hz(const Scene& scene, const SceneBody& body) {
  return std::min(scene.sound.high_hz, body.modes_to_hz.value_or(HUGE_VAL));
}

std::string band_words(const Scene& scene, const SceneBody& body) {
  return to_text(scene.sound.low_hz) + " to " + to_text(band_end_hz(scene, body)) + " Hz";
}

InputError no_mode(const Scene& scene, const SceneBody& body) {
  return {body.place, body.name + " has no mode in the band", band_words(scene, body),
          "another sound.band_hz, or sound = \"auto\" or \"none\""};
}

/// Polynomials' lowest frequency is an upper bound; of what is convex it is near the truth.
bool has_mode(const Scene& scene, const SceneBody& body, Monitor& monitor) {
  constexpr double kTooHigh = 1.05;
  mesh::TetMesh mesh = mesh_of(body, {}, monitor);
  const solid::Support support = support_of(scene, body, mesh, {});
  if (support.kind != solid::SupportKind::kFree)
    return modes_in_band(scene, body, {mesh, body.shape, support}, {}, monitor).model.n_modes() > 0;
  try {
    const double lowest_hz =
        modal::lowest_frequency_hz(mesh::boundary_surface(mesh), scene.material_of(body).elastic, {8});
    if (lowest_hz <= band_end_hz(scene, body)) return true;
    if (body.shape && mesh::convex_parts(*body.shape).size() == 1 && lowest_hz > kTooHigh * band_end_hz(scene, body))
      return false;
  } catch (const NumericalError&) {  // its mesh says
  }
  return modes_in_band(scene, body, {mesh, body.shape}, {}, monitor).model.n_modes() > 0;
}

/// The modes and their radiation; those of a large body that would need too many boundary elements are left out, it may be all.
std::optional<SoundModel> with_radiation(const Scene& scene, const SceneBody& body, const modal::EigenResult& solved,
                                         const SceneNotes& notes, Monitor& monitor) {
  modal::ModalModel modes = solved.model;
  acoustics::RadiateOptions options;
  options.elements_per_wavelength = scene.sound.elements_per_wavelength;
  options.leave_out_coarse = true;
  acoustics::RadiateResult radiation = located(body.place, [&] { return acoustics::radiate(modes, options, monitor); });
  if (!radiation.usable()) throw NumericalError("radiation of " + body.name + ": " + radiation.message);
  SoundModel model{std::move(modes), std::move(radiation.transfer), false, largest_mesh_error(solved)};
  if (radiation.n_left_out == 0) return model;
  // Modes are in order of frequency and numbered by it: those from the first that is missing on go.
  Eigen::Index kept = 0;
  auto& transfers = model.transfer.modes;
  while (kept < static_cast<Eigen::Index>(transfers.size()) && transfers[static_cast<std::size_t>(kept)].mode == kept)
    ++kept;
  if (notes.warning)
    notes.warning("body " + body.name + ": " + std::to_string(model.modes.n_modes() - kept) + " modes from " +
                  to_text(std::round(model.modes.frequency_hz()[kept])) +
                  " Hz up are left out, their radiation needs more than " + std::to_string(options.max_elements) +
                  " boundary elements");
  if (kept == 0) return {};
  transfers.resize(static_cast<std::size_t>(kept));
  model.modes.angular_frequency_rad_s.conservativeResize(kept);
  model.modes.shapes.conservativeResize(Eigen::NoChange, kept);
  return model;
}

}  // namespace

void require_modes(const Scene& scene, Monitor& monitor) {
  const std::vector<std::optional<int>> numbers = sound_model_numbers(scene);
  std::set<int> known;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.sound != BodySound::kModes || body.model == BodyModel::kCracking || !numbers[i] ||
        !known.insert(*numbers[i]).second)
      continue;
    monitor.throw_if_stopped();
    if (!has_mode(scene, body, monitor)) throw no_mode(scene, body);
  }
}

std::optional<SoundModel> sound_model_of(const Scene& scene, const SceneBody& body, const SceneNotes& notes,
                                         Monitor& monitor) {
  mesh::TetMesh mesh = mesh_of(body, notes, monitor);
  const solid::Support support = support_of(scene, body, mesh, notes);
  const modal::EigenResult modes = modes_in_band(scene, body, {mesh, body.shape, support}, notes, monitor);
  if (modes.model.n_modes() == 0) {
    if (body.sound == BodySound::kModes) throw no_mode(scene, body);  // asked for by name
    if (notes.warning)
      notes.warning("body " + body.name + " is silent: it has no mode in the band, " + band_words(scene, body));
    return {};
  }
  if (largest_mesh_error(modes) > kOpenMeshError && notes.warning)
    notes.warning("body " + body.name + ": its highest modes are lowered by up to " +
                  to_text(std::round(1000.0 * largest_mesh_error(modes)) / 10.0) +
                  " % for its mesh's stiffness, an estimate of which a tenth is open");
  return with_radiation(scene, body, modes, notes, monitor);
}

std::optional<SoundModel> sound_model_of(const Scene& scene, const SceneBody& parent, const std::string& name,
                                         const mesh::SurfaceMesh& surface, const SceneNotes& notes, Monitor& monitor) {
  if (surely_above_band(scene, parent, surface)) return {};
  mesh::TetMesh mesh;
  mesh::TetgenOptions options;
  options.in_child = true;  // TetGen ends the process on some pieces
  bool is_smoothed = false;
  try {
    if (const std::optional<mesh::SurfaceMesh> smoothed = without_slivers(surface)) {
      try {
        mesh = mesh::mesh_surface(*smoothed, options, name, monitor);
        is_smoothed = true;
      } catch (const InputError&) {  // as it is, then
      }
    }
    if (!is_smoothed) mesh = mesh::mesh_surface(surface, options, name, monitor);
  } catch (const InputError& error) {
    if (notes.warning) notes.warning("piece " + name + " is silent, it cannot be meshed: " + error.what());
    return {};
  }
  SceneBody piece = parent;
  piece.modes_to_hz.reset();
  for (;;) {
    const modal::EigenResult modes = modes_in_band(scene, piece, {mesh, {}}, notes, monitor);
    if (modes.model.n_modes() == 0) return {};
    if (largest_mesh_error(modes) <= kMeshError || mesh.n_elements() > kFewPieceElements) {
      if (is_smoothed && notes.warning)
        notes.warning("piece " + name +
                      ": slivers of its surface are smoothed for its modes, which may be off by some percent where it "
                      "bends at a thin place");
      return with_radiation(scene, parent, modes, notes, monitor);
    }
    mesh = mesh::to_quadratic(mesh::refined(mesh::to_linear(mesh)));  // a surface of few triangles
  }
}

std::optional<SoundModel> sound_model_of(const Scene& scene, const SceneBody& parent, const std::string& name,
                                         mesh::TetMesh tetrahedra, const SceneNotes& notes, Monitor& monitor) {
  SceneBody piece = parent;
  piece.modes_to_hz.reset();
  piece.name = name;
  for (;;) {
    const mesh::TetMesh mesh = mesh::to_quadratic(tetrahedra);
    const modal::EigenResult modes = modes_in_band(scene, piece, {mesh, {}}, {}, monitor);
    if (modes.model.n_modes() == 0) return {};  // a finer mesh has none lower than this one's error
    if (largest_mesh_error(modes) > kMeshError && 8 * tetrahedra.n_elements() <= kMostPieceElements) {
      tetrahedra = mesh::refined(tetrahedra);
      continue;
    }
    try {
      return with_radiation(scene, parent, modes, notes, monitor);
    } catch (const InputError& why) {
      if (notes.warning) notes.warning("piece " + name + " is silent, its surface does not radiate: " + why.what());
      return {};
    }
  }
}

Eigen::VectorXd decay_per_s(const HeardBody& body, bool radiation_damping) {
  Eigen::VectorXd decay =
      body.damping.law->decay_per_s(body.model->modes.angular_frequency_rad_s, body.damping.parameters.data());
  if (radiation_damping)
    for (const acoustics::ModeTransfer& mode : body.model->transfer.modes)
      decay[mode.mode] += mode.decay_radiation_per_s;
  return decay;
}

double ring_time_s(const std::vector<HeardBody>& bodies, bool radiation_damping) {
  double longest_s = 0.0;
  for (const HeardBody& body : bodies) {
    const double slowest = decay_per_s(body, radiation_damping).minCoeff();
    longest_s = std::max(longest_s, slowest > 0.0 ? std::log(1000.0) / slowest : HUGE_VAL);
  }
  return longest_s;
}

stage::Listener listener_of(const SceneListener& listener) {
  std::vector<double> times_s = {0.0};
  Eigen::Matrix3Xd centres_m = listener.position_m, facings;
  if (!listener.path.empty()) {
    const auto n = static_cast<Eigen::Index>(listener.path.size());
    times_s.clear();
    centres_m.resize(3, n);
    facings.resize(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const ListenerKey& key = listener.path[static_cast<std::size_t>(i)];
      times_s.push_back(key.time_s);
      centres_m.col(i) = key.position_m;
      facings.col(i) = key.facing.normalized();
    }
  }
  if (!listener.stereo) return stage::Listener::ears(times_s, centres_m);
  stage::SphericalHead head;
  head.centre_m = listener.position_m;
  head.facing = listener.facing;
  return stage::Listener::head(times_s, centres_m, facings, head);
}

audio::Signal sound_of(const events::EventLog& log, const std::vector<HeardBody>& bodies,
                       const SceneSoundOptions& options, double duration_s, Monitor& monitor,
                       const stage::ImpactPulses* pulses) {
  stage::RadiatingVoiceOptions voice;
  voice.pulses = pulses;
  std::vector<std::unique_ptr<stage::RadiatingVoice>> voices;
  std::vector<stage::Voice*> list;
  for (const HeardBody& body : bodies) {
    voices.push_back(std::make_unique<stage::RadiatingVoice>(body.body, body.model->modes, body.model->transfer,
                                                             decay_per_s(body, options.radiation_damping), voice));
    list.push_back(voices.back().get());
  }
  return stage::render(log, list, listener_of(options.listener), {options.sample_rate_hz, duration_s}, monitor);
}

}  // namespace klang::scene
