#include "apps/commands/scene_folder.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

namespace klang::apps {
namespace {

const char* const kRunFile = "run.json";

std::string stem_of(const scene::Scene& scene, int number) {
  const std::vector<std::optional<int>> numbers = scene::sound_model_numbers(scene);
  const auto first = std::find(numbers.begin(), numbers.end(), std::optional<int>(number)) - numbers.begin();
  std::string stem = scene.bodies[static_cast<std::size_t>(first)].name;
  for (char& c : stem)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return std::to_string(number) + "-" + stem.substr(0, 60);
}

std::string piece_file(int row) { return "pieces/" + std::to_string(row) + ".off"; }

std::array<double, 3> list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

scene::BodyRecord body_record(const scene::Scene& scene, const scene::SceneMotion& motion, std::size_t i) {
  const int parent = motion.log.bodies[i].parent;
  const scene::SceneBody& body = scene.bodies[parent < 0 ? i : static_cast<std::size_t>(parent)];
  const scene::FinalState& end = motion.final[i];
  scene::BodyRecord record;
  record.name = motion.log.bodies[i].name;
  if (parent >= 0) record.parent = body.name;
  record.mass_kg = motion.mass_kg[i];
  record.material = scene.material_of(body).name;
  record.fixed = body.fixed;
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

bool SceneFolder::has(const std::string& name) const {
  std::error_code error;
  return std::filesystem::is_regular_file(file(name), error);
}

void SceneFolder::begin(const std::string& key) const {
  std::error_code error;
  for (const char* sub : {"modes", "pieces"})
    if (!error) std::filesystem::create_directories(folder_ / sub, error);
  if (error) throw InputError("--output", "cannot be made: " + error.message(), folder_.string());
  for (const char* old : {"scene.json", "motion.json", kRunFile, "events.h5", "ledger.csv", "crack_faces.csv",
                          "sound.wav", "report.html"})
    std::filesystem::remove(file(old), error);
  for (const char* sub : {"modes", "pieces"})
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / sub, error))
      if (const auto kind = entry.path().extension(); kind == ".vtu" || kind == ".silent" || kind == ".off")
        std::filesystem::remove(entry.path(), error);
  write_file(file(kRunFile), json_text({{"run", key}}));
}

void SceneFolder::require(const std::string& key) const {
  if (!has(kRunFile)) throw InputError("--resume", "there is no run in the folder", folder_.string());
  const nlohmann::json noted = parse_json(read_file(file(kRunFile)), file(kRunFile).string());
  if (text_under(noted, "run") != key)
    throw InputError("--resume", "the folder holds the run of another scene, other options or another version",
                     folder_.string(), "the same scene and options, or a run without --resume");
}

std::string scene_run_key(const scene::Scene& scene, std::optional<double> until_s, std::uint64_t seed) {
  const Provenance provenance =
      make_provenance("", seed, {{"until_s", until_s ? nlohmann::json(*until_s) : nlohmann::json()}}, scene.inputs());
  std::string text = provenance.version + ";" + std::to_string(seed) + ";" + provenance.options.text;
  for (const InputFile& input : provenance.inputs) text += ";" + input.sha256;
  return text;
}

std::string modes_file(const scene::Scene& scene, int number) { return "modes/" + stem_of(scene, number) + ".vtu"; }

std::string transfer_file(const scene::Scene& scene, int number) {
  return "modes/" + stem_of(scene, number) + "-transfer.vtu";
}

std::vector<scene::HeardBody> heard_bodies(const scene::Scene& scene, const SceneFolder* folder,
                                           const scene::SceneNotes& notes, Monitor& monitor) {
  std::map<int, std::shared_ptr<const scene::SoundModel>> models;
  std::vector<scene::HeardBody> heard;
  const std::vector<std::optional<int>> numbers = scene::sound_model_numbers(scene);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!numbers[i]) continue;
    const scene::SceneBody& body = scene.bodies[i];
    std::shared_ptr<const scene::SoundModel>& model = models[*numbers[i]];
    const std::string modes = modes_file(scene, *numbers[i]), transfer = transfer_file(scene, *numbers[i]);
    if (!model && folder != nullptr && folder->has(modes) && folder->has(transfer)) {
      model = std::make_shared<const scene::SoundModel>(scene::SoundModel{
          modal::read_modal_model(folder->file(modes)), acoustics::read_transfer_model(folder->file(transfer))});
    } else if (!model) {
      model = std::make_shared<const scene::SoundModel>(scene::sound_model_of(scene, body, notes, monitor));
      if (folder != nullptr) {
        modal::write_modal_model(folder->file(modes), model->modes);
        acoustics::write_transfer_model(folder->file(transfer), model->transfer);
      }
    }
    heard.push_back({static_cast<int>(i), model, *scene.material_of(body).damping});
  }
  return heard;
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
  }
}

std::vector<scene::HeardBody> heard_pieces(const scene::Scene& scene, const events::EventLog& log,
                                           const SceneFolder& folder, const scene::SceneNotes& notes,
                                           Monitor& monitor) {
  std::vector<scene::HeardBody> heard;
  for (std::size_t row = scene.bodies.size(); row < log.bodies.size(); ++row) {
    const int number = static_cast<int>(row);
    const scene::SceneBody& parent = scene.bodies[static_cast<std::size_t>(log.bodies[row].parent)];
    if (!parent.sounds()) continue;
    const std::string stem = "modes/piece-" + std::to_string(row);
    const std::string modes = stem + ".vtu", transfer = stem + "-transfer.vtu", silent = stem + ".silent";
    std::shared_ptr<const scene::SoundModel> model;
    if (folder.has(silent)) continue;
    if (folder.has(modes) && folder.has(transfer)) {
      model = std::make_shared<const scene::SoundModel>(scene::SoundModel{
          modal::read_modal_model(folder.file(modes)), acoustics::read_transfer_model(folder.file(transfer))});
    } else {
      const auto made = scene::sound_model_of(scene, parent, log.bodies[row].name,
                                              mesh::read_surface(folder.file(piece_file(number))), notes, monitor);
      if (!made) {
        write_file(folder.file(silent), "");
        continue;
      }
      model = std::make_shared<const scene::SoundModel>(*made);
      modal::write_modal_model(folder.file(modes), model->modes);
      acoustics::write_transfer_model(folder.file(transfer), model->transfer);
    }
    heard.push_back({number, model, *scene.material_of(parent).damping});
  }
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
  document.ledger.correction_j = end.correction_j;
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

scene::HeardRecord write_scene_sound(const std::filesystem::path& path, audio::Signal sound,
                                     const scene::SceneSoundOptions& options) {
  scene::HeardRecord record;
  record.file = path.filename().string();
  record.peak_pressure_pa = sound.n_frames() > 0 ? sound.samples.cwiseAbs().maxCoeff() : 0.0;
  record.gain = record.peak_pressure_pa > 0.0
                    ? std::pow(10.0, options.peak_db_re_full_scale / 20.0) / record.peak_pressure_pa
                    : 1.0;
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
