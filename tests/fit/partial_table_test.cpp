#include "fit/ringdown/partial_table.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace fs = std::filesystem;
using klang::fit::parse_partial_csv;
using klang::fit::parse_partial_json;
using klang::fit::PartialTable;

namespace {

std::string csv_message(const std::string& text) {
  try {
    parse_partial_csv(text, "d3.csv");
  } catch (const klang::InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string json_message(const std::string& text) {
  try {
    parse_partial_json(text, "a.json");
  } catch (const klang::InputError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST(PartialCsv, BlankCellsAreNotMeasuredAndRowsComeBackInOrder) {
  const PartialTable table = parse_partial_csv(
      "# made by hand\r\nfrequency_hz, decay_per_s ,frequency_std_hz\r\n1490.5,,0.01\r\n\r\n587,1.5,\r\n", "d3.csv");
  ASSERT_EQ(table.partials.size(), 2u);
  EXPECT_EQ(table.partials[0].frequency_hz, 587.0);
  EXPECT_EQ(table.partials[0].decay_per_s, 1.5);
  EXPECT_FALSE(table.partials[0].frequency_std_hz.has_value());
  EXPECT_EQ(table.partials[1].frequency_hz, 1490.5);
  EXPECT_FALSE(table.partials[1].decay_per_s.has_value());
  EXPECT_EQ(table.partials[1].frequency_std_hz, 0.01);
  EXPECT_EQ(table.origin, "d3.csv");
}

TEST(PartialCsv, ErrorsNameFileLineColumnAndValue) {
  const std::string negative = csv_message("frequency_hz\n440\n-3\n");
  EXPECT_NE(negative.find("d3.csv, line 3: frequency_hz"), std::string::npos) << negative;
  EXPECT_NE(negative.find("-3"), std::string::npos) << negative;
  for (const char* bad : {"0", "nan", "inf", "1e400", "4 40", "", "440Hz"}) {
    const std::string message = csv_message("decay_per_s,frequency_hz\n1," + std::string(bad) + "\n");
    EXPECT_NE(message.find("line 2: frequency_hz"), std::string::npos) << bad << ": " << message;
  }
  EXPECT_NE(csv_message("frequency_hz,decay_per_s\n440,-1\n").find("decay_per_s"), std::string::npos);
  EXPECT_NE(csv_message("frequency_hz,decay_std_per_s\n440,0\n").find("decay_std_per_s"), std::string::npos);
  EXPECT_NE(csv_message("frequency_hz;amplitude\n440,5;1.234\n").find("'440,5'"), std::string::npos);  // which mark?
  EXPECT_NE(csv_message("frequency_hz,frequency_hz\n440,1\n").find("twice"), std::string::npos);
  EXPECT_NE(csv_message("decay_per_s\n1\n").find("no column frequency_hz"), std::string::npos);
  EXPECT_NE(csv_message("frequency_hz,decay_per_s\n440\n").find("number of cells"), std::string::npos);
  EXPECT_NE(csv_message("frequency_hz\n").find("no partials"), std::string::npos);
  EXPECT_NE(csv_message("").find("is empty"), std::string::npos);
}

TEST(PartialCsv, TablesOfOtherProgramsAreRead) {
  for (const char* text :
       {"frequency_hz,decay_per_s,Q\n1279.3,0.4,10000\n3522.8,0.55,20000\n",
        "\xef\xbb\xbf\"\",\"frequency_hz\",\"decay_per_s\",\"remark\"\r\n"
        "\"0\",\"1279.3\",\"0.4\",\"loud, 5\"\" away\"\r\n1,3522.8,0.55,\r\n",
        "# 24.12.2025\nfrequency_hz;decay_per_s\n1279,3;0,4\n3522,8;0,55\n",
        "frequency_hz\tdecay_per_s\tnote\n1279.3\t0.4\t\n3522.8\t0.55\t\n",
        "frequency_hz\tdecay_per_s\r\n1279,3\t0,4\r\n3522,8\t0,55\r\n",
        "frequency_hz,decay_per_s\r1279.3,0.4\r3522.8,0.55\r", "frequency_hz;decay_per_s\n1279.3;0.4\n3522.8;0.55\n"}) {
    const PartialTable table = parse_partial_csv(text, "t.csv");
    ASSERT_EQ(table.partials.size(), 2u) << text;
    EXPECT_EQ(table.partials[0].frequency_hz, 1279.3) << text;
    EXPECT_EQ(table.partials[0].decay_per_s, 0.4) << text;
    EXPECT_EQ(table.partials[1].frequency_hz, 3522.8) << text;
    EXPECT_EQ(table.partials[1].decay_per_s, 0.55) << text;
  }
  EXPECT_EQ(parse_partial_csv("Q,frequency_hz,pitch\n1,440,2\n", "t.csv").left_out_columns,
            (std::vector<std::string>{"Q", "pitch"}));
  EXPECT_NE(csv_message(std::string("frequency_hz,d\0ecay_per_s\n440,2\n", 33)).find("zero byte"), std::string::npos);
  EXPECT_NE(csv_message(std::string("\xff\xfe"
                                    "f\0",
                                    4))
                .find("16-bit"),
            std::string::npos);
}

TEST(PartialJson, ReadsWhatAnalyzeWritesAndLeavesOtherKeysAlone) {
  const PartialTable table = parse_partial_json(
      R"({"schema_version": 1, "partials": [{"frequency_hz": 900, "decay_per_s": null, "matched_mode": 3},
          {"frequency_hz": 300.5, "amplitude": 0.1, "phase_rad": -2}]})",
      "a.json");
  ASSERT_EQ(table.partials.size(), 2u);
  EXPECT_EQ(table.partials[0].frequency_hz, 300.5);
  EXPECT_EQ(table.partials[0].phase_rad, -2.0);
  EXPECT_FALSE(table.partials[1].decay_per_s.has_value());
}

TEST(PartialJson, ErrorsNameTheEntry) {
  EXPECT_NE(json_message("{").find("not JSON"), std::string::npos);
  EXPECT_NE(json_message("{}").find("partials"), std::string::npos);
  EXPECT_NE(json_message(R"({"partials": 3})").find("not a list"), std::string::npos);
  EXPECT_NE(json_message(R"([{"frequency_hz": 1}, 2])").find("partials[1]"), std::string::npos);
  EXPECT_NE(json_message(R"([{"frequency_hz": "440"}])").find("partials[0]: frequency_hz"), std::string::npos);
  EXPECT_NE(json_message(R"([{"frequency_hz": -440}])").find("-440"), std::string::npos);
  EXPECT_NE(json_message(R"([{"decay_per_s": 1}])").find("missing"), std::string::npos);
  EXPECT_NE(json_message("[]").find("no partials"), std::string::npos);
}

TEST(PartialTable, WhatIsWrittenReadsBackToTheSameBits) {
  const fs::path folder = fs::temp_directory_path() / ("klang-partials-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  PartialTable table;
  table.partials.resize(2);
  table.partials[0].frequency_hz = 100.0 / 3;
  table.partials[0].decay_std_per_s = 1e-7 / 3;
  table.partials[1].frequency_hz = 1e4 / 7;
  table.partials[1].phase_rad = -3.1;
  klang::fit::write_partial_table(folder / "a.csv", table);
  const PartialTable read = klang::fit::read_partial_table(folder / "a.csv");
  ASSERT_EQ(read.partials.size(), 2u);
  EXPECT_EQ(read.partials[0].frequency_hz, table.partials[0].frequency_hz);
  EXPECT_EQ(read.partials[0].decay_std_per_s, table.partials[0].decay_std_per_s);
  EXPECT_FALSE(read.partials[0].amplitude.has_value());
  EXPECT_EQ(read.partials[1].phase_rad, -3.1);
  EXPECT_THROW(klang::fit::read_partial_table(folder / "a.txt"), klang::InputError);
  EXPECT_THROW(klang::fit::read_partial_table(folder / "none.csv"), klang::InputError);
  fs::remove_all(folder);
}
