#include "core/sound/instrument/instrument_files.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/sound_file.hpp"

namespace klang::instrument {
namespace {

constexpr double kRateHz = 48000.0;

class SfzFolder : public ::testing::Test {
 protected:
  SfzFolder() { std::filesystem::remove_all(folder_); }
  ~SfzFolder() override { std::filesystem::remove_all(folder_); }

  std::vector<std::string> write(const std::vector<ModalBank>& banks) {
    OutputDirectory out(folder_);
    std::vector<std::string> said = write_sfz(out, banks, "set", 440.0, kRateHz);
    out.commit();
    return said;
  }

  Eigen::VectorXd sample(const std::string& file) const { return audio::read_sound(folder_ / file).samples.col(0); }

  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) /
      ("klang-sfz-" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

double db(double ratio) { return 20.0 * std::log10(ratio); }

TEST_F(SfzFolder, SamplesEndAtTheLevelOfTheSlowestPartialReTheirOwnPeak) {
  // Phases that are spread: the envelopes add up to 12 dB more than the sound's peak. One gentle partial outlives all others.
  ModalBank bank{"bell", {}};
  for (int i = 0; i < 12; ++i) bank.partials.push_back({400.0 + 317.0 * i, 30.0 + i, 0.1, 2.4 * i});
  bank.partials.push_back({5000.0, 2.0, 0.002, 0.0});
  ModalBank quiet{"quiet", {{1000.0, 10.0, 1e-3, 0.0}}};
  EXPECT_TRUE(write({bank, quiet}).empty());
  for (const char* file : {"1-bell.wav", "2-quiet.wav"}) {
    const Eigen::VectorXd x = sample(file);
    const double end = x.tail(240).cwiseAbs().maxCoeff() / x.cwiseAbs().maxCoeff();
    EXPECT_LE(db(end), -58.5) << file;  // the last 5 ms
    EXPECT_GE(db(end), -62.0) << file;  // and not seconds of silence
  }
}

TEST_F(SfzFolder, WhatRingsTooLongEndsAtTheStatedLengthAndThatIsSaid) {
  const std::vector<std::string> said = write({{"tuning fork", {{440.0, 0.01, 0.5, 0.0}}}});
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said.front().find("tuning fork rings longer than 120 s"), std::string::npos) << said.front();
  EXPECT_EQ(sample("1-tuning_fork.wav").size(), static_cast<Eigen::Index>(120 * kRateHz) + 1);
}

TEST_F(SfzFolder, TheKeyIsThatOfTheLowestPartialThatIsNotWeak) {
  const ModalBank bank{"glass", {{100.0, 5.0, 1e-4, 0.0, true}, {880.0, 3.0, 0.5, 0.0}, {2000.0, 3.0, 0.9, 0.0}}};
  EXPECT_EQ(pitch_hz(bank), 880.0);
  write({bank});
  const std::string text = read_file(folder_ / "set.sfz");
  EXPECT_NE(text.find("pitch_keycenter=81\ntranspose=0\ntune=0\n"), std::string::npos) << text;
  const std::string scale = scala_text({bank}, "glass");
  EXPECT_NE(scale.find("over 880 Hz\n 1\n"), std::string::npos) << scale;
  EXPECT_NE(scale.find(" 1421.309485"), std::string::npos) << scale;    // 1200 log2(2000 / 880)
  EXPECT_NE(bank_csv({bank}).find("\nglass,100,"), std::string::npos);  // sound and table keep it
}

}  // namespace
}  // namespace klang::instrument
