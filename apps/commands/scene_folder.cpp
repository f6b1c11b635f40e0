#include "apps/commands/scene_folder.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "apps/commands/said_of_modes.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/sound_level.hpp"
#include "core/sound/scene/scene_floor.hpp"
#include "core/sound/scene/scene_roughness.hpp"
#include "core/sound/scene/scene_yielding.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

namespace klang::apps {
namespace {

std::string stem_of(const scene::Scene& scene, int number) {
  const std::vector<std::optional<int>> numbers = scene::sound_model_numbers(scene);
  const auto first = std::find(numbers.begin(), numbers.end(), std::optional<int>(number)) - numbers.begin();
  std::string stem = scene.bodies[static_cast<std::size_t>(first)].name;
  for (char& c : stem)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return std::to_string(number) + "-" + stem.substr(0, 60);
}

std::string piece_file(int row) { return "pieces/" + std::to_string(row) + ".off"; }
std::string piece_mesh_file(int row) { return "pieces/" + std::to_string(row) + ".vtu"; }

std::array<double, 3> list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

scene::BodyRecord body_record(const scene::Scene& scene, const scene::SceneMotion& motion, std::size_t i) {
  const int parent = motion.log.bodies[i].parent;
  std::size_t root = i;
  while (motion.log.bodies[root].parent >= 0) root = static_cast<std::size_t>(motion.log.bodies[root].parent);
  const scene::SceneBody& body = scene.bodies[root];
  const scene::FinalState& end = motion.final[i];
  scene::BodyRecord record;
  record.name = motion.log.bodies[i].name;
  if (parent >= 0) record.parent = motion.log.bodies[static_cast<std::size_t>(parent)].name;
  record.mass_kg = motion.mass_kg[i];
  record.material = scene.material_of(body).name;
  record.fixed = body.fixed;
  if (body.model == scene::BodyModel::kModal) record.n_modes = body.modal.n_modes;  // all are found, or none
  record.final = {list(end.position_m),
                  list(end.velocity_m_s),
                  list(end.angular_velocity_rad_s),
                  {end.orientation_wxyz[0], end.orientation_wxyz[1], end.orientation_wxyz[2], end.orientation_wxyz[3]}};
  return record;
}

void add_cracks(const scene::Scene& scene, const scene::CrackSummary& cracks, scene::SceneDocument& document) {
  document.cracks = {cracks.n_splits, cracks.n_elements_start, cracks.n_elements_end, 0.0};
  for (const fracture::PartedFace& face : cracks.faces) document.cracks->new_area_m2 += face.area_m2;
  document.plastic = {cracks.dissipation_j, cracks.max_strain};
  for (const scene::CrackSummary::Split& split : cracks.splits) {
    scene::SceneEventRecord event;
    event.time_s = split.time_s;
    event.kind = "split";
    event.body = scene.bodies[static_cast<std::size_t>(split.body)].name;
    event.pieces = split.pieces;
    event.crack_area_m2 = split.crack_area_m2;
    event.largest_stress_pa = split.largest_stress_pa;
    event.strain_energy_j = split.energies.elastic_j;
    event.kinetic_energy_j = split.energies.kinetic_j;
    event.viscous_energy_j = split.energies.viscous_j;
    event.plastic_energy_j = split.energies.plastic_j;
    document.events.push_back(event);
  }
  std::stable_sort(document.events.begin(), document.events.end(),
                   [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  document.header.warnings.insert(document.header.warnings.end(), cracks.warnings.begin(), cracks.warnings.end());
}

void add_impulses(const events::EventLog& log, scene::SceneDocument& document) {
  scene::ImpulsesRecord& sums = document.impulses_summary;
  for (const events::Impulse& impulse : log.impulses) {
    if (impulse.kind == events::ImpulseKind::kLasting) {
      ++sums.n_lasting;
      continue;
    }
    if (impulse.kind != events::ImpulseKind::kImpact) continue;  // cracks strike nothing
    const double size = impulse.impulse_n_s.norm();
    ++sums.n_impacts;
    sums.total_impact_n_s += size;
    sums.largest_impact_n_s = std::max(sums.largest_impact_n_s, size);
    sums.shortest_contact_s = std::min(sums.shortest_contact_s.value_or(HUGE_VAL), impulse.duration_s);
    sums.longest_contact_s = std::max(sums.longest_contact_s.value_or(0.0), impulse.duration_s);
    scene::BodyRecord& body = document.bodies[static_cast<std::size_t>(impulse.body)];
    ++body.n_impacts;
    body.hardest_impact_n_s = std::max(body.hardest_impact_n_s.value_or(0.0), size);
  }
}

void add_hardest(const events::EventLog& log, scene::ImpulsesRecord& sums) {
  constexpr std::size_t kMost = 1000;
  std::vector<const events::Impulse*> impacts;
  for (const events::Impulse& impulse : log.impulses)
    if (impulse.kind == events::ImpulseKind::kImpact) impacts.push_back(&impulse);
  std::stable_sort(impacts.begin(), impacts.end(), [](const events::Impulse* a, const events::Impulse* b) {
    return a->impulse_n_s.squaredNorm() > b->impulse_n_s.squaredNorm();
  });
  if (impacts.size() > kMost) impacts.resize(kMost);
  std::stable_sort(impacts.begin(), impacts.end(),
                   [](const events::Impulse* a, const events::Impulse* b) { return a->time_s < b->time_s; });
  for (const events::Impulse* impact : impacts) {
    const std::string other = impact->other < 0 ? "floor" : log.bodies[static_cast<std::size_t>(impact->other)].name;
    sums.hardest.push_back({impact->time_s, log.bodies[static_cast<std::size_t>(impact->body)].name, other,
                            impact->impulse_n_s.norm(), impact->duration_s});
  }
}

}  // namespace

scene::SceneNotes scene_notes(const CommonOptions& common, std::vector<std::string>& warnings) {
  return {[&common](const std::string& text) { note(common, text); },
          [&warnings](const std::string& text) {
            warn(text);
            warnings.push_back(text);
          }};
}

void apply(const SceneChanges& changes, scene::Scene& scene) {
  if (!changes.bank.empty()) scene.sound.bank = existing_file(changes.bank, "--bank", {});
  if (changes.proxies_above_hz) {
    checked("command line", "--proxies-above-hz", *changes.proxies_above_hz, 0.0, 1e6);
    if (scene.sound.bank.empty())
      throw InputError("--proxies-above-hz", "the scene names no soundbank", to_text(*changes.proxies_above_hz),
                       "--bank FILE, or bank = FILE in its [sound]");
    scene.sound.proxy_above_hz = changes.proxies_above_hz;
  }
  if (changes.without_fracture_impulses) scene.fracture.impulses = false;
}

std::string scene_run_key(const scene::Scene& scene, const nlohmann::json& options, std::uint64_t seed) {
  const Provenance provenance = make_provenance("", seed, options, scene.inputs());
  std::string text = provenance.version + ";" + std::to_string(seed) + ";" + provenance.options.text;
  for (const InputFile& input : provenance.inputs) text += ";" + input.sha256;
  return text;
}

namespace {

std::array<std::string, 2> files_of(const std::string& stem, bool proxy) {
  const std::string kind = proxy ? "-proxy" : "";
  return {"modes/" + stem + kind + ".vtu", "modes/" + stem + kind + "-transfer.vtu"};
}

using ModelPointer = std::shared_ptr<const scene::SoundModel>;

/// Own modes that the folder has; null: not there.
ModelPointer kept_model(const SceneFolder* folder, const std::string& stem) {
  const auto [modes, transfer] = files_of(stem, false);
  if (folder == nullptr || !folder->has(modes) || !folder->has(transfer)) return {};
  return std::make_shared<const scene::SoundModel>(scene::SoundModel{
      modal::read_modal_model(folder->file(modes)), acoustics::read_transfer_model(folder->file(transfer)), false, {}});
}

ModelPointer keep_model(const SceneFolder* folder, const std::string& stem, scene::SoundModel model) {
  if (folder != nullptr) {
    const auto [modes, transfer] = files_of(stem, model.proxy);
    modal::write_modal_model(folder->file(modes), model.modes);
    acoustics::write_transfer_model(folder->file(transfer), model.transfer);
  }
  return std::make_shared<const scene::SoundModel>(std::move(model));
}

std::string piece_stem(int row) { return "piece-" + std::to_string(row); }

struct PieceShape {
  std::string name;
  mesh::SurfaceMesh surface;
  std::optional<mesh::TetMesh> own;  ///< of what cracked off
};

/// A piece's proxy, where it has one.
std::optional<scene::SoundModel> proxy_of_piece(const scene::SceneProxies& proxies, const scene::SceneBody& parent,
                                                const PieceShape& piece, const scene::SceneNotes& notes,
                                                Monitor& monitor) {
  mesh::TetgenOptions options;
  options.in_child = true;  // TetGen ends the process on some pieces
  try {
    const mesh::TetMesh mesh =
        piece.own ? mesh::to_quadratic(*piece.own) : mesh::mesh_surface(piece.surface, options, piece.name, monitor);
    return proxies.stand_in({&parent, piece.name, &piece.surface, mesh}, notes, monitor);
  } catch (const InputError& error) {
    notes.warning("piece " + piece.name + " has no proxy: " + error.what());
    return {};
  }
}

}  // namespace

std::array<std::string, 2> model_files(const scene::Scene& scene, const scene::HeardBody& body) {
  const auto row = static_cast<std::size_t>(body.body);
  return files_of(
      row < scene.bodies.size() ? stem_of(scene, *scene::sound_model_numbers(scene)[row]) : piece_stem(body.body),
      body.model->proxy);
}

std::vector<scene::HeardBody> heard_bodies(const scene::Scene& scene, const scene::SceneProxies& proxies,
                                           const SceneFolder* folder, const scene::SceneNotes& notes,
                                           Monitor& monitor) {
  scene::warn_of_assumed_damping(scene, notes);
  scene::warn_of_low_sample_rate(scene, notes);
  std::map<int, ModelPointer> models;
  std::set<int> silent;
  std::vector<scene::HeardBody> heard;
  const std::vector<std::optional<int>> numbers = scene::sound_model_numbers(scene);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!numbers[i] || silent.contains(*numbers[i])) continue;
    const scene::SceneBody& body = scene.bodies[i];
    ModelPointer& model = models[*numbers[i]];
    if (!model) {
      const std::string stem = stem_of(scene, *numbers[i]);
      if (proxies.may_stand_for(body))
        if (auto proxy =
                proxies.stand_in({&body, body.name, nullptr, scene::mesh_of(body, notes, monitor)}, notes, monitor))
          model = keep_model(folder, stem, std::move(*proxy));
      SaidOfModes said(folder, stem, notes);
      if (!model) {
        model = kept_model(folder, stem);
        if (model) said.say_again();
      }
      if (!model) {
        auto made = scene::sound_model_of(scene, body, said.notes(), monitor);
        if (!made) {
          silent.insert(*numbers[i]);
          continue;
        }
        said.keep({});
        model = keep_model(folder, stem, std::move(*made));
      }
    }
    heard.push_back({static_cast<int>(i), model, scene.material_of(body).damping_heard()});
  }
  return heard;
}

mesh::SurfaceMesh piece_surface(const SceneFolder& folder, int row) {
  return mesh::read_surface(folder.file(piece_file(row)));
}

void write_pieces(const SceneFolder& folder, const std::vector<scene::ScenePiece>& pieces) {
  for (const scene::ScenePiece& piece : pieces) {
    const mesh::SurfaceMesh& surface = piece.surface;
    std::string text =
        "OFF\n" + std::to_string(surface.vertices_m.rows()) + " " + std::to_string(surface.triangles.rows()) + " 0\n";
    for (Eigen::Index v = 0; v < surface.vertices_m.rows(); ++v)
      text += to_text(surface.vertices_m(v, 0)) + " " + to_text(surface.vertices_m(v, 1)) + " " +
              to_text(surface.vertices_m(v, 2)) + "\n";
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
      text += "3 " + std::to_string(surface.triangles(t, 0)) + " " + std::to_string(surface.triangles(t, 1)) + " " +
              std::to_string(surface.triangles(t, 2)) + "\n";
    write_file(folder.file(piece_file(piece.body)), text);
    if (piece.mesh) mesh::write_tet_mesh(folder.file(piece_mesh_file(piece.body)), *piece.mesh);
  }
}

std::vector<scene::HeardBody> heard_pieces(const scene::Scene& scene, const scene::SceneProxies& proxies,
                                           const events::EventLog& log, const SceneFolder& folder,
                                           const scene::SceneNotes& notes, Monitor& monitor) {
  std::vector<scene::HeardBody> heard;
  std::map<std::size_t, int> n_pieces, n_heard;  // by body of the scene
  int n_coarse = 0;
  double coarsest = 0.0;
  for (std::size_t row = scene.bodies.size(); row < log.bodies.size(); ++row) {
    const int number = static_cast<int>(row);
    std::size_t ancestor = row;
    while (ancestor >= scene.bodies.size()) ancestor = static_cast<std::size_t>(log.bodies[ancestor].parent);
    const scene::SceneBody& parent = scene.bodies[ancestor];
    if (!parent.sounds()) continue;
    const std::string stem = piece_stem(number), silent = "modes/" + stem + ".silent";
    ++n_pieces[ancestor];
    SaidOfModes said(&folder, stem, notes);
    if (folder.has(silent)) {
      said.say_again();
      continue;
    }
    const auto count_coarse = [&](std::optional<double> mesh_error) {
      if (mesh_error.value_or(0.0) <= scene::kOpenMeshError) return;
      ++n_coarse;
      coarsest = std::max(coarsest, *mesh_error);
    };
    const std::string& name = log.bodies[row].name;
    ModelPointer model;
    const auto shape = [&]() -> PieceShape {
      PieceShape piece{name, piece_surface(folder, number), {}};
      if (folder.has(piece_mesh_file(number))) piece.own = mesh::read_tet_mesh(folder.file(piece_mesh_file(number)));
      return piece;
    };
    if (auto proxy = proxies.may_stand_for(parent) ? proxy_of_piece(proxies, parent, shape(), notes, monitor)
                                                   : std::optional<scene::SoundModel>()) {
      if (proxy->modes.n_modes() == 0) {
        write_file(folder.file(silent), "");
        continue;
      }
      model = keep_model(&folder, stem, std::move(*proxy));
    }
    if (!model) {
      model = kept_model(&folder, stem);
      if (model) count_coarse(said.say_again());
    }
    if (!model) {
      const PieceShape piece = shape();
      auto made = piece.own ? scene::sound_model_of(scene, parent, name, *piece.own, said.notes(), monitor)
                            : scene::sound_model_of(scene, parent, name, piece.surface, said.notes(), monitor);
      said.keep(made ? made->mesh_error : std::nullopt);
      if (!made) {
        write_file(folder.file(silent), "");
        continue;
      }
      count_coarse(made->mesh_error);
      model = keep_model(&folder, stem, std::move(*made));
    }
    heard.push_back({number, model, scene.material_of(parent).damping_heard()});
    ++n_heard[ancestor];
  }
  for (const auto& [body, n] : n_pieces)
    if (n_heard[body] == 0)
      notes.warning("none of the " + std::to_string(n) + " pieces of " + scene.bodies[body].name +
                    " is heard: they have no mode between " + to_text(scene.sound.low_hz) + " and " +
                    to_text(scene.sound.high_hz) + " Hz (sound.band_hz), or no mesh");
  if (n_coarse > 0)
    notes.warning("the highest modes of " +
                  (n_coarse == 1 ? std::string("a piece") : std::to_string(n_coarse) + " pieces") +
                  " are lowered by up to " + to_text(std::round(1000.0 * coarsest) / 10.0) +
                  " % for the mesh's stiffness, an estimate of which a tenth is open");
  return heard;
}

scene::SceneDocument scene_document(const scene::Scene& scene, const scene::SceneMotion& motion, ResultHeader header) {
  scene::SceneDocument document;
  document.header = std::move(header);
  document.name = scene.name;
  document.end_s = motion.end_s;
  document.rate_hz = scene.solver.rate_hz;
  document.n_steps = motion.n_steps;
  for (std::size_t i = 0; i < motion.log.bodies.size(); ++i) document.bodies.push_back(body_record(scene, motion, i));
  for (const scene::BreakEvent& event : motion.breaks)
    document.events.push_back({event.time_s, "fracture", motion.log.bodies[static_cast<std::size_t>(event.body)].name,
                               event.n_pieces, event.energies.strain_j, event.energies.fracture_j,
                               event.energies.kinetic_j, event.energies.vibration_j + event.energies.residual_j,
                               event.crack_area_m2, event.largest_stress_pa});
  document.n_stress_solves = static_cast<int>(motion.n_stress_solves);
  if (motion.contact_residual) document.contact = scene::ContactRecord{*motion.contact_residual};
  if (motion.cracks) add_cracks(scene, *motion.cracks, document);
  add_impulses(motion.log, document);
  add_hardest(motion.log, document.impulses_summary);
  const rigid::EnergyLedger& end = motion.ledger.back();
  document.ledger.residual_relative = motion.residual_relative;
  document.ledger.energy_scale_j = motion.energy_scale_j;
  document.ledger.limit = motion.cracks ? scene::kCrackingLedgerLimit : scene::kLedgerLimit;
  document.ledger.contact_j = end.contact_j;
  document.ledger.friction_j = end.friction_j;
  document.ledger.fracture_j = end.fracture_j;
  document.ledger.vibration_j = end.vibration_j;
  document.ledger.correction_j = end.correction_j;
  document.ledger.viscous_j = end.viscous_j;
  document.ledger.plastic_j = end.plastic_j;
  document.ledger.work_j = end.work_j - motion.ledger.front().work_j;  // the first row has what bodies brought
  for (const rigid::EnergyLedger& row : motion.ledger)
    document.ledger.most_strain_j = std::max(document.ledger.most_strain_j, row.strain_j);
  document.solver_residual_m_s = motion.solver_residual_m_s;
  document.deepest_overlap_m = motion.deepest_m;
  return document;
}

std::string crack_faces_csv(const scene::CrackSummary& cracks) {
  std::vector<scene::CrackFaceRow> rows;
  for (const fracture::PartedFace& face : cracks.faces)
    rows.push_back({face.centre_m.x(), face.centre_m.y(), face.centre_m.z(), face.normal.x(), face.normal.y(),
                    face.normal.z(), face.area_m2, face.time_s});
  return csv_table(rows);
}

stage::ImpactPulses heard_pulses(const scene::Scene& scene, const events::EventLog& log,
                                 const std::vector<scene::HeardBody>& heard, const SceneFolder* folder,
                                 Monitor& monitor) {
  const auto surface = [&](int row) -> std::optional<mesh::SurfaceMesh> {
    if (!folder || !folder->has(piece_file(row))) return {};
    return piece_surface(*folder, row);
  };
  return scene::impact_pulses(scene, log, heard, surface, monitor);
}

audio::Signal heard_sound(const scene::Scene& scene, const HeardScene& heard, double duration_s,
                          std::optional<scene::FloorRecord>* floor, Monitor& monitor) {
  const auto& [log, bodies, pulses] = heard;
  audio::Signal sound =
      scene::sound_of(scene::with_roughness(scene, log), bodies, scene.sound, duration_s, monitor, &pulses);
  if (!scene.floor_sound) return sound;
  const scene::FloorHeard slab = scene::floor_sound_of(scene, log, pulses, duration_s, monitor);
  sound.samples += slab.sound_pa.samples;
  if (floor) *floor = {slab.n_modes, slab.n_places, scene.floor_sound->low_hz, scene.floor_sound->high_hz};
  return sound;
}

scene::HeardRecord write_scene_sound(const std::filesystem::path& path, audio::Signal sound,
                                     const scene::SceneSoundOptions& options, const scene::SceneNotes& notes) {
  scene::HeardRecord record;
  record.file = path.filename().string();
  record.peak_pressure_pa = sound.n_frames() > 0 ? sound.samples.cwiseAbs().maxCoeff() : 0.0;
  record.gain = audio::file_gain(record.peak_pressure_pa, options.peak_db_re_full_scale);
  if (audio::is_inaudible(record.peak_pressure_pa)) notes.warning(audio::inaudible_note(record.peak_pressure_pa));
  record.duration_s = sound.duration_s();
  record.sample_rate_hz = sound.sample_rate_hz;
  record.n_channels = static_cast<int>(sound.n_channels());
  record.listener_m = list(options.listener.position_m);
  sound.samples *= record.gain;
  audio::write_sound(path, sound);
  return record;
}

Eigen::Vector3d parse_place(const std::string& option, const std::string& text) {
  Eigen::Vector3d place;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto parsed = std::from_chars(at, end, place[axis]);
    const bool separated = axis == 2 ? parsed.ptr == end : parsed.ptr != end && *parsed.ptr == ',';
    if (parsed.ec != std::errc() || !separated || !std::isfinite(place[axis]))
      throw InputError(option, "is no place", text, "x,y,z in metres");
    at = parsed.ptr + 1;
  }
  return place;
}

}  // namespace klang::apps
