// What scenes say of the papers' tables: read from folders of `klang scene run`.
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/result_header.hpp"
#include "validate/papers/detail/paper_groups.hpp"

namespace klang::validate::detail {
namespace {

using nlohmann::json;
using Number = std::optional<double>;

Number number_at(const json& document, const char* pointer) {
  const json::json_pointer at(pointer);
  if (!document.contains(at) || !document[at].is_number()) return {};
  return document[at].get<double>();
}

/// Bodies at the end: those that did not break into others.
Number pieces(const json& document) {
  if (!document.contains("bodies") || !document["bodies"].is_array()) return {};
  std::set<std::string> broken;
  for (const json& body : document["bodies"]) broken.insert(text_under(body, "parent"));
  double n = 0.0;
  for (const json& body : document["bodies"]) n += broken.count(text_under(body, "name")) == 0 ? 1.0 : 0.0;
  return n;
}

Number element_growth(const json& document) {
  const Number start = number_at(document, "/cracks/n_elements_start"),
               end = number_at(document, "/cracks/n_elements_end");
  if (!start || !end || !(*start > 0.0)) return {};
  return *end / *start;
}

Number minutes_per_second(const json& document) {
  const Number wall_s = number_at(document, "/wall_time_s/motion"), end_s = number_at(document, "/end_s");
  if (!wall_s || !end_s || !(*end_s > 0.0)) return {};
  return *wall_s / 60.0 / *end_s;
}

Number n_bubbles(const json& document) { return number_at(document, "/n_bubbles"); }
Number n_particles(const json& document) { return number_at(document, "/n_particles"); }
Number n_solves(const json& document) { return number_at(document, "/n_solves"); }

struct Row {
  const char *paper, *place, *scene, *quantity;
  Number printed;
  Number (*read)(const json& document);
  bool judged;  ///< false: another machine, or nothing is printed
  const char* note;
};

constexpr const char* kPieces = "objects at the end";
constexpr const char* kGrowth = "elements at the end over those at the start";
constexpr const char* kMinutes = "minutes of computation per second of simulation";
constexpr const char* kSizes = "sizes, strength and fall are ours";
constexpr const char* kMachine = "there an SGI O2 of 1999, here the wall time of yours";

const Row kRows[] = {
    {"SB", "Table 3", "sb/plate", kPieces, 17, pieces, true, kSizes},
    {"SB", "Table 3", "sb/tile", kPieces, 3, pieces, true, "two halves; with the tile that broke 3"},
    {"SB", "Table 3", "sb/window_1", kPieces, 57, pieces, true, kSizes},
    {"SB", "Table 3", "sb/window_2", kPieces, 89, pieces, true, kSizes},
    {"SB", "Table 3", "sb/slab", kPieces, 72, pieces, true, kSizes},
    {"SB", "Table 3", "sb/wine_glass", kPieces, 83, pieces, true, kSizes},
    {"SB", "Table 3", "sb/poor_piggy_bank", kPieces, 64, pieces, true, kSizes},
    {"SB", "Table 3", "sb/rich_piggy_bank", kPieces, 358, pieces, true, kSizes},
    {"SB", "Table 3", "sb/table_setting", kPieces, 328, pieces, true, kSizes},
    {"B99", "Figure 10", "b99/wall_1", kGrowth, 8275.0 / 1109.0, element_growth, true,
     "which of the walls is not said"},
    {"B99", "Figure 10", "b99/wall_2", kGrowth, 8275.0 / 1109.0, element_growth, true,
     "which of the walls is not said"},
    {"B99", "Table 1", "b99/glass_slab", kMinutes, 273, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/wall_1", kMinutes, 399, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/wall_2", kMinutes, 1098, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/bowl_1", kMinutes, 109, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/bowl_2", kMinutes, 115, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/bowl_3", kMinutes, 127, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/bowl_4", kMinutes, 156, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/bowl_real", kMinutes, 347, minutes_per_second, false, kMachine},
    {"B99", "Table 1", "b99/the_end", kMinutes, 4665, minutes_per_second, false, kMachine},
    {"B99", "Figure 11", "b99/bowl_1", kPieces, {}, pieces, false, "fewest of the four bowls in the figure"},
    {"B99", "Figure 11", "b99/bowl_2", kPieces, {}, pieces, false, "strength falls from bowl to bowl, pieces rise"},
    {"B99", "Figure 11", "b99/bowl_3", kPieces, {}, pieces, false, "as above"},
    {"B99", "Figure 11", "b99/bowl_4", kPieces, {}, pieces, false, "most"},
    {"D02", "Figure 3", "d02/wall_5", kPieces, {}, pieces, false, "gamma1 = gamma2 = 0: \"purely brittle\""},
    {"D02", "Figure 3", "d02/wall_6", kPieces, {}, pieces, false, "0.001, 0.006: \"several large pieces\""},
    {"D02",
     "Figure 3",
     "d02/wall_7",
     kPieces,
     {},
     pieces,
     false,
     "0.001, 0.162: \"a small part of the wall\" is torn away"},
    {"D02",
     "Figure 3",
     "d02/wall_8",
     kPieces,
     {},
     pieces,
     false,
     "0.001, 0.486: \"obvious amounts of plastic yielding\""},
    {"HF", "Table 1", "liquid/droplet", "bubbles", 14, n_bubbles, true, ""},
    {"HF", "Table 1", "liquid/droplet", "particles", 1965886, n_particles, true,
     "at the end; inlets add, outlets take"},
    {"HF", "Table 1", "liquid/droplet", "solves of the transfer", 2280, n_solves, false, "one serves all bubbles here"},
    {"HF", "Table 1", "liquid/splash", "bubbles", 127, n_bubbles, true, ""},
    {"HF", "Table 1", "liquid/splash", "particles", 3717120, n_particles, true, ""},
    {"HF", "Table 1", "liquid/splash", "solves of the transfer", 25472, n_solves, false, "one serves all bubbles here"},
    {"HF", "Table 1", "liquid/pouring", "bubbles", 7896, n_bubbles, true, ""},
    {"HF", "Table 1", "liquid/pouring", "particles", 668640, n_particles, true, "at the end; inlets add, outlets take"},
    {"HF", "Table 1", "liquid/pouring", "solves of the transfer", 363457, n_solves, false,
     "one serves all bubbles here"},
    {"HF", "Table 1", "liquid/water_step", "bubbles", 26657, n_bubbles, true, ""},
    {"HF", "Table 1", "liquid/water_step", "particles", 393376, n_particles, true,
     "at the end; inlets add, outlets take"},
    {"HF", "Table 1", "liquid/water_step", "solves of the transfer", 616846, n_solves, false,
     "one serves all bubbles here"},
};

/// A run that was made by hand.
struct Kept {
  const char *scene, *quantity;
  double value;
  const char *options, *version;
};

const Kept kKept[] = {
    {"sb/plate", kPieces, 21, " --until-s 0.5 --no-sound --no-frames", "0.1.0+g7c8fac74b2"},
    {"sb/tile", kPieces, 2, " --until-s 0.5 --no-sound --no-frames", "0.1.0+g7c8fac74b2"},
    {"sb/slab", kPieces, 148, " --until-s 0.5 --no-sound --no-frames", "0.1.0+g7c8fac74b2"},
    {"b99/wall_2", kGrowth, 2.25, " --no-sound", "0.1.0+g06ed5262a4"},
    {"d02/wall_5", kPieces, 158, " --no-sound", "0.1.0+g7abf857ac2"},
    {"d02/wall_6", kPieces, 135, " --no-sound", "0.1.0+g7abf857ac2"},
    {"d02/wall_7", kPieces, 17, " --no-sound", "0.1.0+g7abf857ac2"},
    {"d02/wall_8", kPieces, 9, " --no-sound", "0.1.0+g7abf857ac2"},
};

std::string folder_name(std::string scene) {
  scene[scene.find('/')] = '_';
  return scene;
}

SceneVerdict verdict_of(const PaperScene& scene, bool judged) {
  if (!scene.ours) return SceneVerdict::kNotRun;
  if (!judged || !scene.printed) return SceneVerdict::kNotJudged;
  const double ratio = *scene.ours / *scene.printed;
  if (std::abs(ratio - 1.0) <= 0.1) return SceneVerdict::kAgrees;
  return ratio >= 0.5 && ratio <= 2.0 ? SceneVerdict::kSameOrder : SceneVerdict::kOther;
}

/// scene.json or run.json of a run, empty where there is none that is done.
json result_in(const std::filesystem::path& folder) {
  for (const char* name : {"scene.json", "run.json"}) {
    if (!std::filesystem::exists(folder / name)) continue;
    const json document = read_result_json(folder / name);
    const std::string status = text_under(document, "status");
    if (status == "done") return document;
  }
  return {};
}

}  // namespace

std::vector<PaperScene> paper_scenes(const std::filesystem::path& runs) {
  if (!runs.empty() && !std::filesystem::is_directory(runs))
    throw InputError(runs.string(), "is no folder with runs of scenes");
  std::vector<PaperScene> scenes;
  for (const Row& row : kRows) {
    PaperScene scene;
    scene.paper = row.paper;
    scene.place = row.place;
    scene.scene = std::string("datasets-synthetic/scenes/") + row.scene + ".toml";
    scene.quantity = row.quantity;
    scene.printed = row.printed;
    scene.note = row.note;
    const std::string folder = folder_name(row.scene);
    scene.command = "klang scene run " + scene.scene + " -o RUNS/" + folder;
    if (!runs.empty()) {
      if (const json document = result_in(runs / folder); document.is_object()) {
        scene.ours = row.read(document);
        if (document.contains("provenance")) {
          if (const std::string command = text_under(document["provenance"], "command"); !command.empty())
            scene.command = command;
          scene.version = text_under(document["provenance"], "version");
        }
      }
    }
    for (const Kept& kept : kKept) {
      if (!runs.empty() || row.scene != std::string(kept.scene) || row.quantity != std::string(kept.quantity)) continue;
      scene.ours = kept.value;
      scene.command += kept.options;
      scene.version = kept.version;
    }
    scene.verdict = verdict_of(scene, row.judged);
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

}  // namespace klang::validate::detail
