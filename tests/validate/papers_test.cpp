#include "validate/papers/papers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/result_header.hpp"
#include "tests/places.hpp"
#include "tests/process_file.hpp"
#include "validate/papers/detail/paper_groups.hpp"

namespace klang::validate {
namespace {

PaperNumber number(double printed, double ours, double tolerance, bool off = false) {
  PaperNumber n;
  n.printed = printed;
  n.ours = ours;
  n.tolerance = tolerance;
  n.paper_off = off;
  return n;
}

}  // namespace

TEST(PaperVerdict, AgreementMisprintsAndOpenDifferencesAreTold) {
  EXPECT_EQ(verdict_of(number(100, 100.5, 0.01)), PaperVerdict::kAgrees);
  EXPECT_EQ(verdict_of(number(100, 102, 0.01)), PaperVerdict::kDiffers);
  PaperNumber misprint = number(100, 200, 0.01, true);
  EXPECT_EQ(verdict_of(misprint), PaperVerdict::kDiffers) << "called wrong, and what is right is not said";
  misprint.reference = 200.0;
  EXPECT_EQ(verdict_of(misprint), PaperVerdict::kPaperOff);
  misprint.ours = 300.0;
  EXPECT_EQ(verdict_of(misprint), PaperVerdict::kDiffers) << "neither the printed number nor the reference";
  misprint.ours = std::nan("");
  EXPECT_EQ(verdict_of(misprint), PaperVerdict::kDiffers);
  misprint.ours = misprint.reference.emplace(100.5);
  EXPECT_EQ(verdict_of(misprint), PaperVerdict::kDiffers) << "called wrong, and yet it agrees";
  PaperNumber wrong = number(100, 100.5, 0.01);
  wrong.reference = 100.0;
  EXPECT_EQ(verdict_of(wrong), PaperVerdict::kDiffers) << "agrees with the paper, not with the reference";
}

TEST(Papers, EveryNumberAgreesOrIsKnownToBeOff) {
  const PaperTables tables = run_papers();
  EXPECT_GE(tables.numbers.size(), 80u);
  std::set<std::string> ids;
  for (const PaperNumber& n : tables.numbers) {
    EXPECT_TRUE(ids.insert(n.id).second) << n.id << " twice";
    EXPECT_NE(n.verdict, PaperVerdict::kDiffers) << n.id << ": printed " << n.printed << ", ours " << n.ours;
    EXPECT_EQ(n.verdict == PaperVerdict::kPaperOff, n.paper_off) << n.id;
    EXPECT_FALSE(n.paper_off && n.note.empty()) << n.id << ": wrong, but why";
  }
  EXPECT_TRUE(tables.passed());
  for (const Claim& claim : claims_of(tables)) EXPECT_TRUE(claim.passed) << claim.name;
  const auto program = std::count_if(tables.numbers.begin(), tables.numbers.end(),
                                     [](const PaperNumber& n) { return n.source == NumberSource::kProgram; });
  const std::string counts = std::to_string(tables.numbers.size()) +
                             " of the papers' own numbers, errata included: " + std::to_string(program) +
                             " computed by the program";
  EXPECT_NE(read_file(klang::test::source_dir() + "/README.md").find(counts), std::string::npos) << counts;
  // The page in docs is what the command writes today.
  EXPECT_EQ(read_file(klang::test::source_dir() + "/docs/papers.md"), markdown(tables))
      << "run klang validate papers --markdown docs/papers.md";
}

namespace {

/// A fresh folder for runs.
std::filesystem::path fresh_runs(const char* name) {
  const auto runs = klang::test::process_file("papers-" + std::string(name));
  std::filesystem::remove_all(runs);
  std::filesystem::create_directories(runs / "sb_tile");
  std::filesystem::create_directories(runs / "liquid_droplet");
  return runs;
}

/// Result of a run of a scene file of today.
std::string result(const std::string& scene, const std::string& fields, const std::string& options = "") {
  const std::string file = klang::test::source_dir() + "/datasets-synthetic/scenes/" + scene + ".toml";
  return R"({"schema_version": 1, "kind": "scene", "status": "done", "provenance": {"command": "klang x",
      "version": "7", "options": {)" +
         options + R"(}, "inputs": [{"path": "f", "sha256": ")" + input_file(file).sha256 + R"("}]}, )" + fields + "}";
}

const std::string kTile = R"j("bodies": [{"name": "tile", "parent": null}, {"name": "tile/1", "parent": "tile"},
      {"name": "tile/2", "parent": "tile"}, {"name": "ball", "parent": null}])j";
const std::string kTileHead = R"j("name": "scored tile (SB)", "end_s": 2, )j";

std::vector<PaperScene> of_scene(const std::filesystem::path& runs, const std::string& stem) {
  std::vector<PaperScene> rows;
  for (const PaperScene& scene : detail::paper_scenes(runs, klang::test::source_dir()))
    if (std::filesystem::path(scene.scene).stem() == stem) rows.push_back(scene);
  return rows;
}

}  // namespace

TEST(Papers, ScenesAreReadFromTheFoldersOfTheirRuns) {
  const auto runs = fresh_runs("whole");
  write_file(runs / "sb_tile/scene.json", result("sb/tile", kTileHead + kTile));
  write_file(runs / "liquid_droplet/run.json",
             result("liquid/droplet", R"j("name": "droplet", "end_s": 6.4, "n_bubbles": 9, "n_particles": 5,
                 "n_solves": 0, "stages": {"flow": {"status": "done"}, "bubbles": {"status": "done"},
                 "transfer": {"status": "interrupted"}, "sound": null})j"));
  const PaperScene tile = of_scene(runs, "tile").at(0);
  EXPECT_EQ(tile.ours, 2.0) << "pieces of what broke: no tile, no ball";
  EXPECT_EQ(tile.verdict, SceneVerdict::kSameOrder);
  EXPECT_EQ(tile.command, "klang x");
  EXPECT_EQ(tile.version, "7");
  const auto droplet = of_scene(runs, "droplet");
  ASSERT_EQ(droplet.size(), 3u);
  EXPECT_EQ(droplet[0].ours, 9.0);
  EXPECT_EQ(droplet[0].verdict, SceneVerdict::kSameOrder);
  EXPECT_EQ(droplet[1].verdict, SceneVerdict::kOther);
  EXPECT_FALSE(droplet[2].ours) << "the transfer is not done";
  EXPECT_EQ(verdict_words(droplet[2]), "not judged: the run has not come to it");
  EXPECT_EQ(verdict_words(of_scene(runs, "slab").at(0)), "not run (no folder)");
  EXPECT_THROW(detail::paper_scenes(runs / "gone"), InputError);
}

TEST(Papers, UnfinishedPartialAndForeignRunsAreNotJudged) {
  const auto runs = fresh_runs("partial");
  const auto words = [&](const std::string& text) {
    write_file(runs / "sb_tile/scene.json", text);
    return verdict_words(of_scene(runs, "tile").at(0));
  };
  EXPECT_EQ(verdict_words(of_scene(runs, "tile").at(0)), "not run (unfinished)");
  EXPECT_EQ(words(result("sb/tile", R"j("name": "scored tile (SB)", "end_s": 0.5, )j" + kTile)),
            "not judged: 0.5 s of a scene of 2 s");
  EXPECT_EQ(words(result("sb/tile", R"j("name": "glass slab (SB)", "end_s": 2, )j" + kTile)),
            "not judged: the run of another scene: glass slab (SB)");
  EXPECT_FALSE(of_scene(runs, "tile").at(0).ours) << "a number of another scene";
  EXPECT_EQ(words(result("sb/slab", kTileHead + kTile)), "not judged: the run of another version of the scene file");
  EXPECT_EQ(words(result("sb/tile", kTileHead + kTile, R"j("without_fracture_impulses": true)j")),
            "not judged: run without fracture impulses");
  EXPECT_EQ(words(result("sb/tile", kTileHead + kTile)), "same order");
  EXPECT_THROW(words("{}"), InputError);
}

TEST(Papers, ScenesAreThoseOfTheirFiles) {
  for (const detail::SceneFile& scene : detail::scene_files()) {
    const std::string text =
        read_file(klang::test::source_dir() + "/datasets-synthetic/scenes/" + std::string(scene.scene) + ".toml");
    EXPECT_NE(text.find("\nname = \"" + std::string(scene.name) + "\"\n"), std::string::npos) << scene.scene;
    const std::size_t at = text.find("\nduration_s = ");
    ASSERT_NE(at, std::string::npos) << scene.scene;
    EXPECT_EQ(std::stod(text.substr(at + 14)), scene.duration_s) << scene.scene;
  }
  for (const PaperScene& scene : detail::paper_scenes({}, klang::test::source_dir()))
    EXPECT_NE(scene.reason, "the scene file has changed since") << scene.scene << ": run it again";
}

TEST(Papers, ChimesAreThoseOfTheDataTable) {
  std::istringstream lines(read_file(klang::test::source_dir() + "/datasets-synthetic/tables/s02_table2_chimes.csv"));
  std::string line;
  std::getline(lines, line);
  for (const detail::Chime& chime : detail::chimes()) {
    ASSERT_TRUE(std::getline(lines, line));
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string text; std::getline(cells, text, ',');) cell.push_back(text);
    ASSERT_EQ(cell.size(), 8u);
    EXPECT_EQ(cell[0], chime.printed_note);
    EXPECT_EQ(cell[1], chime.note);
    const double values[] = {chime.ideal_hz,    chime.length_m,          chime.measured_hz,
                             chime.computed_hz, chime.adjusted_length_m, chime.adjusted_hz};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(std::stod(cell[i + 2]), values[i]) << line;
  }
}

}  // namespace klang::validate
