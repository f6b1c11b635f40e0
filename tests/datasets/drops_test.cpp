#include "datasets-synthetic/drops.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/physics/bubble/bubble_ring.hpp"
#include "datasets-synthetic/oscillator_ode.hpp"
#include "tests/places.hpp"

namespace klang::datasets {
namespace {

using nlohmann::json;

std::string recipe(const std::string& drops, const std::string& more = "") {
  return "kind = \"drops\"\n[sound]\nduration_s = 0.5\n" + more + "[[recording]]\nname = \"tap\"\ndrop = [" + drops +
         "]\n";
}
const std::string kDrop = "{ onset_s = 0.1003, radius_m = 0.0021, depth_m = 0.01, rise_speed_m_s = 0.25 }";

TEST(OscillatorOde, ConstantCoefficientsGiveTheExactRing) {
  const double omega = 6000.0, decay = 200.0, damped = std::sqrt(omega * omega - decay * decay);
  const Eigen::MatrixXd rows = integrate_oscillator(
      [&](double) {
        return OscillatorCoefficients{omega, decay};
      },
      damped, 1e-5, 1.0 / 48000, 1500);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double t = 1e-5 + static_cast<double>(i) / 48000;
    ASSERT_NEAR(rows(i, 0), std::exp(-decay * t) * std::sin(damped * t), 1e-9 * std::exp(-decay * t));
  }
}

TEST(OscillatorOde, ErrorFallsAtOrderEight) {
  // One step of Gauss's 4 stages is the (4,4) Pade approximation of e^z: its phase error goes as the ninth power of the
  // step.
  std::vector<double> errors;
  for (const double step : {0.39, 0.312, 0.2496, 0.19968}) {  // below the longest step, so that each row is one step
    const Eigen::MatrixXd rows = integrate_oscillator(
        [](double) {
          return OscillatorCoefficients{1.0, 0.0};
        },
        1.0, 0.0, step, static_cast<Eigen::Index>(3000.0 / step) + 1);
    const Eigen::Index last = rows.rows() - 1;
    const double t = static_cast<double>(last) * step;
    errors.push_back(std::abs(std::remainder(std::atan2(rows(last, 0), rows(last, 1)) - t, 2 * kPi)));
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const double order = std::log(errors[i - 1] / errors[i]) / std::log(1.25);
    EXPECT_GE(order, 7.7);
    EXPECT_LE(order, 8.3);
  }
  EXPECT_GE(errors.back(), 1e-11);  // above round-off
  EXPECT_LE(errors[0], 1e-6);
}

TEST(Drops, SoundIsTheAccelerationOfTheAdiabaticSolution) {
  const DropRecipe parsed = parse_drop_recipe(recipe(kDrop), "r", 1);
  const Drop& drop = parsed.recordings[0].drops[0];
  const DropSound sound = drop_sound(drop, parsed);
  bubble::RingingBubble ringing;
  ringing.radius_m = drop.radius_m;
  ringing.pitch = drop.pitch;
  ringing.motion = bubble::analytic_rise({0, 0, -drop.depth_m}, drop.radius_m, drop.rise);
  ringing.onset_velocity_m_s = bubble::entrainment_velocity_m_s(drop.radius_m) * drop.radius_m * drop.radius_m;
  const bubble::RingTrack track = bubble::ring_track(ringing);
  for (Eigen::Index i = 0; i < sound.samples.size(); i += 5) {
    const double age = static_cast<double>(sound.first_frame + i) / 48000.0 - drop.onset_s;
    if (age > sound.life_s) break;
    const auto& block = track.block_at(age);
    const double s = age - block.start_s;
    const std::complex<double> rate = block.rate_at(age);
    const std::complex<double> slope = 2.0 * block.c2 + s * (6.0 * block.c3 + s * 12.0 * block.c4);
    const std::complex<double> acceleration = (rate * rate + slope) * track.value(age);
    ASSERT_NEAR(sound.samples[i], acceleration.real(), 2e-4 * std::abs(acceleration)) << age;
  }
}

TEST(Drops, TruthSaysFrequencyDecayAndOnset) {
  const Dataset d = make_dataset_from_text(recipe(kDrop), "tap", 1);
  ASSERT_EQ(d.recordings.size(), 1u);
  EXPECT_TRUE(d.specimen_toml.empty());
  const json truth = json::parse(d.truth_json);
  const json& b = truth["recordings"][0]["bubbles"][0];
  const auto physics = bubble::bubble_oscillation(0.0021);
  EXPECT_NEAR(b["frequency_start_hz"], physics.damped_frequency_hz, 1e-9);
  EXPECT_NEAR(b["decay_per_s"], physics.decay_per_s, 1e-9);
  EXPECT_GT(b["frequency_end_hz"], 1.3 * physics.damped_frequency_hz);
  EXPECT_EQ(b["onset_s"], 0.1003);
  const auto& samples = d.recordings[0].signal.samples;
  const auto first = static_cast<Eigen::Index>(std::ceil(0.1003 * 48000));
  EXPECT_EQ(samples.topRows(first).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_NE(samples(first + 1, 0), 0.0);
  EXPECT_NEAR(samples.cwiseAbs().maxCoeff(), 0.5, 1e-12);
  EXPECT_NEAR(b["amplitude"], 0.5, 0.05);
}

TEST(Drops, NoiseLiesBelowTheLoudestDropByTheStatedRatio) {
  const std::string two = kDrop + ", { onset_s = 0.3, radius_m = 0.0012, strength = 0.2 }";
  const Dataset clean = make_dataset_from_text(recipe(two), "tap", 1);
  const Dataset noisy = make_dataset_from_text(recipe(two, "[noise]\nsnr_db = 30\n"), "tap", 1);
  const Eigen::VectorXd noise = noisy.recordings[0].signal.samples.col(0) - clean.recordings[0].signal.samples.col(0);
  const double noise_ms = noise.squaredNorm() / static_cast<double>(noise.size());
  const json bubbles = json::parse(noisy.truth_json)["recordings"][0]["bubbles"];
  EXPECT_NEAR(bubbles[0]["snr_db"], 30.0, 1e-9);
  EXPECT_LT(bubbles[1]["snr_db"], 20.0);
  // Level of the pressure along the truth's track: exp(-int decay) f^(3/2).
  const json& track = bubbles[0]["track"];
  double fall = 0.0;
  std::size_t k = 1;
  for (; k < track["time_s"].size(); ++k) {
    fall += 1e-3 * 0.5 * (track["decay_per_s"][k].get<double>() + track["decay_per_s"][k - 1].get<double>());
    if (fall - 1.5 * std::log(track["frequency_hz"][k].get<double>() / track["frequency_hz"][0].get<double>()) >
        std::log(10.0))
      break;
  }
  const auto ring = clean.recordings[0].signal.samples.col(0).segment(static_cast<Eigen::Index>(0.1003 * 48000) + 1,
                                                                      static_cast<Eigen::Index>(k) * 48);
  EXPECT_NEAR(10 * std::log10(ring.squaredNorm() / static_cast<double>(ring.size()) / noise_ms), 30.0, 0.5);
}

TEST(Drops, SeededSetsAreTheSameOnAnyNumberOfThreadsAndKeepTheirGap) {
  const std::string text =
      "kind = \"drops\"\n[noise]\nsnr_db = 20\n[room]\nrt60_s = 0.3\n[[random]]\nname = \"a\"\nrecordings = 3\ndrops = "
      "8\nshortest_gap_s = 0.15\n";
  set_thread_count(1);
  const Dataset one = make_dataset_from_text(text, "r", 5);
  set_thread_count(0);
  const Dataset all = make_dataset_from_text(text, "r", 5);
  ASSERT_EQ(one.recordings.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(one.recordings[i].signal.samples, all.recordings[i].signal.samples);
  EXPECT_EQ(one.truth_json, all.truth_json);
  EXPECT_NE(one.recordings[0].strikes_s, one.recordings[1].strikes_s);
  for (const auto& recording : one.recordings) {
    ASSERT_EQ(recording.strikes_s.size(), 8u);
    for (std::size_t k = 1; k < 8; ++k) EXPECT_GE(recording.strikes_s[k] - recording.strikes_s[k - 1], 0.15 - 1e-12);
  }
}

TEST(Drops, BadRecipesAreNamed) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    try {
      make_dataset_from_text(text, "r.toml", 1);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      for (const std::string& word : words)
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in " << error.what();
    }
  };
  refused(recipe("{ onset_s = 0.1, radius_m = 0 }"), {"radius_m", "drop[1]"});
  refused(recipe("{ onset_s = 0.1, radius_m = 1.0 }"), {"radius_m"});
  refused(recipe("{ onset_s = 0.9, radius_m = 0.001 }"), {"onset_s", "0.5"});
  refused(recipe("{ onset_s = 0.1, radius_m = 0.001, colour = 1 }"), {"colour"});
  refused(recipe("{ onset_s = 0.1, radius_m = 0.00008 }"), {"sample rate"});
  refused("kind = \"drops\"\n", {"no recordings"});
  refused(
      "kind = \"drops\"\n[[recording]]\nname = \"a-1\"\ndrop = [{ onset_s = 0.1, radius_m = 0.001 }]\n"
      "[[random]]\nname = \"a\"\ndrops = 2\n",
      {"file name", "a-1"});
  refused("kind = \"drops\"\n[[random]]\nname = \"a\"\ndrops = 100\nshortest_gap_s = 0.1\n", {"drops", "fit"});
}

TEST(Drops, DocumentationHasTheSchema) {
  const std::string page = read_file(std::filesystem::path(klang::test::source_dir()) / "docs/recipes-drops.md");
  EXPECT_NE(page.find(drop_recipe_schema_markdown()), std::string::npos);
}

}  // namespace
}  // namespace klang::datasets
