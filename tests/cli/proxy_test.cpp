// klang proxy: build, info, lookup, and bad input.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/output_file.hpp"
#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using klang::test::expect_refused;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;

namespace {

const std::string kBuild =
    "proxy build --no-radiation --thinnest 0.6 --tolerance 0.05 --degree 8 --check-shapes 20 --quiet -o a.bank ";

}  // namespace

TEST(KlangProxy, BuiltBankTellsItsErrorAndFindsTheProxy) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(kBuild + "--json b.json", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("proxy info a.bank --json i.json", scratch.path()).exit_code, 0);
  const nlohmann::json info = read_json(scratch.path() / "i.json");
  EXPECT_GE(info["n_cells"].get<int>(), 3);
  EXPECT_LE(info["max_interpolation_error"].get<double>(), 0.05);
  EXPECT_EQ(info["bytes"].get<std::size_t>(), std::filesystem::file_size(scratch.path() / "a.bank"));
  // A ball of glass of 50 mm radius: omega a / c_s = 2.501... at nu = 0.2 too (its lowest mode is a torsion).
  ASSERT_EQ(run_klang("proxy lookup a.bank --inertia 1,1,1 --lowest-frequency-hz 25096 --json l.json", scratch.path())
                .exit_code,
            0);
  const nlohmann::json found = read_json(scratch.path() / "l.json");
  for (const double axis : found["axes"]) EXPECT_LE(std::abs(axis - std::sqrt(1.0 / 3.0)), 1e-12);
  EXPECT_LE(std::abs(found["axes_m"][0].get<double>() / 0.05 - 1.0), 1e-3);
  EXPECT_LE(std::abs(found["frequencies_hz"][0].get<double>() - 25096.0), 1e-6);
  EXPECT_LE(std::abs(found["frequencies_hz"][4].get<double>() - 25096.0), 25.0);  // five-fold
}

TEST(KlangProxy, FitTellsErrorsBeforeAndAfter) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(kBuild, scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("modes --shape box --dims length_m=0.16,width_m=0.13,height_m=0.1 --max-edge-m 0.05 "
                      "--no-mesh-error --material youngs_modulus_pa=6.2e10,poissons_ratio=0.2,density_kg_m3=2600 "
                      "--count 8 -o box.vtu",
                      scratch.path())
                .exit_code,
            0);
  const auto run = run_klang("proxy fit a.bank box.vtu -o out --duration-s 0.1 --generations 1", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json fit = read_json(scratch.path() / "out/fit.json");
  for (const char* key : {"partial_rms_cents", "log_spectral_distance_db", "loudness_difference_db"})
    EXPECT_LE(fit["after"][key].get<double>(), fit["before"][key].get<double>() * (1.0 + 1e-9) + 1e-9) << key;
  EXPECT_EQ(fit["parameters"].size(), 6U);
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "out/after.wav"));
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "out/report.html"));
  EXPECT_FALSE(fit["radiation"].get<bool>());
  ASSERT_EQ(run_klang("modes --shape box --dims length_m=0.16,width_m=0.13,height_m=0.1 --max-edge-m 0.05 "
                      "--no-mesh-error --material youngs_modulus_pa=6.2e10,poissons_ratio=0.3,density_kg_m3=2600 "
                      "--count 3 -o other.vtu",
                      scratch.path())
                .exit_code,
            0);
  expect_refused(scratch, "proxy fit a.bank other.vtu -o out2", {"another Poisson's ratio"});
}

// A box struck at a corner, heard as a recording: the level is arbitrary, the damping unknown.
TEST(KlangProxy, RecordingIsFittedWithoutItsModel) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(kBuild, scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("modes --shape box --dims length_m=0.16,width_m=0.13,height_m=0.1 --max-edge-m 0.05 --material "
                      "youngs_modulus_pa=6.2e10,poissons_ratio=0.2,density_kg_m3=2600 "
                      "--count 8 -o box.vtu",
                      scratch.path())
                .exit_code,
            0);
  ASSERT_EQ(run_klang("synth box.vtu -o box.wav --strike "
                      "time_s=0.05,x_m=0.08,y_m=0.065,z_m=0.05,fx_n_s=0.02,fy_n_s=0.03,fz_n_s=0.05,contact_s=1e-5 "
                      "--rayleigh-mass-per-s 10 --rayleigh-stiffness-s 1e-8 --duration-s 0.6 --quiet",
                      scratch.path())
                .exit_code,
            0);
  const auto run = run_klang("proxy fit a.bank box.wav -o out --duration-s 0.1 --generations 1", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json fit = read_json(scratch.path() / "out/fit.json");
  EXPECT_EQ(fit["target_kind"], "recording");
  EXPECT_LE(fit["before"]["loudness_difference_db"].get<double>(), 1e-9);
  for (const auto& [key, value] : fit["before"].items())
    EXPECT_LE(fit["after"][key].get<double>(), value.get<double>() * (1.0 + 1e-9) + 1e-9) << key;
  EXPECT_LE(
      std::abs(fit["partials"][0]["before_hz"].get<double>() / fit["partials"][0]["target_hz"].get<double>() - 1.0),
      1e-9);
  EXPECT_LE(std::abs(fit["start"]["rayleigh_mass_per_s"].get<double>() - 10.0), 3.0);
  expect_refused(scratch, "proxy fit a.bank box.wav --transfer box.vtu -o out2", {"not of a recording"});
}

TEST(KlangProxy, BadInputIsRefused) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(kBuild, scratch.path()).exit_code, 0);
  expect_refused(scratch, "proxy lookup a.bank --inertia 3,1,1 --lowest-frequency-hz 500 --json l.json",
                 {"no body has these moments"});
  expect_refused(scratch, "proxy lookup a.bank --inertia 1,1 --lowest-frequency-hz 500", {"--inertia"});
  expect_refused(scratch, "proxy lookup a.bank --inertia 1,1,1 --lowest-frequency-hz 0", {"lowest-frequency-hz"});
  expect_refused(scratch, "proxy lookup a.bank --inertia 1,1,1 --lowest-frequency-hz 500 --poissons-ratio 0.3",
                 {"another Poisson's ratio"});
  expect_refused(scratch, "proxy build --poissons-ratio 0.6 -o b.bank", {"poissons_ratio"});
  expect_refused(scratch, "proxy build --tolerance 0 -o b.bank", {"tolerance"});
  const std::string bytes = klang::read_file(scratch.path() / "a.bank");
  scratch.write("short.bank", std::string_view(bytes).substr(0, bytes.size() / 2));
  expect_refused(scratch, "proxy info short.bank", {"truncated"});
  scratch.write("sound.bank", std::string(200, 'x'));
  expect_refused(scratch, "proxy info sound.bank", {"no soundbank"});
}
