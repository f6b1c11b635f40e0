// The pages of klang regress check and klang validate papers, from manufactured results.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"
#include "validate/papers/papers.hpp"
#include "validate/regression/regression_document.hpp"

namespace klang::reports {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path fresh_folder(const char* name) {
  const fs::path folder = fs::path(::testing::TempDir()) / (std::string("klang-check-") + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

fit::Partial partial(double frequency_hz) {
  fit::Partial p;
  p.frequency_hz = frequency_hz;
  p.frequency_std_hz = 0.01;
  p.decay_per_s = 5.0;
  p.decay_std_per_s = 0.1;
  p.amplitude = 0.1;
  return p;
}

json regression(double shift_cents) {
  validate::RegressionResult result;
  result.status = validate::RegressionStatus::kJudged;
  result.partials.push_back({partial(500), partial(500.2), shift_cents, 0.5, 0.01, 0.02, ""});
  result.partials.push_back({partial(900), {}, {}, {}, {}, {}, "the sound's noise would <hide> it"});
  result.claims.push_back(validate::judged(
      {"partial-1.frequency", "Partial at 500 Hz keeps its frequency [cents]", shift_cents, 0.0, 0.5, {}, false}));
  result.claims.push_back(validate::judged({"partial-2.there",
                                            "Partials missing at 900 Hz",
                                            1.0,
                                            0.0,
                                            0.5,
                                            {},
                                            false,
                                            "the sound's noise would <hide> it"}));
  result.thirds.push_back({501.2, -20.0, -20.5, -0.5, 1.0});
  result.times_s = {0.02, 0.03, 0.04};
  result.bands_hz = {480.0, 508.0};
  result.reference_db = Eigen::MatrixXf::Constant(2, 3, -30.0f);
  result.sound_db = Eigen::MatrixXf::Constant(2, 3, -33.0f);
  result.log_spectral_distance_db = 3.0;
  ResultHeader header;
  header.kind = "regression";
  return json_of(validate::regression_document(header, result, {}));
}

fs::path written(const json& result, const fs::path& folder) {
  write_file(folder / "result.json", result.dump());
  return folder / "result.json";
}

TEST(RegressionPage, SaysWhatFailedAndWhatWasNotJudged) {
  const fs::path folder = fresh_folder("regression");
  const std::string good = read_file(write_report(written(regression(0.1), folder)).page);
  EXPECT_NE(good.find("pill good\">Passed"), std::string::npos);
  EXPECT_NE(good.find("tag fair\">not judged"), std::string::npos);
  EXPECT_NE(good.find("noise would &lt;hide&gt; it"), std::string::npos);
  const std::string bad = read_file(write_report(written(regression(2.5), folder)).page);
  EXPECT_NE(bad.find("pill bad\">Not passed"), std::string::npos);
  EXPECT_NE(bad.find("tag bad\">failed"), std::string::npos);
  EXPECT_NE(bad.find("<b>+2.50 (± 0.5)</b>"), std::string::npos);
  EXPECT_EQ(bad, read_file(write_report(folder / "result.json").page));
  for (const char* file : {"levels.svg", "spectrum.png", "partials.png"})
    EXPECT_TRUE(fs::exists(folder / "figures" / file)) << file;
}

TEST(RegressionPage, LevelsOfTheWrongLengthAreRefused) {
  json result = regression(0.1);
  result["spectrogram"]["sound_db"][1].push_back(0.0);
  EXPECT_THROW(write_report(written(result, fresh_folder("lengths"))), InputError);
  result = regression(0.1);
  result["spectrogram"]["sound_db"].erase(1);
  EXPECT_THROW(write_report(written(result, fresh_folder("bands"))), InputError);
}

TEST(PapersPage, ShowsNumbersWithTheirVerdictsAndWhatIsLeftOut) {
  validate::PaperTables tables;
  validate::PaperNumber number;
  number.id = "x";
  number.paper = "S02";
  number.place = "Table 9";
  number.quantity = "a <number>";
  number.printed = 2.0;
  number.ours = 3.0;
  number.tolerance = 0.1;
  number.verdict = validate::verdict_of(number);
  tables.numbers.push_back(number);
  tables.gaps.push_back({"SB", "Table 3", "statistics"});
  validate::PaperScene scene;
  scene.scene = "slab.toml";
  scene.printed = 72.0;
  scene.reason = "unfinished";
  tables.scenes.push_back(scene);
  ResultHeader header;
  header.kind = "papers";
  header.status = "not_passed";
  const json file = json_of(validate::papers_document(header, tables));
  const std::string page = read_file(write_report(written(file, fresh_folder("papers"))).page);
  EXPECT_NE(page.find("pill bad\">Not passed"), std::string::npos);
  EXPECT_NE(page.find("tag bad\">differs"), std::string::npos);
  EXPECT_NE(page.find("a &lt;number&gt;"), std::string::npos);
  EXPECT_NE(page.find("+50 %"), std::string::npos);
  EXPECT_NE(page.find("statistics"), std::string::npos);
  EXPECT_NE(page.find("slab.toml"), std::string::npos);
  EXPECT_NE(page.find("not run (unfinished)"), std::string::npos);
  EXPECT_NE(page.find("<b>1</b> are computed by the program"), std::string::npos);
}

}  // namespace
}  // namespace klang::reports
