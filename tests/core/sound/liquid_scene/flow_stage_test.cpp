#include "core/sound/liquid_scene/flow_stage.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/dual_domain/boundary_file.hpp"
#include "core/sound/liquid_scene/bubbles_stage.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"
#include "core/sound/liquid_scene/run_tables.hpp"
#include "core/sound/liquid_scene/transfer_stage.hpp"
#include "tests/process_file.hpp"

namespace klang::liquid_scene {
namespace {

const std::string kScene =
    "[domain]\nsize_m = [0.06, 0.06, 0.08]\ncell_m = 0.005\nduration_s = 0.05\nframe_rate_hz = 100\n"
    "[[pool]]\ndepth_m = 0.041\n"
    "[[drop]]\nradius_m = 0.01\nposition_m = [0.03, 0.03, 0.06]\nvelocity_m_s = [0, 0, -1]\n"
    "[[solid]]\nshape = { kind = \"sphere\", radius_m = 0.012 }\nposition_m = [0.045, 0.03, 0.035]\n";

class Folder {
 public:
  explicit Folder(const char* name) : path(klang::test::process_file(name)) {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
    write_file(path / "scene.toml", kScene);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

/// Stops after so many calls.
class Impatient : public Monitor {
 public:
  explicit Impatient(int calls) : left_(calls) {}
  bool stop_requested() const override { return left_-- <= 0; }

 private:
  mutable int left_;
};

FlowResult flow(const Folder& folder, Monitor& monitor, bool resume) {
  const LiquidScene scene = read_liquid_scene(folder.path / "scene.toml");
  const RunFolder run(folder.path);
  RunDocument document;
  StageRun stage{scene, run, document, 1, scene.duration_s, 60.0, resume, monitor, {}};
  return run_flow(stage);
}

TEST(FlowStage, StoppedAndResumedItHasTheSameBits) {
  const Folder whole("klang-flow-whole"), cut("klang-flow-cut");
  EXPECT_EQ(flow(whole, silent_monitor(), false), FlowResult::kDone);
  Impatient impatient(23);
  EXPECT_THROW(flow(cut, impatient, false), Interrupted);
  EXPECT_EQ(RunFolder(cut.path).read_document().stages.flow->status, StageStatus::kInterrupted);
  EXPECT_EQ(flow(cut, silent_monitor(), true), FlowResult::kDone);
  for (const char* file : {"flow.csv", "frames.pvd", "frames/boundary_000005.vtp", "fields/000005.klf"})
    EXPECT_TRUE(read_file(whole.path / file) == read_file(cut.path / file)) << file;
}

TEST(FlowStage, EnergyTableHasTheVolumeOfTheStepsAndNotThatOfSolids) {
  const Folder folder("klang-flow-energy");
  write_file(folder.path / "scene.toml",
             "[domain]\nsize_m = [0.06, 0.06, 0.12]\ncell_m = 0.005\nduration_s = 0.1\nframe_rate_hz = 100\n"
             "[[pool]]\ndepth_m = 0.041\n[[inlet]]\nposition_m = [0.03, 0.03, 0.1]\nshape = { kind = \"disc\", "
             "radius_m = 0.008 }\n"
             "flow_l_s = 0.1\nspeed_m_s = 0.497\n"
             "[[solid]]\nshape = { kind = \"sphere\", radius_m = 0.012 }\nposition_m = [0.045, 0.03, 0.02]\n"
             "[[solid]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius_m = 0.012 }\n"
             "position_m = [0.016, 0.03, 0.06]\nmotion = \"free\"\ndensity_kg_m3 = 2500\n");
  EXPECT_EQ(flow(folder, silent_monitor(), false), FlowResult::kDone);
  const LiquidScene scene = read_liquid_scene(folder.path / "scene.toml");
  const RunFolder run(folder.path);
  RunDocument document = run.read_document();
  write_run_tables({scene, run, document, 1, scene.duration_s, 60.0, false, silent_monitor(), {}});
  std::map<double, double> volume;
  CsvFile steps(folder.path / "flow.csv");
  for (steps.next(); steps.next();) volume[*csv_number(steps.cells()[0])] = *csv_number(steps.cells()[1]);
  CsvFile frames(folder.path / "energy.csv");
  int n = 0;
  for (frames.next(); frames.next(); ++n) {
    const double time_s = *csv_number(frames.cells()[0]);
    const auto step = volume.lower_bound(time_s - 1e-9);
    if (time_s == 0.0) continue;  // flow.csv begins at the end of the first step
    ASSERT_TRUE(step != volume.end());
    EXPECT_NEAR(*csv_number(frames.cells()[1]) / step->second, 1.0, 2e-3) << time_s;  // phi has 16 bits
  }
  EXPECT_EQ(n, 11);
  EXPECT_GT(volume.rbegin()->second / volume.begin()->second, 1.05);
}

TEST(FlowStage, EnergyFromNowhereIsSeenAndSloshingAndBlowsAreNot) {
  const auto rows = [](double growth_per_s, double noise, auto potential) {
    std::vector<EnergyRow> list;
    for (int i = 0; i < 200; ++i) {
      const double t = 0.02 * i, amplitude = std::exp(growth_per_s * t), swing = std::pow(std::sin(15.0 * t), 2);
      EnergyRow row;
      row.time_s = t;
      row.kinetic_j = amplitude * swing;
      row.potential_j = 100.0 + amplitude * (1.0 - swing) + noise * (i % 2 == 0 ? 1 : -1) + potential(t);
      list.push_back(row);
    }
    return list;
  };
  const auto none = [](double) { return 0.0; };
  EXPECT_NEAR(*energy_gain(rows(0.1, 0.3, none)), std::exp(0.3) - 1.0, 0.06);
  EXPECT_LE(*energy_gain(rows(0.0, 0.3, none)), 0.03);
  EXPECT_LE(*energy_gain(rows(-0.1, 0.3, none)), 0.0);
  EXPECT_LE(*energy_gain(rows(0.1, 0.3, [](double t) { return -3.0 * t; })), 0.0) << "what falls is given energy";
  std::vector<EnergyRow> few = rows(0.1, 0.0, none);
  few.resize(15);
  EXPECT_FALSE(energy_gain(few).has_value());
}

TEST(FlowStage, SaysWhereMovingSolidsAreAlsoWhenItIsResumed) {
  const Folder whole("klang-flow-ball"), cut("klang-flow-ball-cut");
  for (const Folder* folder : {&whole, &cut})
    write_file(folder->path / "scene.toml",
               "[domain]\nsize_m = [0.06, 0.06, 0.2]\ncell_m = 0.005\nduration_s = 0.05\nframe_rate_hz = 100\n"
               "[[pool]]\ndepth_m = 0.041\n"
               "[[solid]]\nshape = { kind = \"sphere\", radius_m = 0.012 }\nposition_m = [0.045, 0.03, 0.035]\n"
               "[[solid]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius_m = 0.012 }\n"
               "position_m = [0.03, 0.03, 0.15]\nmotion = \"free\"\ndensity_kg_m3 = 2500\n");
  EXPECT_EQ(flow(whole, silent_monitor(), false), FlowResult::kDone);
  Impatient impatient(23);
  EXPECT_THROW(flow(cut, impatient, false), Interrupted);
  EXPECT_EQ(flow(cut, silent_monitor(), true), FlowResult::kDone);
  const std::string text = read_file(whole.path / "solids.csv");
  EXPECT_EQ(text, read_file(cut.path / "solids.csv"));
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "time_s,solid,name,x_m,y_m,z_m,velocity_x_m_s,velocity_y_m_s,velocity_z_m_s");
  int n = 0;
  for (; std::getline(lines, line); ++n) {
    double time_s = 0.0, z = 0.0, vz = 0.0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,2,ball,0.03,0.03,%lf,0,0,%lf", &time_s, &z, &vz), 3) << line;
    EXPECT_NEAR(z, 0.15 - 0.5 * 9.81 * time_s * time_s, 1e-9) << time_s;
    EXPECT_NEAR(vz, -9.81 * time_s, 9.81 * 1e-3) << "of half a step before";
  }
  EXPECT_EQ(n, 51) << "the start and 50 steps";
}

TEST(FlowStage, ADamagedStateIsNotGoneOnFrom) {
  const Folder whole("klang-flow-whole-2"), cut("klang-flow-damaged");
  EXPECT_EQ(flow(whole, silent_monitor(), false), FlowResult::kDone);
  Impatient impatient(23);
  EXPECT_THROW(flow(cut, impatient, false), Interrupted);
  const std::filesystem::path a = cut.path / "checkpoint/a", b = cut.path / "checkpoint/b";
  ASSERT_TRUE(std::filesystem::exists(a) && !std::filesystem::exists(b));
  const std::string bytes = read_file(a);
  for (const std::size_t at : {bytes.size() / 3, bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_file(a, damaged);
    EXPECT_THROW(flow(cut, silent_monitor(), true), InputError) << at;
  }
  write_file(b, bytes);  // the other state is whole: from there, to the same bits
  EXPECT_EQ(flow(cut, silent_monitor(), true), FlowResult::kDone);
  EXPECT_TRUE(read_file(whole.path / "fields/000005.klf") == read_file(cut.path / "fields/000005.klf"));
}

TEST(FlowStage, LeavesFramesThatTheDualDomainSolverTakesAndFieldsThatAgree) {
  const Folder folder("klang-flow-frames");
  EXPECT_EQ(flow(folder, silent_monitor(), false), FlowResult::kDone);
  const LiquidScene scene = read_liquid_scene(folder.path / "scene.toml");
  const bubble::BoundaryFrames files = bubble::find_frames((folder.path / "frames.pvd").string(), 1.0);
  ASSERT_EQ(files.files.size(), 6U);
  const auto frames = folder_frames(scene, RunFolder(folder.path), 6);
  const RunDocument document = RunFolder(folder.path).read_document();
  for (std::size_t f = 0; f < 6; ++f) {
    EXPECT_LE(std::abs(files.time_s[f] - 0.01 * static_cast<double>(f)), 1e-12);
    const bubble::LiquidBoundary boundary(bubble::read_boundary(files.files[f]));
    EXPECT_LE(std::abs(boundary.volume_m3() / document.volume.start_m3 - 1.0), 0.02) << f;
  }
  EXPECT_LE(std::abs(frames->phi_m(0, {0.01, 0.01, 0.02}) + 0.021), 1e-5);
  EXPECT_LE(std::abs(frames->velocity_m_s(5, {0.01, 0.01, 0.02})->norm()), 1.0);
  EXPECT_EQ(frames->cell_m(), 0.005);
  const liquid::HeldFrames held(*frames, 2, 3);
  EXPECT_NE(&*held, frames.get());
  const Eigen::Vector3d x(0.013, 0.027, 0.034);
  for (std::size_t f = 0; f < 6; ++f) {  // those that are held, and the others
    EXPECT_EQ((*held).phi_m(f, x), frames->phi_m(f, x)) << f;
    EXPECT_EQ((*held).velocity_m_s(f, x).value(), frames->velocity_m_s(f, x).value()) << f;
  }
  EXPECT_EQ((*held).time_s().size(), 6U);
}

TEST(BubblesStage, AWindowWithoutThreeFramesIsSaidWhereItFindsNoSeeds) {
  for (const char* const window_s : {"0.019", "0.02"}) {  // frames are 0.01 s apart
    const Folder folder("klang-bubbles-window");
    const std::string table =
        std::string("[entrainment]\nattempts_per_m2_s = 1e5\nthreshold_m_s = -50.0\nwindow_s = ") + window_s + "\n";
    write_file(folder.path / "scene.toml", kScene + table);
    const LiquidScene scene = read_liquid_scene(folder.path / "scene.toml");
    const RunFolder run(folder.path);
    RunDocument document;
    std::string said;
    StageRun stage{scene,
                   run,
                   document,
                   1,
                   0.05,
                   60.0,
                   false,
                   silent_monitor(),
                   [&](const std::string& text) { said += text + "\n"; }};
    ASSERT_EQ(run_flow(stage), FlowResult::kDone);
    run_bubbles(stage);
    ASSERT_TRUE(document.entrainment.has_value());
    EXPECT_EQ(document.entrainment->n_seeds, 0);
    if (std::string(window_s) == "0.019")
      EXPECT_EQ(said, "no seeds were found: window_s = 0.019 holds fewer than three frames, which are 0.01 s apart\n");
    else
      EXPECT_EQ(said, "");
  }
}

TEST(BubblesStage, NoBubbleRingsBelowItsFreePitchUnlessAsPrinted) {
  for (const char* const literature : {"mended", "paper"}) {
    const Folder folder("klang-bubbles-pitch");
    write_file(folder.path / "scene.toml",
               kScene + "[entrainment]\nattempts_per_m2_s = 0.0\nliterature = \"" + literature +
                   "\"\n[[bubble]]\nradius_m = 0.001\nposition_m = [0.02, 0.02, 0.038]\nbirth_s = 0.0\n"
                   "[[bubble]]\nradius_m = 0.001\nposition_m = [0.02, 0.02, 0.075]\nbirth_s = 0.0\n"
                   "[[bubble]]\nradius_m = 0.001\nposition_m = [0.02, 0.02, 0.02]\nbirth_s = 9.0\n");
    const LiquidScene scene = read_liquid_scene(folder.path / "scene.toml");
    const RunFolder run(folder.path);
    RunDocument document;
    std::string said;
    StageRun stage{scene,
                   run,
                   document,
                   1,
                   0.05,
                   60.0,
                   false,
                   silent_monitor(),
                   [&](const std::string& text) {
                     said += text + "\n"; }};
    ASSERT_EQ(run_flow(stage), FlowResult::kDone);
    run_bubbles(stage);
    EXPECT_EQ(said, "1 [[bubble]](s) would be born after the run's end (0.05 s)\n");
    const auto paths = entrainment::read_tracked_bubbles(run.file("bubbles.trk")).paths;
    ASSERT_EQ(paths.size(), 2U);
    EXPECT_TRUE(heard(paths[0], scene.sound).has_value());
    EXPECT_FALSE(heard(paths[1], scene.sound).has_value()) << "born in the air";
    for (const double f : paths[0].frequency_hz)
      EXPECT_GE(f, std::string(literature) == "mended" ? paths[0].frequency_hz.front() * (1.0 - 1e-12) : 0.0);
  }
  const Folder folder("klang-bubbles-solid");
  write_file(folder.path / "scene.toml",
             kScene + "[[bubble]]\nradius_m = 0.001\nposition_m = [0.045, 0.03, 0.035]\nbirth_s = 0.0\n");
  EXPECT_THROW(read_liquid_scene(folder.path / "scene.toml"), InputError) << "in a solid, said before the flow";
}

TEST(BubblesStage, RefusesToEntrainFromFramesWithoutVelocityAndListenersInTheLiquid) {
  const Folder folder("klang-bubbles-import");
  write_file(folder.path / "scene.toml",
             kScene +
                 "[entrainment]\nattempts_per_m2_s = 1e5\n[transfer]\nmethod = \"half_space\"\n"
                 "[[bubble]]\nradius_m = 0.001\nposition_m = [0.02, 0.02, 0.02]\nbirth_s = 0.0\n"
                 "[listener]\nmode = \"mono\"\nposition_m = [0.02, 0.02, 0.03]\n");
  const LiquidScene scene = read_liquid_scene(folder.path / "scene.toml");
  const RunFolder run(folder.path);
  RunDocument document;
  StageRun stage{scene, run, document, 1, 0.05, 60.0, false, silent_monitor(), [](const std::string&) {}};
  ASSERT_EQ(run_flow(stage), FlowResult::kDone);
  document.imported = ImportRecord{"vtp", false, {}};
  EXPECT_THROW(run_bubbles(stage), InputError);
  document.imported->has_velocity = true;
  run_bubbles(stage);
  ASSERT_GE(document.n_bubbles, 1);
  EXPECT_THROW(run_transfer(stage), InputError) << "the listener is in the pool";
}

TEST(FlowStage, FieldsThatAreCutOffAreRefused) {
  const Folder folder("klang-flow-fields");
  const liquid::GridShape shape{4, 5, 6, 0.1};
  liquid::Field phi(4, 5, 6, -0.3);
  phi(1, 2, 3) = 0.7;
  write_fields(folder.path / "a.klf", shape, phi, liquid::MacGrid(shape));
  EXPECT_LE(std::abs(read_fields_file(folder.path / "a.klf").phi_m(1, 2, 3) - 0.7), 1e-4);
  const std::string bytes = read_file(folder.path / "a.klf");
  write_file(folder.path / "b.klf", bytes.substr(0, bytes.size() - 3));
  EXPECT_THROW(read_fields_file(folder.path / "b.klf"), InputError);
  write_file(folder.path / "c.klf", "no fields");
  EXPECT_THROW(read_fields_file(folder.path / "c.klf"), InputError);
}

}  // namespace
}  // namespace klang::liquid_scene
