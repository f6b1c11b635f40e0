// What scenes say of the papers' tables: read from folders of `klang scene run`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
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

/// Pieces of bodies that broke which did not break on: what never broke, such as a projectile, is none.
Number pieces(const json& document) {
  if (!document.contains("bodies") || !document["bodies"].is_array()) return {};
  std::set<std::string> broken;
  for (const json& body : document["bodies"]) broken.insert(text_under(body, "parent"));
  double n = 0.0;
  for (const json& body : document["bodies"])
    n += !text_under(body, "parent").empty() && broken.count(text_under(body, "name")) == 0 ? 1.0 : 0.0;
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

/// Of a liquid, when the stage that makes it is done.
Number of_stage(const json& document, const char* stage, const char* pointer) {
  if (!document.contains("stages") || !document["stages"].is_object()) return {};
  const json& record = document["stages"].value(stage, json());
  if (text_under(record, "status") != "done") return {};
  return number_at(document, pointer);
}

Number n_bubbles(const json& document) { return of_stage(document, "bubbles", "/n_bubbles"); }
Number n_particles(const json& document) { return of_stage(document, "flow", "/n_particles"); }
Number n_solves(const json& document) { return of_stage(document, "transfer", "/n_solves"); }

/// Elastic ones of the first body.
Number n_modes(const json& document) { return number_at(document, "/bodies/0/n_modes"); }

struct Row {
  const char *paper, *place, *scene, *quantity;
  Number printed;
  Number (*read)(const json& document);
  const char* unjudged;  ///< why; null: it is judged
  const char* note;
};

constexpr const char* kPieces = "pieces of bodies that broke, at the end";
constexpr const char* kGrowth = "elements at the end over those at the start";
constexpr const char* kMinutes = "minutes of computation per second of simulation";
constexpr const char* kSizes =
    "sizes, strength and fall are ours; the paper counts objects, it seems with the body that broke: its tile in two "
    "halves is 3";
constexpr const char* kTable =
    "sizes, strength and fall are ours; thickness and ball were chosen so that the top breaks";
constexpr const char* kMachine = "an SGI O2 of 1999 there, another machine here";
constexpr const char* kProcessor = "ours, where no run is given: processor time of one core of a virtual server";
constexpr const char* kWords = "the paper has words or a picture";
constexpr const char* kModes = "elastic modes of the body";
constexpr const char* kChosen = "chosen as the paper's; shapes, sizes and materials are ours";
constexpr const char* kSolves = "one solve serves all bubbles here";

const Row kRows[] = {
    {"SB", "Table 3", "sb/plate", kPieces, 17, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/tile", kPieces, 3, pieces, nullptr, "two halves; the paper counts the tile that broke too"},
    {"SB", "Table 3", "sb/window_1", kPieces, 57, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/window_2", kPieces, 89, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/slab", kPieces, 72, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/wine_glass", kPieces, 83, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/poor_piggy_bank", kPieces, 64, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/rich_piggy_bank", kPieces, 358, pieces, nullptr, kSizes},
    {"SB", "Table 3", "sb/table_setting", kPieces, 328, pieces, nullptr, kTable},
    {"B99", "Figure 10", "b99/wall_1", kGrowth, 8275.0 / 1109.0, element_growth, nullptr,
     "which of the walls is not said"},
    {"B99", "Figure 10", "b99/wall_1_fine", kGrowth, 8275.0 / 1109.0, element_growth, nullptr,
     "of the paper's size; which of the walls is not said"},
    {"B99", "Figure 10", "b99/wall_2", kGrowth, 8275.0 / 1109.0, element_growth, nullptr,
     "which of the walls is not said"},
    {"B99", "Table 1", "b99/glass_slab", kMinutes, 273, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/wall_1", kMinutes, 399, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/wall_1_fine", kMinutes, 399, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/wall_2", kMinutes, 1098, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/bowl_1", kMinutes, 109, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/bowl_2", kMinutes, 115, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/bowl_3", kMinutes, 127, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/bowl_4", kMinutes, 156, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/bowl_real", kMinutes, 347, minutes_per_second, kMachine, kProcessor},
    {"B99", "Table 1", "b99/the_end", kMinutes, 4665, minutes_per_second, kMachine, kProcessor},
    {"B99",
     "Figure 11",
     "b99/bowl_1",
     kPieces,
     {},
     pieces,
     kWords,
     "fewest of the four bowls in the figure; 17 to 41 over five mesh seeds"},
    {"B99",
     "Figure 11",
     "b99/bowl_2",
     kPieces,
     {},
     pieces,
     kWords,
     "strength falls from bowl to bowl, pieces rise, for each of five mesh seeds; 54 to 71"},
    {"B99", "Figure 11", "b99/bowl_3", kPieces, {}, pieces, kWords, "as above; 79 to 118"},
    {"B99", "Figure 11", "b99/bowl_4", kPieces, {}, pieces, kWords, "most; 248 to 299 over five mesh seeds"},
    {"D02",
     "Figure 3",
     "d02/wall_1",
     kPieces,
     {},
     pieces,
     kWords,
     "0, 0.162; gamma1 is lost in the text and ours, errata 70"},
    {"D02",
     "Figure 3",
     "d02/wall_2",
     kPieces,
     {},
     pieces,
     kWords,
     "0.001, 0.162; gamma1 is lost in the text and ours, errata 70"},
    {"D02",
     "Figure 3",
     "d02/wall_3",
     kPieces,
     {},
     pieces,
     kWords,
     "0.01, 0.162; gamma1 is lost in the text and ours, errata 70"},
    {"D02",
     "Figure 3",
     "d02/wall_4",
     kPieces,
     {},
     pieces,
     kWords,
     "0.05, 0.162; gamma1 is lost in the text and ours, errata 70"},
    {"D02", "Figure 3", "d02/wall_5", kPieces, {}, pieces, kWords, "gamma1 = gamma2 = 0: \"purely brittle\""},
    {"D02", "Figure 3", "d02/wall_6", kPieces, {}, pieces, kWords, "0.001, 0.006: \"several large pieces\""},
    {"D02",
     "Figure 3",
     "d02/wall_7",
     kPieces,
     {},
     pieces,
     kWords,
     "0.001, 0.162: \"a small part of the wall\" is torn away"},
    {"D02",
     "Figure 3",
     "d02/wall_8",
     kPieces,
     {},
     pieces,
     kWords,
     "0.001, 0.486: \"obvious amounts of plastic yielding\""},
    {"H03", "Table 1", "h03/brain", kModes, 40, n_modes, kChosen,
     "223 nodes at corners and 960 tetrahedra, the paper 304 and 997"},
    {"H03", "Table 1", "h03/dodo", kModes, 40, n_modes, kChosen,
     "of each of two; 101 nodes at corners and 276 tetrahedra, the paper 113 and 295"},
    {"H03", "Table 1", "h03/bunny", kModes, 32, n_modes, kChosen,
     "5,973 nodes at corners and 31,410 tetrahedra, the paper 15,507 and 37,114 (exchanged in print, errata 16)"},
    {"H03", "Table 1", "h03/bat", kModes, 20, n_modes, kChosen,
     "357 nodes at corners and 1,044 tetrahedra, the paper 310 and 1,030"},
    {"H03", "Table 1", "h03/sheet", kModes, 20, n_modes, kChosen,
     "198 nodes at corners and 480 tetrahedra, the paper 195 and 486"},
    {"H03", "Table 1", "h03/sphere", kModes, 40, n_modes, kChosen,
     "53 nodes at corners and 192 tetrahedra, the paper 80 and 282"},
    {"HF", "Table 1", "liquid/droplet", "bubbles", 14, n_bubbles, nullptr, ""},
    {"HF", "Table 1", "liquid/droplet", "particles", 1965886, n_particles, nullptr,
     "at the end; inlets add, outlets take"},
    {"HF", "Table 1", "liquid/droplet", "solves of the transfer", 2280, n_solves, kSolves, ""},
    {"HF", "Table 1", "liquid/splash", "bubbles", 127, n_bubbles, nullptr, ""},
    {"HF", "Table 1", "liquid/splash", "particles", 3717120, n_particles, nullptr, ""},
    {"HF", "Table 1", "liquid/splash", "solves of the transfer", 25472, n_solves, kSolves, ""},
    {"HF", "Table 1", "liquid/pouring", "bubbles", 7896, n_bubbles, nullptr, ""},
    {"HF", "Table 1", "liquid/pouring", "particles", 668640, n_particles, nullptr,
     "at the end; inlets add, outlets take"},
    {"HF", "Table 1", "liquid/pouring", "solves of the transfer", 363457, n_solves, kSolves, ""},
    {"HF", "Table 1", "liquid/water_step", "bubbles", 26657, n_bubbles, nullptr, ""},
    {"HF", "Table 1", "liquid/water_step", "particles", 393376, n_particles, nullptr,
     "at the end; inlets add, outlets take"},
    {"HF", "Table 1", "liquid/water_step", "solves of the transfer", 616846, n_solves, kSolves, ""},
};

/// A run that was made by hand, of the scene file with this SHA-256 (its first digits).
struct Kept {
  const char *scene, *sha256, *quantity;
  double value;
  const char* version = "0.1.0+g89c1c30e40";
};
constexpr const char* kYieldingContacts = "0.1.0+g0f8d7e3afe";  ///< since contacts are as long as curvature says
constexpr const char* kBreakingAtNodes = "0.1.0+g1c1b754fe8";   ///< since bodies break by what nodes have
constexpr const char* kRichBank = "0.1.0+g513ec1d5e7";
constexpr const char* kKeptOptions = " --no-sound --no-frames";

constexpr const char* kSolvesQuantity = "solves of the transfer";
constexpr const char* kModalBodies = "0.1.0+gbd0d72bab8";
constexpr const char* kDroplet = "0.1.0+g5f27ebe840";
constexpr const char* kWholeLiquids = "0.1.0+gc600085ebb";
const Kept kKept[] = {
    {"sb/plate", "f7396f30fd85", kPieces, 21, kBreakingAtNodes},
    {"sb/tile", "9faa83cddde4", kPieces, 2, kBreakingAtNodes},
    {"sb/window_1", "60dd27c53d7a", kPieces, 112, kBreakingAtNodes},
    {"sb/slab", "ef737100143d", kPieces, 50, kBreakingAtNodes},
    {"sb/wine_glass", "aadd9ebef219", kPieces, 62, kBreakingAtNodes},
    {"sb/window_2", "62d280553677", kPieces, 320, kBreakingAtNodes},
    {"sb/poor_piggy_bank", "60d2fba36f68", kPieces, 50, kBreakingAtNodes},
    {"sb/rich_piggy_bank", "e0121914e170", kPieces, 50, kRichBank},
    {"sb/table_setting", "12067762dc5f", kPieces, 187, kBreakingAtNodes},
    {"b99/wall_1", "522c19ed9fc2", kGrowth, 2258.0 / 900.0, kYieldingContacts},
    {"b99/wall_1_fine", "4ede6d04b36c", kGrowth, 5976.0 / 1080.0, kYieldingContacts},
    {"b99/wall_1_fine", "4ede6d04b36c", kMinutes, 5.93, kYieldingContacts},
    {"b99/wall_2", "ef51fcbf903f", kGrowth, 1211.0 / 576.0, kYieldingContacts},
    {"b99/glass_slab", "7af851e3bca8", kMinutes, 0.48, kYieldingContacts},
    {"b99/wall_1", "522c19ed9fc2", kMinutes, 1.27, kYieldingContacts},
    {"b99/wall_2", "ef51fcbf903f", kMinutes, 0.37, kYieldingContacts},
    {"b99/bowl_1", "d62f9993b2f6", kMinutes, 0.46, kYieldingContacts},
    {"b99/bowl_2", "454bdcb1e521", kMinutes, 0.51, kYieldingContacts},
    {"b99/bowl_3", "a75a37962feb", kMinutes, 0.58, kYieldingContacts},
    {"b99/bowl_4", "ca68a6c1b867", kMinutes, 0.70, kYieldingContacts},
    {"b99/bowl_real", "c0dd5ba83f2a", kMinutes, 1.50, kYieldingContacts},
    {"b99/the_end", "2afd09a7c43a", kMinutes, 0.39, kYieldingContacts},
    {"b99/bowl_1", "d62f9993b2f6", kPieces, 21, kYieldingContacts},
    {"b99/bowl_2", "454bdcb1e521", kPieces, 54, kYieldingContacts},
    {"b99/bowl_3", "a75a37962feb", kPieces, 79, kYieldingContacts},
    {"b99/bowl_4", "ca68a6c1b867", kPieces, 286, kYieldingContacts},
    {"d02/wall_1", "70bf64119466", kPieces, 13, kYieldingContacts},
    {"d02/wall_2", "2cdcc0a012a5", kPieces, 16, kYieldingContacts},
    {"d02/wall_3", "86c9259b57b4", kPieces, 17, kYieldingContacts},
    {"d02/wall_4", "ab81f752d615", kPieces, 67, kYieldingContacts},
    {"d02/wall_5", "e50b0e7285f4", kPieces, 139, kYieldingContacts},
    {"d02/wall_6", "1067967204e6", kPieces, 138, kYieldingContacts},
    {"d02/wall_7", "bd585f7aed58", kPieces, 16, kYieldingContacts},
    {"d02/wall_8", "a97369f4b463", kPieces, 8, kYieldingContacts},
    {"h03/brain", "200de178da1a", kModes, 40, kModalBodies},
    {"h03/dodo", "7f203b08f9f4", kModes, 40, kModalBodies},
    {"h03/bunny", "10f034e9542a", kModes, 32, kModalBodies},
    {"h03/bat", "936433a9949e", kModes, 20, kModalBodies},
    {"h03/sheet", "8ebf67a09f4e", kModes, 20, kModalBodies},
    {"h03/sphere", "f7cbd054584d", kModes, 40, kModalBodies},
    {"liquid/droplet", "c732c3e4c2b3", "particles", 2141484, kDroplet},
    {"liquid/droplet", "c732c3e4c2b3", "bubbles", 10, kDroplet},
    {"liquid/droplet", "c732c3e4c2b3", kSolvesQuantity, 56, kDroplet},
    {"liquid/splash", "a2461a10c4a2", "bubbles", 33, kWholeLiquids},
    {"liquid/splash", "a2461a10c4a2", "particles", 3900783, kWholeLiquids},
    {"liquid/splash", "a2461a10c4a2", kSolvesQuantity, 143, kWholeLiquids},
    {"liquid/pouring", "3520f156c01c", "bubbles", 1733, kWholeLiquids},
    {"liquid/pouring", "3520f156c01c", "particles", 767947, kWholeLiquids},
    {"liquid/pouring", "3520f156c01c", kSolvesQuantity, 7108, kWholeLiquids},
    {"liquid/water_step", "63aeb51ac7dd", "bubbles", 263, kWholeLiquids},
    {"liquid/water_step", "63aeb51ac7dd", "particles", 233828, kWholeLiquids},
    {"liquid/water_step", "63aeb51ac7dd", kSolvesQuantity, 1375, kWholeLiquids},
};

std::string folder_name(std::string scene) {
  scene[scene.find('/')] = '_';
  return scene;
}

SceneVerdict verdict_of(const PaperScene& scene) {
  if (!scene.ours) return scene.verdict;
  if (!scene.reason.empty() || !scene.printed) return SceneVerdict::kNotJudged;
  const double ratio = *scene.ours / *scene.printed;
  if (std::abs(ratio - 1.0) <= 0.1) return SceneVerdict::kAgrees;
  return ratio >= 0.5 && ratio <= 2.0 ? SceneVerdict::kSameOrder : SceneVerdict::kOther;
}

/// What a folder has of a run.
struct Run {
  json document;        ///< null: none that is done
  std::string missing;  ///< why there is none
};

Run run_in(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) return {{}, "no folder"};
  for (const char* name : {"scene.json", "run.json"}) {
    const std::filesystem::path path = folder / name;
    if (!std::filesystem::exists(path)) continue;
    // While it runs, a scene of bodies has a run.json that says whose folder it is and no more.
    if (const json noted = parse_json(read_file(path), path.string());
        noted.is_object() && !noted.contains("schema_version") && noted.contains("run"))
      continue;
    if (json document = read_result_json(path); text_under(document, "status") == "done")
      return {std::move(document), {}};
  }
  return {{}, "unfinished"};
}

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", value);
  return text;
}

/// Whether the run read the scene file; true where that is not there to be held against it.
bool is_of_file(const json& document, const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return true;
  const std::string hash = input_file(file).sha256;
  const json inputs = document.value(json::json_pointer("/provenance/inputs"), json::array());
  return inputs.is_array() && std::any_of(inputs.begin(), inputs.end(),
                                          [&](const json& input) { return text_under(input, "sha256") == hash; });
}

/// Why the run is not one of the scene, empty: it is.
std::string foreign(const json& document, const SceneFile& scene, const std::filesystem::path& file) {
  if (text_under(document, "name") != scene.name) return "the run of another scene: " + text_under(document, "name");
  if (document.contains("imported")) return "the flow is another program's";
  return is_of_file(document, file) ? "" : "the run of another version of the scene file";
}

/// Why the run is not the whole scene, empty: it is.
std::string partial(const json& document, const SceneFile& scene) {
  const Number end_s = number_at(document, "/end_s");
  if (!end_s) return "how far the run came is not said";
  if (std::abs(*end_s - scene.duration_s) > 1e-3 * scene.duration_s)
    return seconds(*end_s) + " of a scene of " + seconds(scene.duration_s);
  const json cracks_push_nothing =
      document.value(json::json_pointer("/provenance/options/without_fracture_impulses"), json(false));
  return cracks_push_nothing == true ? "run without fracture impulses" : "";
}

void read_run(const Row& row, const std::filesystem::path& folder, const SceneFile& file, PaperScene& scene,
              const std::filesystem::path& root) {
  const Run run = run_in(folder);
  scene.reason = run.missing;
  if (!run.document.is_object()) return;
  const json provenance = run.document.value("provenance", json::object());
  if (const std::string command = text_under(provenance, "command"); !command.empty()) scene.command = command;
  scene.version = text_under(provenance, "version");
  scene.reason = foreign(run.document, file, root / scene.scene);
  scene.verdict = SceneVerdict::kNotJudged;
  if (!scene.reason.empty()) return;
  scene.reason = partial(run.document, file);
  scene.ours = row.read(run.document);
  if (!scene.ours && scene.reason.empty()) scene.reason = "the run has not come to it";
  if (scene.reason.empty() && row.unjudged != nullptr) scene.reason = row.unjudged;
}

/// A scene file as it was when its run was kept.
bool unchanged(const Kept& kept, const std::filesystem::path& file) {
  std::error_code error;
  return !std::filesystem::is_regular_file(file, error) || input_file(file).sha256.rfind(kept.sha256, 0) == 0;
}

void take_kept(const Row& row, PaperScene& scene, const std::filesystem::path& root) {
  const bool wall_time = row.read == minutes_per_second;
  scene.reason = wall_time ? "wall times are not kept" : "no run is kept";
  if (wall_time) scene.verdict = SceneVerdict::kNotJudged;
  for (const Kept& kept : kKept) {
    if (row.scene != std::string(kept.scene) || row.quantity != std::string(kept.quantity)) continue;
    scene.ours = kept.value;
    if (!std::string(kept.scene).starts_with("liquid/")) scene.command += kKeptOptions;
    scene.version = kept.version;
    scene.reason = !unchanged(kept, root / scene.scene) ? "the scene file has changed since"
                                                        : std::string(row.unjudged != nullptr ? row.unjudged : "");
  }
}

}  // namespace

const std::vector<SceneFile>& scene_files() {
  static const std::vector<SceneFile> files = {
      {"sb/plate", "plate (SB)", 1.5},
      {"sb/tile", "scored tile (SB)", 2.0},
      {"sb/window_1", "window, G_c 120 J/m2 (SB)", 1.5},
      {"sb/window_2", "window, G_c 50 J/m2 (SB)", 1.5},
      {"sb/slab", "glass slab (SB)", 1.0},
      {"sb/wine_glass", "wine glass (SB)", 1.0},
      {"sb/poor_piggy_bank", "poor piggy bank (SB)", 1.4},
      {"sb/rich_piggy_bank", "rich piggy bank (SB)", 1.4},
      {"sb/table_setting", "table setting (SB)", 1.5},
      {"b99/wall_1", "B99 wall 1", 0.2},
      {"b99/wall_1_fine", "B99 wall 1, cut finer", 0.2},
      {"b99/wall_2", "B99 wall 2", 0.1},
      {"b99/glass_slab", "B99 glass slab", 0.05},
      {"b99/bowl_1", "B99 bowl 1", 0.03},
      {"b99/bowl_2", "B99 bowl 2", 0.03},
      {"b99/bowl_3", "B99 bowl 3", 0.03},
      {"b99/bowl_4", "B99 bowl 4", 0.03},
      {"b99/bowl_real", "B99 comparison bowl", 0.03},
      {"b99/the_end", "B99 The End", 0.02},
      {"d02/wall_1", "D02 wall 1", 0.06},
      {"d02/wall_2", "D02 wall 2", 0.06},
      {"d02/wall_3", "D02 wall 3", 0.06},
      {"d02/wall_4", "D02 wall 4", 0.06},
      {"d02/wall_5", "D02 wall 5", 0.06},
      {"d02/wall_6", "D02 wall 6", 0.06},
      {"d02/wall_7", "D02 wall 7", 0.06},
      {"d02/wall_8", "D02 wall 8", 0.06},
      {"h03/brain", "H03 brain", 0.4},
      {"h03/dodo", "H03 dodo", 0.3},
      {"h03/bunny", "H03 bunny", 1.0},
      {"h03/bat", "H03 bat", 0.15},
      {"h03/sheet", "H03 sheet", 0.6},
      {"h03/sphere", "H03 sphere", 1.0},
      {"liquid/droplet", "droplet", 6.4},
      {"liquid/splash", "splash", 1.5},
      {"liquid/pouring", "pouring", 5.0},
      {"liquid/water_step", "water step", 8.6},
  };
  return files;
}

std::vector<PaperScene> paper_scenes(const std::filesystem::path& runs, const std::filesystem::path& root) {
  if (!runs.empty() && !std::filesystem::is_directory(runs))
    throw InputError(runs.string(), "is no folder with runs of scenes");
  std::vector<PaperScene> scenes;
  for (const Row& row : kRows) {
    const auto file = std::find_if(scene_files().begin(), scene_files().end(),
                                   [&](const SceneFile& f) { return f.scene == std::string(row.scene); });
    if (file == scene_files().end()) throw std::logic_error(std::string("papers: no scene ") + row.scene);
    PaperScene scene;
    scene.paper = row.paper;
    scene.place = row.place;
    scene.scene = std::string("datasets-synthetic/scenes/") + row.scene + ".toml";
    scene.quantity = row.quantity;
    scene.printed = row.printed;
    scene.note = row.note;
    const std::string folder = folder_name(row.scene);
    scene.command = "klang scene run " + scene.scene + " -o RUNS/" + folder;
    if (runs.empty())
      take_kept(row, scene, root);
    else
      read_run(row, runs / folder, *file, scene, root);
    scene.verdict = verdict_of(scene);
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

}  // namespace klang::validate::detail
