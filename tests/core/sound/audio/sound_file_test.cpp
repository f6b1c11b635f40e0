#include "core/sound/audio/sound_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/random.hpp"

namespace fs = std::filesystem;
using klang::InputError;
using klang::audio::SampleFormat;
using klang::audio::Signal;

namespace {

class SoundFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("klang-sound-" + std::to_string(::getpid()) +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

Signal noise(Eigen::Index n_frames, Eigen::Index n_channels, double rate) {
  Signal signal;
  signal.sample_rate_hz = rate;
  signal.samples.resize(n_frames, n_channels);
  klang::RandomStream random(7, 0);
  for (Eigen::Index c = 0; c < n_channels; ++c) {
    for (Eigen::Index i = 0; i < n_frames; ++i) signal.samples(i, c) = random.uniform(-0.9, 0.9);
  }
  return signal;
}

/// A float WAV with the given samples, byte by byte, so that samples no writer would accept can be read.
std::string float_wav(const std::vector<float>& samples, std::uint32_t rate, std::uint16_t n_channels) {
  const auto u16 = [](std::uint16_t v) { return std::string(reinterpret_cast<const char*>(&v), 2); };
  const auto u32 = [](std::uint32_t v) { return std::string(reinterpret_cast<const char*>(&v), 4); };
  const std::string data(reinterpret_cast<const char*>(samples.data()), 4 * samples.size());
  const std::string format = u16(3) + u16(n_channels) + u32(rate) + u32(rate * 4u * n_channels) +
                             u16(static_cast<std::uint16_t>(4 * n_channels)) + u16(32);
  const std::string body = "WAVEfmt " + u32(16) + format + "data" + u32(static_cast<std::uint32_t>(data.size())) + data;
  return "RIFF" + u32(static_cast<std::uint32_t>(body.size())) + body;
}

std::string message_of(const std::string& bytes) {
  try {
    klang::audio::read_sound_bytes(bytes, "tap.wav");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_F(SoundFile, RoundTripErrorIsHalfAStepOfItsFormat) {
  struct Case {
    const char* name;
    SampleFormat format;
    double tolerance;
  };
  for (const Case& c : {Case{"a.wav", SampleFormat::kPcm16, 0x1p-16}, Case{"b.wav", SampleFormat::kPcm24, 0x1p-24},
                        Case{"c.wav", SampleFormat::kFloat32, 0x1p-25}, Case{"d.flac", SampleFormat::kPcm16, 0x1p-16},
                        Case{"e.flac", SampleFormat::kPcm24, 0x1p-24}}) {
    const Signal written = noise(1000, 2, 44100);
    klang::audio::write_sound(folder_ / c.name, written, c.format);
    const Signal read = klang::audio::read_sound(folder_ / c.name);
    ASSERT_EQ(read.n_frames(), 1000) << c.name;
    ASSERT_EQ(read.n_channels(), 2) << c.name;
    EXPECT_EQ(read.sample_rate_hz, 44100) << c.name;
    EXPECT_LE((read.samples - written.samples).cwiseAbs().maxCoeff(), 1.01 * c.tolerance) << c.name;
  }
}

TEST_F(SoundFile, RatesFrom8To768KilohertzAnd64ChannelsSurvive) {
  for (const double rate : {8000.0, 48000.0, 384000.0, 768000.0}) {
    klang::audio::write_sound(folder_ / "rate.wav", noise(64, 1, rate));
    EXPECT_EQ(klang::audio::read_sound(folder_ / "rate.wav").sample_rate_hz, rate);
  }
  const Signal many = noise(50, 64, 48000);
  klang::audio::write_sound(folder_ / "many.wav", many, SampleFormat::kFloat32);
  const Signal read = klang::audio::read_sound(folder_ / "many.wav");
  ASSERT_EQ(read.n_channels(), 64);
  EXPECT_LE((read.samples - many.samples).cwiseAbs().maxCoeff(), 1e-7);
}

TEST_F(SoundFile, SameSignalGivesSameBytes) {
  const Signal signal = noise(500, 1, 48000);
  klang::audio::write_sound(folder_ / "a.wav", signal, SampleFormat::kFloat32);
  klang::audio::write_sound(folder_ / "b.wav", signal, SampleFormat::kFloat32);
  EXPECT_EQ(klang::read_file(folder_ / "a.wav"), klang::read_file(folder_ / "b.wav"));
}

TEST_F(SoundFile, PcmClipsAtFullScaleInsteadOfWrapping) {
  Signal loud = noise(16, 1, 8000);
  loud.samples.setConstant(1.5);
  klang::audio::write_sound(folder_ / "loud.wav", loud, SampleFormat::kPcm16);
  const Signal read = klang::audio::read_sound(folder_ / "loud.wav");
  EXPECT_GE(read.samples.minCoeff(), 0.999);
}

TEST_F(SoundFile, EveryCutOfAWavIsRefused) {
  klang::audio::write_sound(folder_ / "whole.wav", noise(300, 1, 48000));
  const std::string bytes = klang::read_file(folder_ / "whole.wav");
  EXPECT_EQ(message_of(bytes), "accepted");
  for (std::size_t n = 0; n < bytes.size(); n += 7) {
    EXPECT_NE(message_of(bytes.substr(0, n)), "accepted") << n << " of " << bytes.size() << " bytes";
  }
}

TEST_F(SoundFile, ACutFlacIsRefused) {
  klang::audio::write_sound(folder_ / "whole.flac", noise(30000, 1, 48000));
  const std::string bytes = klang::read_file(folder_ / "whole.flac");
  EXPECT_EQ(message_of(bytes), "accepted");
  for (const double part : {0.05, 0.3, 0.6, 0.95}) {
    EXPECT_NE(message_of(bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size())))),
              "accepted")
        << part;
  }
}

TEST_F(SoundFile, NotANumberIsNamedWithFrameAndChannel) {
  std::vector<float> samples(40, 0.25f);
  samples[2 * 13 + 1] = std::numeric_limits<float>::quiet_NaN();
  const std::string message = message_of(float_wav(samples, 48000, 2));
  EXPECT_NE(message.find("frame 13, channel 1"), std::string::npos) << message;
  samples[2 * 13 + 1] = std::numeric_limits<float>::infinity();
  EXPECT_NE(message_of(float_wav(samples, 48000, 2)).find("frame 13, channel 1"), std::string::npos);
}

TEST_F(SoundFile, ASampleBeyondAllSoundIsNamedWithFrameAndChannel) {
  std::vector<float> samples(200, 0.1f);
  samples[31] = 1e30f;  // frame 15, channel 1; a 64-bit table read as sound has 1e200
  const std::string message = message_of(float_wav(samples, 44100, 2));
  EXPECT_NE(message.find("frame 15, channel 1"), std::string::npos) << message;
  EXPECT_NE(message.find("e+30;"), std::string::npos) << message;
}

TEST_F(SoundFile, AWavWhoseWriterLeftItsSizesAtZeroIsReadToTheEnd) {
  std::vector<float> samples(500);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = 0.001f * static_cast<float>(i);
  const std::string whole = float_wav(samples, 48000, 1);
  const std::string none(4, '\0'), unknown(4, '\xff'), header_only{'$', 0, 0, 0};  // 36 bytes follow
  for (const std::string& riff : {none, unknown, header_only}) {
    std::string streamed = whole;
    streamed.replace(4, 4, riff);
    streamed.replace(40, 4, none);
    const Signal read = klang::audio::read_sound_bytes(streamed, "streamed.wav");
    ASSERT_EQ(read.n_frames(), 500);
    EXPECT_EQ(read.samples(499, 0), static_cast<double>(samples[499]));
  }
  // Where the file's own size covers what follows an empty chunk of samples, that is another chunk.
  std::string empty = whole;
  empty.replace(40, 4, none);
  EXPECT_NE(message_of(empty).find("no samples"), std::string::npos);
}

TEST_F(SoundFile, EmptyForeignZeroRateAndZeroFramesAreRefused) {
  EXPECT_NE(message_of("").find("is empty"), std::string::npos);
  EXPECT_NE(message_of("not a sound, only some text that goes on").find("not a sound file"), std::string::npos);
  EXPECT_NE(message_of(float_wav({0.1f, 0.2f}, 0, 1)), "accepted");
  EXPECT_NE(message_of(float_wav({}, 48000, 1)), "accepted");
  EXPECT_THROW(klang::audio::read_sound(folder_ / "missing.wav"), InputError);
  EXPECT_THROW(klang::audio::read_sound(folder_), InputError);
}

TEST_F(SoundFile, WhatCannotBeWrittenLeavesNothingBehind) {
  Signal bad = noise(16, 1, 48000);
  bad.samples(3, 0) = std::nan("");
  EXPECT_THROW(klang::audio::write_sound(folder_ / "nan.wav", bad), InputError);
  EXPECT_THROW(klang::audio::write_sound(folder_ / "a.mp3", noise(16, 1, 48000)), InputError);
  EXPECT_THROW(klang::audio::write_sound(folder_ / "none/a.wav", noise(16, 1, 48000)), InputError);
  EXPECT_THROW(klang::audio::write_sound(folder_ / "wide.flac", noise(16, 9, 48000)), InputError);
  EXPECT_TRUE(fs::is_empty(folder_));
}
