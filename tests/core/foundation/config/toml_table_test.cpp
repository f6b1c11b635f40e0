#include "core/foundation/config/toml_table.hpp"
#include "core/foundation/config/toml_depth.hpp"

#include <gtest/gtest.h>

#include "core/foundation/base/errors.hpp"

namespace klang {
namespace {

const std::vector<TomlField>& schema() {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  static const std::vector<TomlField> fields = {
      {"", "ratio", TomlType::kNumber, "none", -1, 0.5, "open at both ends", true},
      {"", "length_m", TomlType::kNumber, "none", 0, 2, "closed"},
      {"", "at_m", TomlType::kNumbers, "required", -10, 10, "x, y, z of a place", true, 3},
      {"", "any", TomlType::kNumbers, "none", 0, kInf, "as many as you like", true},
      {"", "title", TomlType::kText, "none", -kInf, kInf, "a title"},
      {"", "prior", TomlType::kTable, "none", -kInf, kInf, "tables by name"},
      {"prior.*", "mean", TomlType::kNumber, "required", -kInf, kInf, "expected value"},
      {"prior.*", "std", TomlType::kNumber, "required", 0, kInf, "standard deviation", true},
      {"", "body", TomlType::kTables, "required", -kInf, kInf, "1 to 2 bodies"},
      {"body", "name", TomlType::kText, "required", -kInf, kInf, "its name"},
  };
  return fields;
}

TomlTable parse(const std::string& text) { return TomlTable::parse(text, "t.toml", schema()); }

template <class Read>
std::string complaint(const std::string& text, Read&& read) {
  try {
    read(parse(text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(TomlDepth, CountsThePartsOfKeysAlone) {
  std::string parts = "a";
  for (int i = 0; i < 100000; ++i) parts += ".a";
  const auto deep = [](const std::string& text) { return toml_keys_too_deep(text); };
  EXPECT_TRUE(deep(parts + " = 1"));
  EXPECT_TRUE(deep("[" + parts + "]"));
  EXPECT_TRUE(deep("x = {" + parts + " = 1}"));
  EXPECT_TRUE(deep("\"q\".'r'." + parts));
  EXPECT_FALSE(deep("a.b.c.d = [1.5, 2.5, 3.5] # " + parts));
  EXPECT_FALSE(deep("a = \"" + parts + "\"\nb = '" + parts + "'"));
  EXPECT_FALSE(deep("a = \"\"\"\n" + parts + "\n\\\" \"\"\"\nb = '''" + parts + "'''"));
}

TEST(TomlTable, OpenRangesLeaveTheirEndsOutAndClosedOnesDoNot) {
  const auto ratio = [](const TomlTable& t) { t.number("ratio"); };
  const auto length = [](const TomlTable& t) { t.number("length_m"); };
  EXPECT_EQ(complaint("ratio = 0.5", ratio), "t.toml:1: ratio: is out of range (0.5; allowed: above -1, below 0.5)");
  EXPECT_EQ(complaint("ratio = nan", ratio), "t.toml:1: ratio: is out of range (nan; allowed: above -1, below 0.5)");
  EXPECT_EQ(complaint("ratio = 0.49", ratio), "accepted");
  EXPECT_EQ(complaint("length_m = 2", length), "accepted");
  EXPECT_EQ(complaint("length_m = 2.1", length), "t.toml:1: length_m: value is out of range (2.1; allowed: 0 to 2)");
}

TEST(TomlTable, ListsOfNumbersHaveTheirLength) {
  const auto at = [](const TomlTable& t) { t.numbers("at_m"); };
  EXPECT_EQ(parse("at_m = [1, 2.5, -3]").numbers("at_m"), (std::vector<double>{1.0, 2.5, -3.0}));
  EXPECT_EQ(parse("any = [1, 2]").numbers("any").size(), 2u);
  EXPECT_EQ(complaint("at_m = [1, 2]", at), "t.toml:1: at_m: has a wrong number of entries (2; allowed: 3)");
  EXPECT_EQ(complaint("at_m = [1, 2, 10]", at), "t.toml:1: at_m: is out of range (10; allowed: above -10, below 10)");
  EXPECT_EQ(complaint("at_m = 3", at), "t.toml:1: at_m: must be a list (3)");
  EXPECT_EQ(complaint("", at).find("at_m: is missing (allowed: x, y, z of a place)") != std::string::npos, true)
      << complaint("", at);
}

TEST(TomlTable, TablesByNameMayHaveNamesWithAPointInQuotesOrWithout) {
  const auto read = [](const std::string& text) { return parse(text).named_tables("prior"); };
  for (const char* text : {"[prior]\n\"D3.length_m\" = { mean = 0.5, std = 0.1 }\nE = { mean = 7e10, std = 1e9 }\n",
                           "[prior]\nD3.length_m = { mean = 0.5, std = 0.1 }\nE = { mean = 7e10, std = 1e9 }\n"}) {
    const auto priors = read(text);
    ASSERT_EQ(priors.size(), 2u) << text;
    const auto& dimension = priors[0].first == "E" ? priors[1] : priors[0];
    EXPECT_EQ(dimension.first, "D3.length_m");
    EXPECT_EQ(dimension.second.number("std"), 0.1);
    EXPECT_EQ(dimension.second.place("std"), "t.toml:2: prior.D3.length_m.std");
  }
  EXPECT_TRUE(read("").empty());
  const auto named = [](const TomlTable& t) { t.named_tables("prior"); };
  EXPECT_NE(complaint("[prior]\nE = { mean = 1, sdt = 2 }\n", named).find("prior.E.sdt: unknown key"),
            std::string::npos);
  EXPECT_NE(complaint("[prior]\nE = 3\n", named).find("t.toml:2: prior.E: must be a table (3"), std::string::npos);
  EXPECT_NE(complaint("prior = 3\n", named).find("prior: must be a table"), std::string::npos);
}

TEST(TomlTable, ListsOfTablesKeepTheirCount) {
  const auto bodies = [](const TomlTable& t) { t.tables("body", 1, 2); };
  const std::string body = "[[body]]\nname = \"a\"\n";
  EXPECT_EQ(complaint(body, bodies), "accepted");
  EXPECT_NE(complaint(body + body + body, bodies).find("body: must be a list of 1 to 2 tables"), std::string::npos);
  EXPECT_NE(complaint("body = 3", bodies).find("must be a list of 1 to 2 tables"), std::string::npos);
  EXPECT_NE(complaint("body = [3]", bodies).find("must be a table"), std::string::npos);
  EXPECT_NE(complaint("", bodies).find("body: is missing"), std::string::npos);
  EXPECT_EQ(parse(body + body).tables("body", 1, 2)[1].place(), "t.toml:3: body[2]");
}

TEST(TomlTable, TextsAndKeysAreToldFromOtherTypes) {
  EXPECT_TRUE(parse("title = \"x\"").is_text("title"));
  EXPECT_FALSE(parse("title = 3").is_text("title"));
  EXPECT_EQ(parse("").optional_text("title"), std::nullopt);
  EXPECT_EQ(parse("title = \"x\"\nratio = 0").keys(), (std::vector<std::string>{"ratio", "title"}));
  const auto title = [](const TomlTable& t) { t.text("title"); };
  EXPECT_EQ(complaint("title = true", title), "t.toml:1: title: must be a text (true)");
  EXPECT_NE(complaint("title = \"a\\u0000b\"", title).find("is no usable text"), std::string::npos);
  EXPECT_NE(complaint("tilte = 1", [](const TomlTable&) {}).find("tilte: unknown key"), std::string::npos);
}

}  // namespace
}  // namespace klang
