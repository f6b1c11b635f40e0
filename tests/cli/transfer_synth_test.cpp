// klang synth --transfer: sound at the ear of a moving listener.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/sound/audio/sound_file.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"
#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;
using nlohmann::json;
using namespace klang;

namespace {

// A small block with four modes, m.vtu, and a transfer of a dipole along z for each of them, t.vtu.
class KlangSynthTransfer : public testing::Test {
 protected:
  void SetUp() override {
    const auto run = run_klang(
        "modes --element p1 --shape box --dims length_m=0.1,width_m=0.08,height_m=0.05 --material aluminium --count 4 "
        "-o m.vtu",
        scratch.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const modal::ModalModel model = modal::read_modal_model(scratch.path() / "m.vtu");
    acoustics::TransferModel transfer;
    for (int i = 0; i < 4; ++i) {
      acoustics::ModeTransfer mode;
      mode.mode = i;
      mode.frequency_hz = model.frequency_hz()[i];
      mode.multipole.wavenumber_per_m = transfer.medium.wavenumber_per_m(mode.frequency_hz);
      mode.multipole.order = 1;
      mode.multipole.coefficients_pa = Eigen::VectorXcd::Zero(4);
      mode.multipole.coefficients_pa[acoustics::basis_index(1, 0)] = {3.0, 4.0};
      mode.radiated_power_w = 1e-3;
      mode.decay_radiation_per_s = 2.0;
      transfer.modes.push_back(mode);
    }
    acoustics::write_transfer_model(scratch.path() / "t.vtu", transfer);
    transfer.modes[2].frequency_hz *= 1.01;
    acoustics::write_transfer_model(scratch.path() / "other.vtu", transfer);
  }
  void expect_refused(const std::string& arguments, const std::string& word) {
    klang::test::expect_refused(scratch, "synth m.vtu -o a.wav " + arguments, {word});
  }
  Scratch scratch;
};

TEST_F(KlangSynthTransfer, OneEarWithoutAListenerStandsOnTheAxisOfTheDipole) {
  const auto run = run_klang("synth m.vtu -o a.wav --transfer t.vtu --duration-s 0.2 --loss-factor 1e-3 --json a.json",
                             scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(scratch.path() / "a.json");
  const auto at = result["transfer"]["listener_at_start_m"];
  EXPECT_GE(std::abs(at[2].get<double>()), 0.95);
  EXPECT_EQ(result["transfer"]["n_ears"], 1);
  EXPECT_EQ(result["transfer"]["n_modes_heard"], 4);
  EXPECT_EQ(result["transfer"]["device"], "processor");
  EXPECT_GT(result["transfer"]["peak_pressure_pa"].get<double>(), 0.0);
  EXPECT_EQ(audio::read_sound(scratch.path() / "a.wav").n_channels(), 1);
}

TEST_F(KlangSynthTransfer, PathWithTwoEarsAndDelayIsStereoAndStartsLate) {
  scratch.write("walk.csv", "time_s,x_m,y_m,z_m\n0,0,0,3.43\n1,0,2,3.43\n");
  const auto run = run_klang(
      "synth m.vtu -o a.wav --transfer t.vtu --listener walk.csv --ears-m 0.17 --delay --duration-s 0.2 --loss-factor "
      "1e-3 --json a.json",
      scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const audio::Signal sound = audio::read_sound(scratch.path() / "a.wav");
  ASSERT_EQ(sound.n_channels(), 2);
  EXPECT_EQ(sound.samples.topRows(479).cwiseAbs().maxCoeff(), 0.0);  // 3.43 m / 343 m/s = 480 samples
  EXPECT_GT(sound.samples.middleRows(480, 200).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_EQ(read_json(scratch.path() / "a.json")["transfer"]["listener_moves"], true);
}

TEST_F(KlangSynthTransfer, RadiationDampingAddsToTheDecays) {
  ASSERT_EQ(run_klang("synth m.vtu -o a.wav --transfer t.vtu --rayleigh-mass-per-s 4 --radiation-damping --duration-s "
                      "0.1 --json a.json",
                      scratch.path())
                .exit_code,
            0);
  EXPECT_LE(std::abs(read_json(scratch.path() / "a.json")["modes"][0]["decay_per_s"].get<double>() - 4.0), 1e-12);
}

TEST_F(KlangSynthTransfer, UnitTransferAndOpenClRun) {
  ASSERT_EQ(
      run_klang("synth m.vtu -o u.wav --transfer t.vtu --unit-transfer --duration-s 0.1", scratch.path()).exit_code, 0);
  ASSERT_EQ(
      run_klang("synth m.vtu -o c.wav --transfer t.vtu --duration-s 0.1 --loss-factor 1e-3", scratch.path()).exit_code,
      0);
  const auto run = run_klang(
      "synth m.vtu -o d.wav --transfer t.vtu --device auto --precision single --duration-s 0.1 --loss-factor 1e-3 "
      "--json d.json",
      scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(read_json(scratch.path() / "d.json")["transfer"]["device"], "processor");
  const audio::Signal c = audio::read_sound(scratch.path() / "c.wav"), d = audio::read_sound(scratch.path() / "d.wav");
  EXPECT_LE((c.samples - d.samples).cwiseAbs().maxCoeff(), 1e-4);  // single precision, and the file's own steps
}

TEST_F(KlangSynthTransfer, WithoutAnOpenClDeviceSaysSoInOneLineAndGoesOn) {
  const auto run =
      run_klang("synth m.vtu -o d.wav --transfer t.vtu --device auto --duration-s 0.1 --loss-factor 1e-3 --json d.json",
                scratch.path(), "OCL_ICD_VENDORS=.");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err_lines(), 1) << run.err;
  EXPECT_EQ(read_json(scratch.path() / "d.json")["transfer"]["device"], "processor");
}

TEST(KlangTransferDevice, SphereOnOpenClIsTheProcessorsAndSaysWhereItWasSolved) {
  const Scratch scratch;
  const std::string sphere = "transfer --sphere dipole --ka 2 --elements 180 ";
  ASSERT_EQ(run_klang(sphere + "--json p.json", scratch.path()).exit_code, 0);
  const json expected = read_json(scratch.path() / "p.json");
  EXPECT_EQ(expected["device"], "processor");
  for (const std::string precision : {"double", "single"}) {
    const auto run = run_klang(sphere + "--device cpu --json d.json --precision " + precision, scratch.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json found = read_json(scratch.path() / "d.json");
    EXPECT_NE(found["device"], "processor");
    const double power = expected["radiated_power_w"];
    EXPECT_LE(std::abs(found["radiated_power_w"].get<double>() - power), (precision == "double" ? 1e-8 : 1e-4) * power);
  }
}

TEST(KlangTransferDevice, WithoutOpenClAutoIsTheProcessorAndAnythingElseSaysSoInOneLine) {
  const Scratch scratch;
  const std::string sphere = "transfer --quiet --sphere dipole --ka 1 --elements 80 --json d.json --device ";
  const auto quiet = run_klang(sphere + "auto", scratch.path(), "OCL_ICD_VENDORS=.");
  EXPECT_EQ(quiet.exit_code, 0) << quiet.err;
  EXPECT_EQ(quiet.err_lines(), 0) << quiet.err;
  const auto run = run_klang(sphere + "cpu", scratch.path(), "OCL_ICD_VENDORS=.");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err_lines(), 1) << run.err;
  EXPECT_EQ(read_json(scratch.path() / "d.json")["device"], "processor");
  klang::test::expect_refused(scratch, "transfer --sphere dipole --ka 1 --device nothing-of-the-kind --json p.json",
                              {"--device", "nothing-of-the-kind", "0 ("});
}

TEST_F(KlangSynthTransfer, BadInputIsRefusedInOneLine) {
  scratch.write("bad.csv", "time_s,x_m,y_m,z_m\n0,0,zero,3\n");
  scratch.write("inside.csv", "0,0,0,0.02\n");
  scratch.write("text.vtu", "hello\n");
  expect_refused("--transfer t.vtu --listener bad.csv", "bad.csv:2");
  expect_refused("--transfer t.vtu --listener nowhere.csv", "nowhere.csv");
  expect_refused("--transfer t.vtu --listener inside.csv", "too close");
  expect_refused("--transfer other.vtu", "another model");
  expect_refused("--transfer text.vtu", "text.vtu");
  expect_refused("--transfer m.vtu", "m.vtu");
  expect_refused("--transfer t.vtu --device nothing-of-the-kind", "nothing-of-the-kind");
  expect_refused("--transfer t.vtu --ears-m -1", "--ears-m");
  expect_refused("--delay", "--transfer");
}

}  // namespace
