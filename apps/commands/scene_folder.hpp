#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/kit/command.hpp"
#include "core/sound/scene/scene_document.hpp"
#include "core/sound/scene/scene_motion.hpp"
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

  /// Makes the folder, removes the results of an earlier run and notes whose run this is.
  void begin(const std::string& key) const;
  /// @throws InputError where the folder holds the run of another scene or other options, or none
  void require(const std::string& key) const;

 private:
  std::filesystem::path folder_;
};

/// Of which scene, options and files a run is: equal where its results are.
std::string scene_run_key(const scene::Scene& scene, std::optional<double> until_s, std::uint64_t seed);

/// Names in a folder of the models of a scene's bodies, by their number (scene::sound_model_numbers): that of the first body.
std::string modes_file(const scene::Scene& scene, int number);
std::string transfer_file(const scene::Scene& scene, int number);

/// The bodies of a scene that are heard, their models from the folder where they are there, else computed and kept in it.
std::vector<scene::HeardBody> heard_bodies(const scene::Scene& scene, const SceneFolder* folder,
                                           const scene::SceneNotes& notes, Monitor& monitor);

/// The same of pieces: rows of the log's bodies that have a parent, their surfaces from the folder (pieces/ROW.off).
std::vector<scene::HeardBody> heard_pieces(const scene::Scene& scene, const events::EventLog& log,
                                           const SceneFolder& folder, const scene::SceneNotes& notes, Monitor& monitor);
void write_pieces(const SceneFolder& folder, const std::vector<scene::ScenePiece>& pieces);

/// scene.json's header, bodies and sums of a motion.
scene::SceneDocument scene_document(const scene::Scene& scene, const scene::SceneMotion& motion, ResultHeader header);

/// crack_faces.csv of `klang scene run`: a row per pair of faces that parted.
std::string crack_faces_csv(const scene::CrackSummary& cracks);

/// Writes a sound with its peak at the level asked for and says what it is.
scene::HeardRecord write_scene_sound(const std::filesystem::path& path, audio::Signal sound,
                                     const scene::SceneSoundOptions& options);

/// "0,-2,1.6". @throws InputError
Eigen::Vector3d parse_place(const std::string& option, const std::string& text);

}  // namespace klang::apps
