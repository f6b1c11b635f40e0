#include "core/sound/audio/note.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "tests/process_file.hpp"

namespace klang::audio {
namespace {

TEST(Notes, NearestNoteAndCentsGoByTheGivenA4) {
  EXPECT_EQ(nearest_note(440.0).name, "A4");
  EXPECT_NEAR(nearest_note(440.0).cents, 0.0, 1e-9);
  EXPECT_EQ(nearest_note(261.6255653).name, "C4");
  EXPECT_NEAR(nearest_note(440.0, 443.0).cents, 1200.0 * std::log2(440.0 / 443.0), 1e-9);
  EXPECT_EQ(nearest_note(587.33).name, "D5");
  EXPECT_EQ(nearest_note(8.1758).name, "C-1");
  EXPECT_EQ(nearest_note(4.0).name, "C-2");
  EXPECT_EQ(nearest_note(31.0).name, "B0");
  EXPECT_NEAR(nearest_note(440.0 * std::exp2(0.49 / 12.0)).cents, 49.0, 1e-9);
}

TEST(Notes, NamesAreReadWithSharpsFlatsAndOctaves) {
  EXPECT_EQ(key_of_note("A4"), 69);
  EXPECT_EQ(key_of_note("C4"), 60);
  EXPECT_EQ(key_of_note("Bb3"), 58);
  EXPECT_EQ(key_of_note("Cb5"), 71);
  EXPECT_EQ(key_of_note("f#4"), 66);
  EXPECT_EQ(note_of_key(66), "F#4");
  for (int key = 0; key <= 127; ++key) EXPECT_EQ(key_of_note(note_of_key(key)), key);
  for (const char* wrong : {"", "H4", "A", "A4x", "A#", "A12", "C-2", "4A", "A####4"})
    EXPECT_THROW(key_of_note(wrong), InputError) << wrong;
}

TEST(Temperaments, JustCountsFromCAndKeepsA4) {
  const Temperament just = Temperament::just(), equal = Temperament::equal();
  for (const double a4_hz : {440.0, 443.0}) {
    EXPECT_NEAR(just.frequency_hz(69, a4_hz), a4_hz, 1e-9);
    EXPECT_NEAR(equal.frequency_hz(69, a4_hz), a4_hz, 1e-9);
    EXPECT_NEAR(just.frequency_hz(60, a4_hz), a4_hz * 3.0 / 5.0, 1e-9);
    EXPECT_NEAR(just.frequency_hz(74, a4_hz), a4_hz * 3.0 / 5.0 * 2.0 * 9.0 / 8.0, 1e-9);  // D5
    EXPECT_NEAR(equal.frequency_hz(74, a4_hz), a4_hz * std::exp2(5.0 / 12.0), 1e-9);
  }
}

TEST(Temperaments, ScalaFilesOfTwelveDegreesAreReadAndOthersNamed) {
  const auto file = klang::test::process_file("note.scl");
  const std::string pythagorean =
      "! p.scl\n!\nPythagorean\n 12\n!\n 2187/2048\n 9/8 tone\n 32/27\n 81/64\n 4/3\n 729/512\n 3/2\n 6561/4096\n"
      " 27/16\n 16/9\n 243/128\n 1200.0\n";
  write_file(file, pythagorean);
  const Temperament scale = Temperament::read_scala(file);
  EXPECT_NEAR(scale.frequency_hz(69, 440.0), 440.0, 1e-9);
  EXPECT_NEAR(scale.frequency_hz(60, 440.0), 440.0 * 16.0 / 27.0, 1e-9);
  EXPECT_NEAR(scale.frequency_hz(48, 440.0), 220.0 * 16.0 / 27.0, 1e-9);
  for (const char* wrong : {"x\n5\n100.0\n", "x\n12\n3/2\n", "x\n12\n3/2\n9/8\n", "x\n12\nabc\n", ""}) {
    write_file(file, wrong);
    EXPECT_THROW(Temperament::read_scala(file), InputError) << wrong;
  }
  std::filesystem::remove(file);
  EXPECT_THROW(Temperament::parse("equall"), InputError);
  EXPECT_THROW(Temperament::parse("none.scl"), InputError);
}

}  // namespace
}  // namespace klang::audio
