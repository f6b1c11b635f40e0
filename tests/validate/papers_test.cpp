#include "validate/papers/papers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
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
  EXPECT_EQ(verdict_of(number(100, 200, 0.01, true)), PaperVerdict::kPaperOff);
  EXPECT_EQ(verdict_of(number(100, 100.5, 0.01, true)), PaperVerdict::kDiffers) << "called wrong, and yet it agrees";
  EXPECT_EQ(verdict_of(number(100, std::nan(""), 0.01, true)), PaperVerdict::kDiffers);
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
  // The page in docs is what the command writes today.
  EXPECT_EQ(read_file(KLANG_SOURCE_DIR "/docs/papers.md"), markdown(tables))
      << "run klang validate papers --markdown docs/papers.md";
}

TEST(Papers, ScenesAreReadFromTheFoldersOfTheirRuns) {
  const auto runs = std::filesystem::temp_directory_path() / "klang-papers-runs";
  std::filesystem::remove_all(runs);
  std::filesystem::create_directories(runs / "sb_tile");
  std::filesystem::create_directories(runs / "liquid_droplet");
  std::filesystem::create_directories(runs / "sb_slab");
  const std::string head =
      R"({"schema_version": 1, "kind": "scene", "provenance": {"command": "klang x", "version": "7"}, )";
  write_file(runs / "sb_tile/scene.json", head + R"("status": "done", "bodies": [{"name": "tile", "parent": null},
      {"name": "tile/1", "parent": "tile"}, {"name": "tile/2", "parent": "tile"}, {"name": "other", "parent": null}]})");
  write_file(runs / "liquid_droplet/run.json", head + R"("status": "done", "n_bubbles": 9, "n_particles": 5})");
  write_file(runs / "sb_slab/scene.json", head + R"("status": "interrupted", "bodies": []})");
  int n_run = 0;
  for (const PaperScene& scene : detail::paper_scenes(runs)) {
    const std::string name = std::filesystem::path(scene.scene).stem();
    if (!scene.ours) {
      EXPECT_EQ(scene.verdict, SceneVerdict::kNotRun) << name;
      continue;
    }
    ++n_run;
    EXPECT_EQ(scene.command, "klang x");
    EXPECT_EQ(scene.version, "7");
    if (name == "tile") EXPECT_EQ(*scene.ours, 3.0);
    if (name == "tile") EXPECT_EQ(scene.verdict, SceneVerdict::kAgrees);
    if (scene.quantity == "bubbles") EXPECT_EQ(scene.verdict, SceneVerdict::kSameOrder);
    if (scene.quantity == "particles") EXPECT_EQ(scene.verdict, SceneVerdict::kOther);
  }
  EXPECT_EQ(n_run, 3) << "pieces of the tile, bubbles and particles of the droplet; an interrupted run says nothing";
  EXPECT_THROW(detail::paper_scenes(runs / "gone"), InputError);
  for (const PaperScene& scene : detail::paper_scenes({}))
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(KLANG_SOURCE_DIR) / scene.scene)) << scene.scene;
}

TEST(Papers, ChimesAreThoseOfTheDataTable) {
  std::istringstream lines(read_file(KLANG_SOURCE_DIR "/datasets-synthetic/tables/s02_table2_chimes.csv"));
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
