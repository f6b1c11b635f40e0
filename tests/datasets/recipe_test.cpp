#include "datasets-synthetic/recipe.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "datasets-synthetic/body_modes.hpp"
#include "datasets-synthetic/disturbances.hpp"
#include "datasets-synthetic/drop_recipe.hpp"
#include "datasets-synthetic/recipe_spec.hpp"
#include "tests/places.hpp"

namespace klang::datasets {
namespace {

using nlohmann::json;

const std::filesystem::path kFolder = std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic";

// A short bar whose few modes take milliseconds.
std::string bar_recipe(const std::string& more = "", const std::string& sound = "duration_s = 0.5") {
  return "[material]\nyoungs_modulus_pa = 70e9\npoissons_ratio = 0.3\ndensity_kg_m3 = 2700.0\n"
         "[damping]\nmodel = \"rayleigh\"\nrayleigh_stiffness_s = 2e-7\nrayleigh_mass_per_s = "
         "4.0\n[sound]\n" +
         sound + "\nhighest_hz = 9000\n" + more +
         "\n[[specimen]]\nname = \"bar\"\nshape = { kind = \"box\", length_m = 0.15, width_m = 0.02, "
         "height_m "
         "= 0.008 }\n"
         "strike = [{ time_s = 0.05003, at = [1.0, 0.6, 1.0], impulse_n_s = [0.0, 0.003, -0.01], contact_s = "
         "1e-5 }]\n"
         "pickup = [{ at = [-1.0, 0.7, 1.0], direction = [0.0, 0.2, 1.0] }, { at = [0.3, 1, 1], direction = "
         "[0, 0, 1] }]\n";
}

Eigen::VectorXd sum_of_partials(const SyntheticRecording& r, Eigen::Index from) {
  const auto n = r.signal.n_frames();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < r.frequency_hz.size(); ++i) {
    for (Eigen::Index k = from; k < n; ++k) {
      const double t = static_cast<double>(k) / r.signal.sample_rate_hz - r.strikes_s[0];
      sum[k] += r.amplitude[i] * std::exp(-r.decay_per_s[i] * t) *
                std::cos(2.0 * kPi * r.frequency_hz[i] * t + r.phase_rad[i]);
    }
  }
  return sum;
}

TEST(Recipe, CleanRecordingIsTheSumOfItsTruePartials) {
  const Dataset d = make_dataset_from_text(bar_recipe(), "bar", 1);
  ASSERT_EQ(d.recordings.size(), 1u);
  const auto& r = d.recordings[0];
  ASSERT_GE(r.frequency_hz.size(), 3u);
  ASSERT_EQ(r.signal.n_channels(), 2);
  const Eigen::Index from = static_cast<Eigen::Index>(0.0502 * 48000) + 1;  // after the pulse
  const Eigen::VectorXd difference = r.signal.samples.col(0) - sum_of_partials(r, from);
  EXPECT_LE(difference.tail(difference.size() - from).cwiseAbs().maxCoeff(),
            1e-9);  // of full scale; peak is 0.5
  EXPECT_NEAR(r.signal.samples.cwiseAbs().maxCoeff(), 0.5, 1e-12);
}

TEST(Recipe, PartialsOfABarAreTheRitzFrequenciesWithRayleighDecay) {
  const Dataset d = make_dataset_from_text(bar_recipe(), "bar", 1);
  const auto& r = d.recordings[0];
  const auto modes = body_modes({"box", {{"length_m", 0.15}, {"width_m", 0.02}, {"height_m", 0.008}}, {}},
                                solid::from_youngs_modulus(70e9, 0.3, 2700.0), {}, 9000.0, {{1.0, 0.6, 1.0}});
  ASSERT_EQ(static_cast<std::size_t>(modes.angular_frequency_rad_s.size()), r.frequency_hz.size());
  for (std::size_t i = 0; i < r.frequency_hz.size(); ++i) {
    const double omega = modes.angular_frequency_rad_s[static_cast<Eigen::Index>(i)];
    const double decay = 0.5 * (2e-7 * omega * omega + 4.0);
    EXPECT_NEAR(r.decay_per_s[i], decay, 1e-12 * decay);
    EXPECT_NEAR(r.frequency_hz[i], std::sqrt(omega * omega - decay * decay) / (2 * kPi), 1e-9);
  }
}

TEST(Recipe, SameSeedGivesSameBitsOnAnyNumberOfThreads) {
  const std::string text =
      bar_recipe("[noise]\nsnr_db = 30\ncolour = \"pink\"\n[room]\nrt60_s = 0.2\n[mains]\namplitude = 0.01\n");
  set_thread_count(1);
  const Dataset one = make_dataset_from_text(text, "bar", 5);
  set_thread_count(0);
  const Dataset many = make_dataset_from_text(text, "bar", 5), other = make_dataset_from_text(text, "bar", 6);
  const auto bits = [](const Dataset& d) { return d.recordings[0].signal.samples; };
  EXPECT_EQ((bits(one) - bits(many)).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(one.truth_json, many.truth_json);
  EXPECT_GT((bits(one) - bits(other)).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(Recipe, NoiseHasTheAskedPower) {
  const Dataset clean = make_dataset_from_text(bar_recipe(), "bar", 1);
  for (const char* colour : {"white", "pink"}) {
    const Dataset noisy = make_dataset_from_text(
        bar_recipe("[noise]\nsnr_db = 20\ncolour = \"" + std::string(colour) + "\"\n"), "bar", 1);
    for (Eigen::Index c = 0; c < 2; ++c) {
      const Eigen::VectorXd signal = clean.recordings[0].signal.samples.col(c);
      const Eigen::VectorXd noise = noisy.recordings[0].signal.samples.col(c) - signal;
      // 24000 white samples: power known to 1 %; 5 standard deviations.
      EXPECT_NEAR(10.0 * std::log10(signal.squaredNorm() / noise.squaredNorm()), 20.0, 0.2) << colour;
    }
  }
}

TEST(Disturbances, PinkNoiseFallsByThreeDecibelsAnOctave) {
  RandomStream random(3, 1);
  const Eigen::Index n = 1 << 17;
  const Eigen::VectorXd noise = pink_noise(n, 48000.0, random);
  // Power in octaves of differences: compare band powers by direct projection on a few hundred frequencies a
  // band.
  const auto power = [&](double low_hz) {
    double sum = 0.0;
    for (int k = 0; k < 200; ++k) {
      const double step = 2.0 * kPi * std::round((low_hz + low_hz * k / 200.0) * n / 48000.0) / n;
      double re = 0.0, im = 0.0;
      for (Eigen::Index i = 0; i < n; i += 1) {
        re += noise[i] * std::cos(step * static_cast<double>(i));
        im += noise[i] * std::sin(step * static_cast<double>(i));
      }
      sum += re * re + im * im;
    }
    return sum;
  };
  EXPECT_NEAR(10.0 * std::log10(power(500.0) / power(4000.0)), 9.03,
              1.5);  // 200 lines: 0.3 dB each, 5 deviations
}

TEST(Disturbances, RoomTailHasItsLevelAndDecay) {
  RandomStream random(4, 1);
  Eigen::VectorXd click = Eigen::VectorXd::Zero(48000);
  click[100] = 2.0;
  const Eigen::VectorXd tail = room_tail(click, 48000.0, 0.4, -12.0, random);
  EXPECT_NEAR(10.0 * std::log10(tail.squaredNorm() / 4.0), -12.0, 0.01);
  EXPECT_LE(tail.head(100).cwiseAbs().maxCoeff(), 1e-12);
  const double early = tail.segment(100, 4800).squaredNorm(), late = tail.segment(100 + 9600, 4800).squaredNorm();
  EXPECT_NEAR(10.0 * std::log10(early / late), 30.0, 1.0);  // 0.2 s of 0.4 s: half of 60 dB
}

TEST(Recipe, HumOffsetAndClippingAreAsAsked) {
  const Dataset plain = make_dataset_from_text(bar_recipe(), "bar", 1);
  const Dataset d = make_dataset_from_text(
      bar_recipe("[mains]\namplitude = 0.02\nfrequency_hz = 60\nharmonics = 1\n", "duration_s = 0.5\ndc_offset = 0.1"),
      "bar", 1);
  const Eigen::VectorXd added = d.recordings[0].signal.samples.col(0) - plain.recordings[0].signal.samples.col(0);
  EXPECT_NEAR(added.mean(), 0.1, 1e-12);  // 30 whole periods
  EXPECT_NEAR((added.array() - 0.1).matrix().norm() / std::sqrt(24000.0), 0.02 / std::sqrt(2.0), 1e-9);

  const Dataset clipped = make_dataset_from_text(bar_recipe("", "duration_s = 0.5\nclip_level = 0.2"), "bar", 1);
  const auto& samples = clipped.recordings[0].signal.samples;
  EXPECT_EQ(samples.cwiseAbs().maxCoeff(), 0.2);
  EXPECT_EQ(samples.col(0), plain.recordings[0].signal.samples.col(0).cwiseMax(-0.2).cwiseMin(0.2));
}

TEST(Recipe, SplitPairsBeatByTheAskedDetuning) {
  const std::string tube =
      "[material]\npreset = \"aluminium\"\n[damping]\nmodel = \"loss_factor\"\nloss_factor = 1e-4\n[sound]\n"
      "duration_s = 0.2\nhighest_hz = 2000\n[split_pairs]\nrelative_detuning = 1e-3\n"
      "[[specimen]]\nname = \"t\"\nshape = { kind = \"tube\", length_m = 0.5, outer_radius_m = 0.0125, "
      "wall_m = 0.001 }\n"
      "strike = [{ at = [1, 0, 0.9], impulse_n_s = [-0.01, 0, 0] }]\npickup = [{ at = [1, 0, 0.9], direction "
      "= [1, 0, 0] }]\n";
  const auto r = make_dataset_from_text(tube, "tube", 1).recordings[0];
  ASSERT_EQ(r.frequency_hz.size(), 4u);  // two bending modes, twice
  for (std::size_t pair = 0; pair < 4; pair += 2) {
    const double mean = 0.5 * (r.frequency_hz[pair] + r.frequency_hz[pair + 1]);
    EXPECT_NEAR((r.frequency_hz[pair + 1] - r.frequency_hz[pair]) / mean, 1e-3, 1e-9);
    EXPECT_GT(r.amplitude[pair + 1] / r.amplitude[pair], 0.1);  // both are heard: tan(0.6)^2 = 0.47
    EXPECT_LT(r.amplitude[pair + 1] / r.amplitude[pair], 1.0);
  }
}

TEST(Recipe, UnsplitPairsAreOnePartial) {
  const std::string tube =
      "[material]\npreset = \"aluminium\"\n[damping]\nmodel = \"loss_factor\"\nloss_factor = 1e-4\n[sound]\n"
      "duration_s = 0.2\nhighest_hz = 2000\n"
      "[[specimen]]\nname = \"t\"\nshape = { kind = \"tube\", length_m = 0.5, outer_radius_m = 0.0125, "
      "wall_m = 0.001 }\n"
      "strike = [{ at = [0.6, 0.8, 0.9], impulse_n_s = [-0.006, -0.008, 0] }]\n"
      "pickup = [{ at = [1, 0, 0.9], direction = [1, 0, 0] }]\n";
  EXPECT_EQ(make_dataset_from_text(tube, "tube", 1).recordings[0].frequency_hz.size(), 2u);
}

TEST(Recipe, DampingModelsFollowTheirFormulas) {
  const auto with = [](const std::string& damping) {
    std::string text = bar_recipe();
    const auto begin = text.find("[damping]"), end = text.find("[sound]");
    return parse_recipe(text.replace(begin, end - begin, "[damping]\n" + damping + "\n"), "bar", {});
  };
  const double omega = 2 * kPi * 1500.0;
  EXPECT_DOUBLE_EQ(with("model = \"loss_factor\"\nloss_factor = 2e-3").decay_per_s(omega), 1e-3 * omega);
  const double x = omega * 1e-4;
  EXPECT_DOUBLE_EQ(with("model = \"zener\"\nzener_strength = 1e-2\nzener_relaxation_time_s = 1e-4").decay_per_s(omega),
                   0.5e-2 * omega * x / (1 + x * x));
  EXPECT_THROW(with("model = \"zener\"\nzener_strength = 1e-2\nzener_relaxation_time_s = 1e-4\nloss_factor = 1e-3"),
               InputError);
}

TEST(Recipe, MountsDampTheModesThatMoveThem) {
  const auto plain = make_dataset_from_text(bar_recipe(), "r.toml", 1);
  const std::string mount =
      "mount = [{ at = [0.0, 0.0, 1.0], direction = [0.0, 0.0, 2.0], damping_n_s_per_m = 2.0 }]\n";
  const auto mounted = make_dataset_from_text(bar_recipe() + mount, "r.toml", 1);
  const auto &a = plain.recordings[0], &b = mounted.recordings[0];
  ASSERT_EQ(a.frequency_hz.size(), b.frequency_hz.size());
  // The middle is an antinode of the first bending mode and a node of the second: 4/m u^2 of a slender bar's.
  EXPECT_GT(b.decay_per_s[0] - a.decay_per_s[0], 1.0);
  double least = 1e9;
  for (std::size_t i = 0; i < a.decay_per_s.size(); ++i) least = std::min(least, b.decay_per_s[i] - a.decay_per_s[i]);
  EXPECT_LE(std::abs(least), 1e-6);
  EXPECT_NE(mounted.specimen_toml.find("mount = [{ at_m = ["), std::string::npos);
}

TEST(Recipe, TruthHoldsMaterialPartialsAndProvenance) {
  const Dataset d = make_dataset_from_text(bar_recipe("[noise]\nsnr_db = 40\n"), "bar", 77);
  const json truth = json::parse(d.truth_json);
  EXPECT_EQ(truth["schema_version"], 1);
  EXPECT_EQ(truth["provenance"]["seed"], 77);
  EXPECT_DOUBLE_EQ(truth["material"]["youngs_modulus_pa"], 70e9);
  const json& specimen = truth["specimens"][0];
  ASSERT_EQ(specimen["partials"].size(), d.recordings[0].frequency_hz.size());
  EXPECT_EQ(specimen["partials"][0]["frequency_hz"], d.recordings[0].frequency_hz[0]);
  EXPECT_NEAR(specimen["mass_kg"], 0.15 * 0.02 * 0.008 * 2700.0, 1e-12);
  EXPECT_EQ(specimen["channels"].size(), 2u);
  EXPECT_NEAR(specimen["channels"][0]["noise_rms"].get<double>() / specimen["channels"][0]["sound_rms"].get<double>(),
              0.01, 1e-12);
}

TEST(BodyModes, ZeroDetuningTakesAwayTheSplitOfAMesh) {
  BodyModes modes;
  modes.angular_frequency_rad_s = Eigen::Vector4d(1000.0, 1000.4, 1500.0, 2000.0);
  modes.shapes = {Eigen::MatrixXd::Identity(3, 4)};
  modes.pair_tolerance = 1e-3;
  split_pairs(modes, 0.0, 0.0);
  EXPECT_EQ(modes.angular_frequency_rad_s, Eigen::Vector4d(1000.2, 1000.2, 1500.0, 2000.0));
  EXPECT_EQ(modes.shapes[0], Eigen::MatrixXd::Identity(3, 4));
}

TEST(BodyModes, ClampedBarByElementsMatchesTheBeamWithinOnePercent) {
  const mesh::ShapeSpec box{"box", {{"length_m", 0.15}, {"width_m", 0.02}, {"height_m", 0.01}}, {}};
  const auto material = solid::from_youngs_modulus(70e9, 0.3, 2700.0);
  const solid::Support clamp{solid::SupportKind::kClamped, "x=-0.075"};
  const auto held = body_modes(box, material, clamp, 4000.0, {{1.0, 0.0, 1.0}});
  ASSERT_GE(held.angular_frequency_rad_s.size(), 1);
  // Euler-Bernoulli; shear and the held cross-section change it by less than 1 % at this slenderness.
  const double beam = 3.5160152685 * std::sqrt(70e9 * 0.01 * 0.01 / (12.0 * 2700.0)) / (0.15 * 0.15);
  EXPECT_NEAR(held.angular_frequency_rad_s[0] / beam, 1.0, 0.01);
  EXPECT_NEAR(held.places_m[0][0], 0.075, 1e-9);
}

std::string message_of(const std::string& toml) {
  try {
    parse_recipe(toml, "r.toml", {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RecipeParser, MistakesAreNamedWithLineAndKey) {
  EXPECT_NE(message_of(bar_recipe("[noise]\nsnr = 3\n")).find("r.toml:13: noise.snr: unknown key"), std::string::npos)
      << message_of(bar_recipe("[noise]\nsnr = 3\n"));
  EXPECT_NE(message_of(bar_recipe("[noise]\nsnr_db = \"loud\"\n")).find("noise.snr_db: must be a number"),
            std::string::npos);
  EXPECT_NE(message_of(bar_recipe("[room]\nrt60_s = -1\n")).find("room.rt60_s: value is out of range (-1;"),
            std::string::npos);
  EXPECT_NE(message_of("").find("material: is missing"), std::string::npos);
  EXPECT_NE(message_of("a = [").find("r.toml:1"), std::string::npos);
  EXPECT_NE(message_of(bar_recipe("[noise]\nsnr_db = nan\n")).find("out of range"), std::string::npos);
  std::string mounted = bar_recipe();
  mounted += "mount = [{ at = [0.0, 0.0, 1.0], direction = [0.0, 0.0, 0.0], damping_n_s_per_m = 1.0 }]\n";
  EXPECT_NE(message_of(mounted).find("direction: is zero"), std::string::npos) << message_of(mounted);
  std::string text = bar_recipe();
  text.replace(text.find("width_m = 0.02"), 14, "width_m = -1.0");
  EXPECT_NE(message_of(text).find("width_m"), std::string::npos);
}

TEST(RecipeParser, SchemaDocumentIsUpToDate) {
  EXPECT_EQ(read_file(std::filesystem::path(klang::test::source_dir()) / "docs/recipes.md"), recipe_schema_markdown());
}

TEST(RecipeFiles, EveryCommittedRecipeParses) {
  int n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder / "recipes")) {
    const std::string text = read_file(entry.path()), name = entry.path().filename().string();
    if (is_drop_recipe(text)) {
      EXPECT_NO_THROW(parse_drop_recipe(text, name, 1)) << entry.path();
    } else {
      EXPECT_NO_THROW(parse_recipe(text, name, kFolder)) << entry.path();
    }
    ++n;
  }
  EXPECT_GE(n, 5);
}

TEST(RecipeFiles, SixChimesRingWithTheirBendingPartials) {
  const Dataset d = make_dataset(kFolder / "recipes/six_chimes.toml", 1);
  ASSERT_EQ(d.recordings.size(), 6u);
  for (const auto& r : d.recordings) {
    EXPECT_GE(r.frequency_hz.size(), 5u) << r.name;
    // What can be heard can be told apart: no n = 2 cluster near 4.5 kHz, the axial modes far below.
    const double loudest = *std::max_element(r.amplitude.begin(), r.amplitude.end());
    double before = 0.0;
    for (std::size_t i = 0; i < r.frequency_hz.size(); ++i) {
      if (r.amplitude[i] < 1e-3 * loudest) continue;
      EXPECT_GT(r.frequency_hz[i] - before, 400.0) << r.name;
      before = r.frequency_hz[i];
    }
    EXPECT_EQ(r.signal.n_frames(), 192000);
    EXPECT_NE(d.specimen_toml.find("recording = \"" + r.name + ".wav\""), std::string::npos);
  }
  // S02 Table 2's pitch to 2 %: E 68.9 GPa instead of the paper's aluminium changes it by 0.4 %.
  EXPECT_NEAR(d.recordings[0].frequency_hz[0] / 585.8, 1.0, 0.02);
  EXPECT_NEAR(d.recordings[5].frequency_hz[0] / 1167.0, 1.0, 0.02);
}

TEST(Tables, ChimesCsvAndJsonAgree) {
  const json table = json::parse(read_file(kFolder / "tables/s02_table2_chimes.json"));
  std::istringstream csv(read_file(kFolder / "tables/s02_table2_chimes.csv"));
  std::string line;
  std::getline(csv, line);
  std::size_t row = 0;
  while (std::getline(csv, line)) {
    const json& chime = table["chimes"][row++];
    std::istringstream cells(line);
    std::string cell;
    std::vector<std::string> values;
    while (std::getline(cells, cell, ',')) values.push_back(cell);
    ASSERT_EQ(values.size(), 8u);
    EXPECT_EQ(values[1], chime["sounding_note"]);
    EXPECT_EQ(std::stod(values[3]), chime["measured_length_m"].get<double>());
    EXPECT_EQ(std::stod(values[4]), chime["measured_frequency_hz"].get<double>());
    const auto partials = read_file(kFolder / "tables" / ("s02_chime_" + values[1] + ".csv"));
    EXPECT_EQ(std::stod(partials.substr(partials.find('\n') + 1)), chime["measured_frequency_hz"].get<double>());
  }
  EXPECT_EQ(row, 6u);
}

}  // namespace
}  // namespace klang::datasets
