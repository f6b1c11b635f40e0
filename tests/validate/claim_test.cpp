#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/config/fields_json.hpp"
#include "validate/claim/claim.hpp"
#include "validate/studies/study_document.hpp"

namespace klang::validate {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

/// Every tag opens and closes in order, attributes are quoted and no bare & or < is left: enough for a JUnit reader.
void expect_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  std::size_t at = xml.find("?>") + 2;
  ASSERT_EQ(xml.compare(0, 5, "<?xml"), 0);
  while (at < xml.size()) {
    const std::size_t tag = xml.find('<', at);
    const std::string text = xml.substr(at, tag == std::string::npos ? std::string::npos : tag - at);
    for (std::size_t amp = 0; (amp = text.find('&', amp)) != std::string::npos; ++amp)
      EXPECT_LE(text.find(';', amp), amp + 5) << text;
    if (tag == std::string::npos) break;
    bool quoted = false;
    std::size_t end = tag + 1;
    for (; end < xml.size() && (quoted || xml[end] != '>'); ++end) {
      if (xml[end] == '"') quoted = !quoted;
      EXPECT_FALSE(quoted && xml[end] == '<');
      EXPECT_GE(static_cast<unsigned char>(xml[end]), 0x20);
    }
    const std::string inside = xml.substr(tag + 1, end - tag - 1);
    if (inside[0] == '/') {
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(open.back(), inside.substr(1));
      open.pop_back();
    } else if (inside.back() != '/') {
      open.push_back(inside.substr(0, inside.find(' ')));
    }
    at = end + 1;
  }
  EXPECT_TRUE(open.empty());
}

TEST(Claim, ANaNOrAnExcessDoesNotPass) {
  EXPECT_TRUE(judged({"a", "", 1.01, 1.0, 0.011, {}, false}).passed);
  EXPECT_FALSE(judged({"a", "", 1.02, 1.0, 0.011, {}, true}).passed);
  EXPECT_FALSE(judged({"a", "", std::nan(""), 1.0, 1e300, {}, true}).passed);
  EXPECT_TRUE(judged({"a", "", -1e-9, {}, 1e-8, {}, false}).passed)
      << "without a reference the claim is about an error";
}

TEST(JUnit, IsWellFormedAndCountsFailures) {
  const std::vector<Claim> claims = {judged({"one", "errors < 1 & \"small\"", 0.5, {}, 1.0, {}, false}),
                                     judged({"two<>", "line\nbreak\x01", 2.0, 1.0, 0.5, 1.7, false}),
                                     judged({"three", "it's", std::nan(""), {}, 1.0, {}, false})};
  const std::string xml = junit_xml("study \"fem\" & more", claims);
  expect_well_formed(xml);
  EXPECT_EQ(count(xml, "<testcase "), 3U);
  EXPECT_EQ(count(xml, "<failure "), 2U);
  EXPECT_EQ(count(xml, "tests=\"3\" failures=\"2\" errors=\"0\""), 2U);
  EXPECT_EQ(xml, junit_xml("study \"fem\" & more", claims));
}

TEST(StudyJson, HasTheMainSeriesOnTopAndNullForWhatWasNotMeasured) {
  Study study;
  study.status = StudyStatus::kDone;
  study.name = "fem";
  Series series;
  series.id = "a,b";
  series.expected_order = 2.0;
  series.error_tolerance = 1.0;
  for (const double h : {0.1, 0.05, 0.025}) {
    Level level;
    level.h_m = h;
    level.error = h * h;
    series.levels.push_back(level);
  }
  judge(series);
  study.series.push_back(series);
  EXPECT_TRUE(study.passed());
  const nlohmann::json json = json_of(study_document({}, study));
  EXPECT_EQ(json["levels"], json["series"][0]["levels"]);
  EXPECT_EQ(json["levels"][2]["h_m"], 0.025);
  EXPECT_LE(std::abs(json["observed_order"].get<double>() - 2.0), 1e-12);
  EXPECT_EQ(json["expected_order"], 2.0);
  EXPECT_EQ(json["passed"], true);
  EXPECT_TRUE(json["series"][0]["gci"].is_null());
  EXPECT_TRUE(json["levels"][0]["pairwise_order"].is_null());
  const std::string csv = levels_csv(study);
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "series,level,h_m,n,error,value,exact,shape_error,pairwise_order,excluded,n_unknowns,error_low,error_high");
  EXPECT_NE(csv.find("\"a,b\",2,0.025,,"), std::string::npos) << csv;
  study.claims.push_back(judged({"c", "", 2.0, 1.0, 0.5, {}, false}));
  EXPECT_FALSE(study.passed()) << "the worst verdict counts";
  EXPECT_FALSE(Study{}.passed()) << "what never ran has not passed";
}

}  // namespace
}  // namespace klang::validate
