#pragma once
#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/kit/command.hpp"
#include "core/sound/scene/scene_document.hpp"
#include "core/sound/scene/scene_motion.hpp"
#include "core/sound/scene/scene_proxies.hpp"
#include "core/sound/scene/scene_sound.hpp"

/// What the subcommands of scenes share: the folder of a run.
namespace klang::apps {

/// Notes and warnings of bodies as commands print them; warnings are also collected.
scene::SceneNotes scene_notes(const CommonOptions& common, std::vector<std::string>& warnings);

/// The folder that `klang scene run` writes. Every file in it is whole at any moment, and appears when its stage is done.
class SceneFolder {
 public:
  explicit SceneFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  bool has(const std::string& name) const;

  /// Makes the folder, removes the results of an earlier run and notes whose run this is, and where its motion ends (none: where the
  /// scene says).
  void begin(const std::string& key, std::optional<double> until_s) const;
  /// @throws InputError where the folder holds the run of another scene or other options, or none
  void require(const std::string& key) const;
  /// Makes way for the same motion with a later end: modes stay. @param pieces_stay  theirs too
  /// @returns  there was an earlier end
  /// @throws InputError where the noted end is later
  bool go_on(const std::string& key, std::optional<double> until_s, bool pieces_stay) const;

 private:
  void note_run(const std::string& key, std::optional<double> until_s) const;
  void remove_results() const;
  std::filesystem::path folder_;
};

/// What the command line says of a scene.
struct SceneChanges {
  std::optional<double> proxies_above_hz;
  std::string bank;  ///< instead of the scene's
  bool without_fracture_impulses = false;
};

/// @throws InputError where proxies are asked for and the scene names no bank
void apply(const SceneChanges& changes, scene::Scene& scene);

/// Of which scene, options and files a run is: equal where its results are but for where its motion ends.
std::string scene_run_key(const scene::Scene& scene, const nlohmann::json& options, std::uint64_t seed);

/// The bodies of a scene that are heard, their models from the folder where they are there, else computed and kept in it.
std::vector<scene::HeardBody> heard_bodies(const scene::Scene& scene, const scene::SceneProxies& proxies,
                                           const SceneFolder* folder, const scene::SceneNotes& notes, Monitor& monitor);

/// The same of pieces: rows of the log's bodies that have a parent, their surfaces from the folder (pieces/ROW.off).
std::vector<scene::HeardBody> heard_pieces(const scene::Scene& scene, const scene::SceneProxies& proxies,
                                           const events::EventLog& log, const SceneFolder& folder,
                                           const scene::SceneNotes& notes, Monitor& monitor);

/// Files of the modes and of the radiation of a heard body, relative to the folder.
std::array<std::string, 2> model_files(const scene::Scene& scene, const scene::HeardBody& body);
/// The surface that write_pieces() left of a row of the log's bodies.
mesh::SurfaceMesh piece_surface(const SceneFolder& folder, int row);
void write_pieces(const SceneFolder& folder, const std::vector<scene::ScenePiece>& pieces);

/// scene.json's header, bodies and sums of a motion.
scene::SceneDocument scene_document(const scene::Scene& scene, const scene::SceneMotion& motion, ResultHeader header);

/// crack_faces.csv of `klang scene run`: a row per pair of faces that parted.
std::string crack_faces_csv(const scene::CrackSummary& cracks);

/// Pulses of the impacts of bodies that yield. @param folder  of the run, for the shapes of its pieces; null: none
stage::ImpactPulses heard_pulses(const scene::Scene& scene, const events::EventLog& log,
                                 const std::vector<scene::HeardBody>& heard, const SceneFolder* folder,
                                 Monitor& monitor);

/// What happened, who is heard of it, and heard_pulses() of it.
struct HeardScene {
  const events::EventLog& log;
  const std::vector<scene::HeardBody>& bodies;
  const stage::ImpactPulses& pulses;
};

/// What the listener hears of bodies and floor. @param floor  what the floor gave; null: not wanted
audio::Signal heard_sound(const scene::Scene& scene, const HeardScene& heard, double duration_s,
                          std::optional<scene::FloorRecord>* floor, Monitor& monitor);

/// Writes a sound with its peak at the level asked for and says what it is.
scene::HeardRecord write_scene_sound(const std::filesystem::path& path, audio::Signal sound,
                                     const scene::SceneSoundOptions& options, const scene::SceneNotes& notes);

/// "0,-2,1.6". @throws InputError
Eigen::Vector3d parse_place(const std::string& option, const std::string& text);

}  // namespace klang::apps
