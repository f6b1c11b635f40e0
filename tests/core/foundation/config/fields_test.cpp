// A struct that names its fields once: what JSON, CSV, checks and docs make of it.
#include "core/foundation/config/fields.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/foundation/config/named_numbers.hpp"

namespace klang {
namespace {

using nlohmann::json;

enum class Colour { kRed, kBlue };
constexpr auto words_of(Colour) { return std::array{Word{Colour::kRed, "red"}, Word{Colour::kBlue, "blue"}}; }

struct Line {
  double frequency_hz = 1.0;
  std::optional<double> decay_per_s;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"frequency_hz", "of the line", above(0.0)}), self.frequency_hz);
    visit({"decay_per_s", "of the amplitude", at_least(0.0)}, self.decay_per_s);
  }
};

struct Thing {
  std::string name;
  int count = 3;
  double level_db = -20.0;
  bool passed = false;
  Colour colour = Colour::kRed;
  std::optional<std::array<double, 2>> ci95;
  std::vector<Line> lines;
  std::optional<Line> loudest;
  std::vector<std::vector<double>> rows;
  std::map<std::string, double> seconds;
  std::string note, remark;
  JsonText options;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "what it is called"}, self.name);
    visit({"count", "how many", between(0, 10)}, self.count);
    visit({"level_db", "level"}, self.level_db);
    visit({"passed", "whether it passed"}, self.passed);
    visit({"colour", "its colour"}, self.colour);
    visit({"ci95", "95 % interval"}, self.ci95);
    visit({"lines", "all lines"}, self.lines);
    visit({"loudest", "of the lines"}, self.loudest);
    visit({"rows", "levels"}, self.rows);
    visit(absent_if_empty({"seconds", "by stage"}), self.seconds);
    visit(null_if_empty({"note", "a remark"}), self.note);
    visit(absent_if_empty({"remark", "another"}), self.remark);
    visit({"options", "that were used"}, self.options);
  }
};

std::string complaint(const json& file) {
  try {
    read_fields<Thing>(file, "thing.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FieldsJson, WhatIsWrittenReadsBackTheSame) {
  Thing thing;
  thing.name = "bell";
  thing.count = 7;
  thing.level_db = 0.1;
  thing.passed = true;
  thing.colour = Colour::kBlue;
  thing.ci95 = {1.0, 2.5};
  thing.lines = {{440.0, 1.5}, {880.0, {}}};
  thing.loudest = Line{440.0, {}};
  thing.rows = {{1.0, 2.0}, {}};
  thing.seconds = {{"solve", 0.5}};
  thing.note = "cracked";
  thing.options.text = R"({"a":[1,{"b":null}]})";
  const json file = json_of(thing);
  EXPECT_EQ(file["lines"][1]["decay_per_s"], json());
  EXPECT_EQ(file["options"]["a"][1]["b"], json());
  EXPECT_FALSE(file.contains("remark"));
  EXPECT_EQ(json_of(read_fields<Thing>(file, "thing.json")), file);
}

TEST(FieldsJson, WhatWasNotMeasuredIsNullAndComesBackAsNotMeasured) {
  Thing thing;
  thing.level_db = std::nan("");
  const json file = json_of(thing);
  EXPECT_TRUE(file["level_db"].is_null());
  EXPECT_TRUE(file["ci95"].is_null());
  EXPECT_TRUE(file["note"].is_null());
  EXPECT_FALSE(file.contains("seconds"));
  EXPECT_EQ(file["lines"], json::array());
  const Thing back = read_fields<Thing>(file, "thing.json");
  EXPECT_TRUE(std::isnan(back.level_db));
  EXPECT_FALSE(back.ci95);
}

TEST(FieldsJson, MissingKeysKeepTheirDefaultsUnlessTheyAreNeeded) {
  const Thing thing = read_fields<Thing>(json::object(), "thing.json");
  EXPECT_EQ(thing.count, 3);
  EXPECT_EQ(thing.level_db, -20.0);
  EXPECT_EQ(complaint({{"lines", {json::object()}}}), "thing.json.lines[0].frequency_hz: missing");
}

TEST(FieldsJson, EveryWrongValueIsNamedWithItsPlace) {
  EXPECT_EQ(complaint({{"lines", 7}}), "thing.json.lines: not a list (7)");
  EXPECT_EQ(complaint({{"lines", {{{"frequency_hz", "x"}}}}}),
            "thing.json.lines[0].frequency_hz: not a number (\"x\")");
  EXPECT_EQ(complaint({{"count", 2.5}}), "thing.json.count: not a whole number (2.5)");
  EXPECT_NE(complaint({{"count", 11}}).find("0 to 10"), std::string::npos);
  EXPECT_NE(complaint({{"colour", "green"}}).find("one of red, blue"), std::string::npos);
  EXPECT_NE(complaint({{"ci95", {1.0}}}).find("needs 2 numbers"), std::string::npos);
  EXPECT_NE(complaint({{"rows", {{1.0, "x"}}}}).find("rows[0][1]"), std::string::npos);
  EXPECT_NE(complaint({{"passed", 1}}).find("not true or false"), std::string::npos);
  EXPECT_NE(complaint({{"name", 1}}).find("not a text"), std::string::npos);
  EXPECT_EQ(complaint({{"count", 2.0}, {"new_key", 1}}), "accepted");
}

TEST(FieldsCsv, HeadAndCellsComeFromTheDescription) {
  Thing thing;
  thing.name = "bell, \"small\"";
  thing.ci95 = {1.0, 2.5};
  thing.level_db = std::nan("");
  EXPECT_EQ(csv_table(std::vector<Thing>{thing, {}}, {"note", "remark"}),
            "name,count,level_db,passed,colour,ci95_low,ci95_high\n"
            "\"bell, \"\"small\"\"\",3,,false,red,1,2.5\n"
            ",3,-20,false,red,,\n");
  EXPECT_EQ(csv_table(std::vector<Line>{}), "frequency_hz,decay_per_s\n");
}

TEST(NamedNumbers, AreTheNumbersOfAStructWithoutThoseInside) {
  EXPECT_EQ(numbers_of(Line{440.0, 2.0}), (std::map<std::string, double>{{"frequency_hz", 440.0}}));
  EXPECT_EQ(numbers_of(Thing{}).size(), 1u);
}

TEST(FieldRows, InnerFieldsStandUnderTheirPath) {
  const std::string table = field_rows_markdown(field_rows<Thing>(), false);
  for (const char* line :
       {"| `count` | integer | 0 to 10 | how many |", "| `lines` | list of table |  | all lines |",
        "| `lines[].frequency_hz` | number | above 0 | of the line |",
        "| `loudest.decay_per_s` | number or null | at least 0 | of the amplitude |",
        "| `colour` | one of red, blue |  | its colour |", "| `options` | any |  | that were used |"})
    EXPECT_NE(table.find(line), std::string::npos) << line << "\n" << table;
}

TEST(FieldCheck, ListsEveryViolationAtOnce) {
  Thing thing;
  thing.count = -1;
  thing.lines = {{-2.0, -3.0}};
  try {
    validate_fields("thing", thing);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    const std::string text = error.what();
    for (const char* part : {"count is out of range (-1; allowed: 0 to 10)", "frequency_hz is out of range (-2",
                             "decay_per_s is out of range (-3"})
      EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  thing = {};
  EXPECT_NO_THROW(validate_fields("thing", thing));
}

}  // namespace
}  // namespace klang
