// The page of a convergence study, from a manufactured one.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"
#include "reports/scenes/field_files.hpp"
#include "validate/studies/study_document.hpp"

namespace klang::reports {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path fresh_folder(const char* name) {
  const fs::path folder = fs::path(::testing::TempDir()) / (std::string("klang-study-") + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

validate::SliceField slice() {
  validate::SliceField field;
  field.name = "plane";
  field.title = "A plane";
  field.quantity = "pressure_magnitude_pa";
  field.corner_m = {-1.0, 0.5, -2.0};
  field.side_u_m = {2.0, 0.0, 0.0};
  field.side_v_m = {0.0, 0.0, 4.0};
  field.values = Eigen::MatrixXd::Constant(5, 4, 0.25);
  field.values(1, 2) = 2.0;
  field.values(3, 0) = std::nan("");
  return field;
}

validate::Study study(double order) {
  validate::Study result;
  result.name = "fem";
  result.title = "A study <of> its own";
  result.question = "Does it?";
  result.status = validate::StudyStatus::kDone;
  validate::Series series;
  series.id = "one";
  series.title = "Series & one";
  series.step_words = "element size [m]";
  series.error_words = "error";
  series.expected_order = 2.0;
  series.error_tolerance = 1.0;
  for (const double h : {0.2, 0.1, 0.05, 0.025}) {
    validate::Level level;
    level.h_m = h;
    level.error = std::pow(h, order) * (h > 0.15 ? 1.002 : 1.0);
    level.n_unknowns = std::round(1.0 / (h * h * h));
    series.levels.push_back(level);
  }
  validate::judge(series);
  result.series.push_back(series);
  result.fields.slices.push_back(slice());
  return result;
}

fs::path written(const validate::Study& what, const fs::path& folder) {
  write_fields(what.fields, folder);
  ResultHeader header;
  header.kind = "study";
  write_file(folder / "study.json", json_of(validate::study_document(header, what)).dump());
  return folder / "study.json";
}

TEST(StudyPage, SaysPassedOrWhichClaimIsNot) {
  const fs::path folder = fresh_folder("verdict");
  const std::string good = read_file(write_report(written(study(2.1), folder), {.pictures = false}).page);
  EXPECT_NE(good.find("pill good\">Passed"), std::string::npos);
  EXPECT_NE(good.find("<b>2.10</b>"), std::string::npos);
  EXPECT_NE(good.find("All 2 claims hold"), std::string::npos);
  EXPECT_NE(good.find("A study &lt;of&gt; its own"), std::string::npos);
  const std::string bad = read_file(write_report(written(study(1.2), folder), {.pictures = false}).page);
  EXPECT_NE(bad.find("pill bad\">Not passed"), std::string::npos);
  EXPECT_NE(bad.find("Series &amp; one: errors fall at the expected order"), std::string::npos);
}

TEST(StudyPage, IsTheSameBytesEveryTimeAndNamesEveryFile) {
  const fs::path folder = fresh_folder("bytes");
  const fs::path result = written(study(2.0), folder);
  const std::string first = read_file(write_report(result, {.pictures = false}).page);
  EXPECT_EQ(first, read_file(write_report(result, {.pictures = false}).page));
  for (const char* part : {"plane.vti", "study.json", "data:image/png;base64,"})
    EXPECT_NE(first.find(part), std::string::npos) << part;
  for (const char* file : {"convergence.svg", "convergence.png", "cost.svg", "plane.png"})
    EXPECT_TRUE(fs::exists(folder / "figures" / file)) << file;
}

TEST(StudyPage, AMissingOrDamagedFieldCostsItsPictureOnly) {
  const fs::path folder = fresh_folder("damaged");
  const fs::path result = written(study(2.0), folder);
  write_file(folder / "plane.vti", "<VTKFile type=\"ImageData\"><broken");
  ReportResult report = write_report(result, {.pictures = false});
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_NE(report.warnings[0].find("plane.vti"), std::string::npos);
  fs::remove(folder / "plane.vti");
  EXPECT_EQ(write_report(result, {.pictures = false}).warnings.size(), 1U);
}

TEST(StudyPage, AStudyWithoutAnyLevelStillHasAPage) {
  const fs::path folder = fresh_folder("empty");
  write_file(
      folder / "study.json",
      R"({"schema_version":1,"kind":"study","title":"Nothing","passed":false,"series":[{"id":"x","levels":[]}]})");
  const std::string page = read_file(write_report(folder / "study.json").page);
  EXPECT_NE(page.find("Not passed"), std::string::npos);
  write_file(folder / "study.json", R"({"schema_version":1,"kind":"study","series":[{"levels":[{"error":"no"}]}]})");
  EXPECT_THROW(write_report(folder / "study.json"), InputError);
}

TEST(FieldFiles, ASliceReadsBackWithItsPlaceAndItsHoles) {
  const fs::path folder = fresh_folder("slice");
  validate::Fields fields;
  fields.slices.push_back(slice());
  write_fields(fields, folder);
  const auto back = read_slice(folder / "plane.vti");
  ASSERT_TRUE(back);
  const validate::SliceField wanted = slice();
  EXPECT_EQ(back->quantity, wanted.quantity);
  EXPECT_LE((back->corner_m - wanted.corner_m).norm(), 1e-14);
  EXPECT_LE((back->side_u_m - wanted.side_u_m).norm(), 1e-14);
  EXPECT_LE((back->side_v_m - wanted.side_v_m).norm(), 1e-14);
  ASSERT_EQ(back->values.rows(), 5);
  ASSERT_EQ(back->values.cols(), 4);
  for (Eigen::Index i = 0; i < wanted.values.size(); ++i) {
    if (std::isnan(wanted.values(i))) {
      EXPECT_TRUE(std::isnan(back->values(i)));
    } else {
      EXPECT_EQ(back->values(i), wanted.values(i));
    }
  }
  EXPECT_FALSE(read_slice(folder / "none.vti"));
}

}  // namespace
}  // namespace klang::reports
