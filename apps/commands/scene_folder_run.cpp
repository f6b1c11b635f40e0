// Whose run a folder holds, and how far its motion goes.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/commands/scene_folder.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"

namespace klang::apps {
namespace {

const char* const kRunFile = "run.json";

}  // namespace

bool SceneFolder::has(const std::string& name) const {
  std::error_code error;
  return std::filesystem::is_regular_file(file(name), error);
}

void SceneFolder::remove_results() const {
  std::error_code error;
  for (const char* old : {"scene.json", "motion.json", "events.h5", "ledger.csv", "crack_faces.csv", "shapes.bin",
                          "sound.wav", "frames.pvd", "scene.glb", "report.html"})
    std::filesystem::remove(file(old), error);
  for (const char* sub : {"frames", "pieces"})  // the motion writes its pieces anew, which may have other rows
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / sub, error))
      if (const auto kind = entry.path().extension(); kind == ".vtp" || kind == ".off" || kind == ".vtu")
        std::filesystem::remove(entry.path(), error);
}

void SceneFolder::note_run(const std::string& key, std::optional<double> until_s) const {
  write_file(file(kRunFile),
             json_text({{"run", key}, {"until_s", until_s ? nlohmann::json(*until_s) : nlohmann::json()}}));
}

void SceneFolder::begin(const std::string& key, std::optional<double> until_s) const {
  std::error_code error;
  for (const char* sub : {"modes", "pieces"})
    if (!error) std::filesystem::create_directories(folder_ / sub, error);
  if (error) throw InputError("--output", "cannot be made: " + error.message(), folder_.string());
  remove_results();
  std::filesystem::remove(file(kRunFile), error);
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "modes", error))
    if (const auto kind = entry.path().extension(); kind == ".vtu" || kind == ".json" || kind == ".silent")
      std::filesystem::remove(entry.path(), error);
  note_run(key, until_s);
}

bool SceneFolder::go_on(const std::string& key, std::optional<double> until_s, bool pieces_stay) const {
  const nlohmann::json noted = parse_json(read_file(file(kRunFile)), file(kRunFile).string());
  const auto found = noted.find("until_s");
  const std::optional<double> until =
      found != noted.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
  if (until == until_s) return false;
  if (!until || (until_s && *until_s < *until))
    throw InputError("--until-s", "the folder's motion goes on until " + (until ? to_text(*until) + " s" : "its end"),
                     to_text(*until_s), "a later end, or a run without --resume");
  remove_results();
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "modes", error))
    if (!pieces_stay && entry.path().filename().string().starts_with("piece-"))
      std::filesystem::remove(entry.path(), error);
  note_run(key, until_s);
  return true;
}

void SceneFolder::require(const std::string& key) const {
  if (!has(kRunFile)) throw InputError("--resume", "there is no run in the folder", folder_.string());
  const nlohmann::json noted = parse_json(read_file(file(kRunFile)), file(kRunFile).string());
  if (text_under(noted, "run") != key)
    throw InputError("--resume", "the folder holds the run of another scene, other options or another version",
                     folder_.string(), "the same scene and options, or a run without --resume");
}

}  // namespace klang::apps
