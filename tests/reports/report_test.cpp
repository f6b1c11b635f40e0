#include "reports/report/report.hpp"

#include <gtest/gtest.h>
#include <png.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <regex>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "reports/scenes/display.hpp"
#include "tests/reports/fixture.hpp"

namespace klang::reports {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("klang-report-" + std::to_string(::getpid())) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

class Cleanup : public ::testing::Environment {
 public:
  void TearDown() override {
    fs::remove_all(fs::temp_directory_path() / ("klang-report-" + std::to_string(::getpid())));
  }
};
const auto* const kCleanup = ::testing::AddGlobalTestEnvironment(new Cleanup);

/// The page without the bytes of pictures and sounds.
std::string words_of(const fs::path& page) {
  const std::string text = read_file(page);
  std::string kept;
  std::size_t from = 0;
  while (true) {
    const std::size_t data = text.find(";base64,", from);
    kept += text.substr(from, data == std::string::npos ? std::string::npos : data - from);
    if (data == std::string::npos) return kept;
    from = text.find_first_of("\"'", data);
  }
}

void expect_sound_words(const std::string& words) {
  EXPECT_EQ(words.find("http://"), std::string::npos);
  EXPECT_EQ(words.find("https://"), std::string::npos);
  static const std::regex broken("\\b(nan|inf|infinity|undefined|null)\\b", std::regex::icase);
  std::smatch found;
  EXPECT_FALSE(std::regex_search(words, found, broken))
      << found.str() << " in ..." << found.prefix().str().substr(std::max<long>(0, found.prefix().length() - 120));
}

struct Picture {
  int width = 0, height = 0;
  std::size_t n_colours = 0;
};

Picture decoded(const fs::path& file) {
  const std::string bytes = read_file(file);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size())) return {};
  image.format = PNG_FORMAT_RGBA;
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(image.width) * image.height);
  if (!png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr)) return {};
  const std::set<std::uint32_t> colours(pixels.begin(), pixels.end());
  return {static_cast<int>(image.width), static_cast<int>(image.height), colours.size()};
}

/// Sets or removes environment variables and puts them back.
class Environment {
 public:
  Environment(std::initializer_list<std::pair<const char*, const char*>> values) {
    for (const auto& [name, value] : values) {
      const char* before = std::getenv(name);
      before_.emplace_back(name, before ? std::optional<std::string>(before) : std::nullopt);
      value ? ::setenv(name, value, 1) : ::unsetenv(name);
    }
  }
  ~Environment() {
    for (const auto& [name, value] : before_)
      value ? ::setenv(name.c_str(), value->c_str(), 1) : ::unsetenv(name.c_str());
  }

 private:
  std::vector<std::pair<std::string, std::optional<std::string>>> before_;
};

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST(Report, FitPageIsWholeAndItsFiguresAreNotBlank) {
  const fs::path folder = fresh_folder("fit");
  const json result = fixture::write_fit(folder, {.n_specimens = 2});
  const ReportResult report = write_report(folder / "fit.json", {.pictures = true, .max_mode_pictures = 4});
  ASSERT_EQ(report.page, folder / "report.html");
  const std::string words = words_of(report.page);
  expect_sound_words(words);
  for (const char* part :
       {"68.404 ± 0.052", "68.302 to 68.506", "not determined", "The two tubes, taken as aluminium, ring with", "AICc",
        "stiffness only", "Recorded", "Fitted model", "Difference of magnitudes", "partial without a mode",
        "no partial matches", "klang fit six-chimes.toml -o out"}) {
    EXPECT_NE(words.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(count_of(words, "<audio "), 4u);
#if KLANG_WITH_VTK
  EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
  EXPECT_EQ(count_of(words, "alt=\"Shape of mode"), 4u);
#else
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(words.find("built without VTK: mode pictures left out"), std::string::npos);
#endif
  std::set<std::string> stems;
  for (const fs::path& file : report.files) {
    EXPECT_TRUE(fs::is_regular_file(file)) << file;
    if (file.extension() != ".png") continue;
    const Picture picture = decoded(file);
    stems.insert(file.stem().string());
    EXPECT_GE(picture.n_colours, 60u) << file;
    EXPECT_GE(picture.width, 100) << file;
    EXPECT_GE(picture.height, 30) << file;
  }
  for (const char* stem : {"ladder", "residuals", "decays", "spectrogram-D3", "spectrogram-E3"})
    EXPECT_TRUE(stems.count(stem)) << stem;
  EXPECT_EQ(stems.size(), KLANG_WITH_VTK ? 9u : 5u);
  EXPECT_LT(fs::file_size(report.page), 15'000'000u);
  // Nothing else is left in the folder: no temporary file.
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
}

TEST(Report, TablesHoldTheExactNumbers) {
  const fs::path folder = fresh_folder("tables");
  const json result = fixture::write_fit(folder, {.n_specimens = 2, .sounds = false, .shapes = false});
  write_report(folder / "fit.json");
  const std::string matches = read_file(folder / "matches.csv");
  EXPECT_EQ(count_of(matches, "\n"), 1 + result["matches"].size());
  const json& first = result["matches"][0];
  EXPECT_NE(matches.find("D3,0," + to_text(first["frequency_hz"].get<double>()) + ","), std::string::npos);
  const std::string partials = read_file(folder / "partials.csv");
  EXPECT_NE(partials.find("E3,2210.4,0.09,14,0.6,0.02,0.001,0.3,0.05,decaying,,,,,\n"), std::string::npos)
      << "no matched mode: an empty cell\n"
      << partials;
  const std::string parameters = read_file(folder / "parameters.csv");
  EXPECT_NE(parameters.find("lame_lambda_pa,4.98e+10,,,,false,4.98e+10,false,"), std::string::npos) << parameters;
  EXPECT_EQ(count_of(read_file(folder / "predicted.csv"), "\n"), 1 + result["predicted"].size());
  EXPECT_EQ(count_of(read_file(folder / "damping.csv"), "\n"), 1 + 7u);
}

TEST(Report, AnalysisAndModesHavePagesToo) {
  const fs::path folder = fresh_folder("kinds");
  fixture::write_analysis(folder / "a");
  const ReportResult analysis = write_report(folder / "a" / "analysis.json");
  std::string words = words_of(analysis.page);
  expect_sound_words(words);
  for (const char* part : {"14 partials", "99.31 %", "mains hum at 50 Hz ignored", "Resynthesis", "44.1"})
    EXPECT_NE(words.find(part), std::string::npos) << part;
  EXPECT_GE(decoded(folder / "a" / "figures" / "spectrogram.png").n_colours, 200u);
  EXPECT_GE(decoded(folder / "a" / "figures" / "partials.png").n_colours, 30u);

  fixture::write_modes(folder / "m");
  const ReportResult modes = write_report(folder / "m" / "modes.json", {.pictures = true, .max_mode_pictures = 2});
  words = words_of(modes.page);
  expect_sound_words(words);
  EXPECT_NE(words.find("a Sturm count proves that none between them is missing"), std::string::npos);
#if KLANG_WITH_VTK
  EXPECT_TRUE(fs::exists(folder / "m" / "figures" / "mode-0000.png"));
#endif
}

TEST(Report, NamesCannotSmuggleMarkup) {
  const fs::path folder = fresh_folder("escape");
  json result =
      fixture::write_fit(folder, {.n_specimens = 1, .shapes = false, .first_name = "<script>alert(1)</script>\"'&"});
  result["name"] = "</title><img src=x onerror=alert(2)>";
  result["parameters"][0]["why"] = "<b onclick='alert(3)'>";
  result["warnings"] = {"</aside><script>alert(4)</script>"};
  result["damping"]["candidates"][1]["model"] = "<i>zener</i>";
  write_file(folder / "fit.json", json_text(result));
  const ReportResult report = write_report(folder / "fit.json");
  const std::string words = words_of(report.page);
  for (const char* part : {"<script>alert", "<img src=x", "<b onclick", "<i>zener", "</title><img"})
    EXPECT_EQ(words.find(part), std::string::npos) << part;
  EXPECT_EQ(count_of(words, "<script>"), 1u) << "the page's own";
  EXPECT_TRUE(fs::exists(folder / "figures" / "spectrogram-_script_alert_1___script____.png"));
}

TEST(Report, SameInputGivesTheSameBytes) {
  const fs::path folder = fresh_folder("same");
  fixture::write_fit(folder, {.n_specimens = 2, .shapes = false});
  write_report(folder / "fit.json");
  const std::string page = read_file(folder / "report.html"), figure = read_file(folder / "figures" / "decays.svg");
  write_report(folder / "fit.json");
  EXPECT_TRUE(page == read_file(folder / "report.html"));
  EXPECT_TRUE(figure == read_file(folder / "figures" / "decays.svg"));
}

TEST(Report, HostileNumbersLeaveAReadablePage) {
  const fs::path folder = fresh_folder("hostile");
  json result = fixture::write_fit(folder, {.n_specimens = 2, .sounds = false, .shapes = false});
  result["matches"][0]["deviation_cents"] = 1e300;
  result["matches"][1]["frequency_std_hz"] = 0.0;
  result["matches"][2]["frequency_hz"] = 0.0;
  result["matches"][3]["frequency_hz"] = -5.0;
  result["specimens"][0]["partials"][0]["decay_per_s"] = -3.0;
  result["specimens"][0]["partials"][1]["amplitude"] = 0.0;
  result["specimens"][0]["partials"][2]["frequency_hz"] = 1e308;
  result["specimens"][1]["partials"] = json::array();
  result["predicted"][0]["frequency_hz"] = 0.0;
  result["parameters"][2]["std"] = 1e-300;
  result["parameters"][3]["value"] = nullptr;
  result["damping"]["candidates"][0]["curve"]["decay_per_s"][3] = 0.0;
  write_file(folder / "fit.json", json_text(result));
  expect_sound_words(words_of(write_report(folder / "fit.json").page));
}

TEST(Report, FitsThatFailedSaySo) {
  const fs::path folder = fresh_folder("failed");
  const json base = {{"schema_version", 1}, {"kind", "fit"}, {"name", "x"}};
  for (const auto& [status, words] :
       std::vector<std::pair<std::string, std::string>>{{"no_partials", "nothing was fitted"},
                                                        {"no_match", "No partial lies near a mode"},
                                                        {"not_converged", "not a result"}}) {
    json result = base;
    result["status"] = status;
    write_file(folder / "fit.json", json_text(result));
    const std::string page = words_of(write_report(folder / "fit.json").page);
    EXPECT_NE(page.find(words), std::string::npos) << status;
    EXPECT_EQ(page.find("pill good"), std::string::npos) << status;
    expect_sound_words(page);
  }
}

TEST(Report, BadResultFilesAreNamed) {
  const fs::path folder = fresh_folder("bad");
  const auto message = [&](const std::string& text) -> std::string {
    write_file(folder / "r.json", text);
    try {
      write_report(folder / "r.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message("").find("not JSON"), std::string::npos);
  EXPECT_NE(message("[1]").find("not a result file"), std::string::npos);
  EXPECT_NE(message("{}").find("schema_version"), std::string::npos);
  EXPECT_NE(message(R"({"schema_version":2,"kind":"fit"})").find("schema_version"), std::string::npos);
  EXPECT_NE(message(R"({"schema_version":1,"kind":"tune"})").find("kind"), std::string::npos);
  EXPECT_NE(
      message(R"({"schema_version":1,"kind":"fit","matches":[{"frequency_hz":"x"}]})").find("matches[0].frequency_hz"),
      std::string::npos);
  EXPECT_NE(message(R"({"schema_version":1,"kind":"fit","matches":7})").find("matches"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "report.html"));
  EXPECT_THROW(write_report(folder / "missing.json"), InputError);
}

TEST(Report, FilesOutsideTheFolderAndMissingOnesAreLeftOut) {
  const fs::path folder = fresh_folder("outside");
  json result = fixture::write_fit(folder / "in", {.n_specimens = 1, .shapes = false});
  fs::rename(folder / "in" / "recording-specimen0.wav", folder / "secret.wav");
  result["specimens"][0]["files"] = {
      {"recording", "../secret.wav"}, {"resynthesis", "gone.wav"}, {"modes", "/etc/hostname"}};
  write_file(folder / "in" / "fit.json", json_text(result));
  const ReportResult report = write_report(folder / "in" / "fit.json");
  EXPECT_EQ(report.warnings.size(), 3u);
  const std::string words = words_of(report.page);
  EXPECT_EQ(words.find("<audio "), std::string::npos);
  EXPECT_NE(words.find("gone.wav: no such file"), std::string::npos);
}

TEST(Report, InputTablesOfTheSameNameAreNotOverwritten) {
  const fs::path folder = fresh_folder("input");
  json result = fixture::write_fit(folder, {.n_specimens = 1, .sounds = false, .shapes = false});
  write_file(folder / "partials.csv", "frequency_hz\n440\n");
  result["provenance"]["inputs"].push_back({{"path", "partials.csv"}, {"n_bytes", 17}, {"sha256", ""}});
  write_file(folder / "fit.json", json_text(result));
  write_report(folder / "fit.json");
  EXPECT_EQ(read_file(folder / "partials.csv"), "frequency_hz\n440\n");
  EXPECT_TRUE(fs::exists(folder / "report-partials.csv"));
}

TEST(Report, AFolderThatCannotBeWrittenIsAnInputError) {
  const fs::path folder = fresh_folder("unwritable");
  fixture::write_fit(folder, {.n_specimens = 1, .sounds = false, .shapes = false});
  write_file(folder / "figures", "a file where a folder is needed");
  EXPECT_THROW(write_report(folder / "fit.json"), InputError);
  EXPECT_FALSE(fs::exists(folder / "report.html"));
  EXPECT_FALSE(fs::exists(folder / "matches.csv"));
}

#if KLANG_WITH_VTK
TEST(Report, WithoutDisplayAndXvfbOnlyThePicturesAreMissing) {
  const fs::path folder = fresh_folder("nodisplay");
  fixture::write_fit(folder, {.n_specimens = 1});
  const fs::path empty = folder / "empty";
  fs::create_directories(empty);
  const Environment environment({{"PATH", empty.c_str()}, {"DISPLAY", nullptr}});
  const ReportResult report = write_report(folder / "fit.json");
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_EQ(report.warnings[0], "no display and no Xvfb: mode pictures left out");
  EXPECT_NE(words_of(report.page).find(report.warnings[0]), std::string::npos);
  EXPECT_TRUE(fs::exists(folder / "figures" / "spectrogram-D3.png"));
}

TEST(Report, ADeadDisplayDoesNotTakeTheProgramWithIt) {
  const fs::path folder = fresh_folder("deaddisplay");
  fixture::write_fit(folder, {.n_specimens = 1, .sounds = false});
  const fs::path empty = folder / "empty";
  fs::create_directories(empty);
  const Environment environment({{"PATH", empty.c_str()}, {"DISPLAY", ":4242"}});
  const ReportResult report = write_report(folder / "fit.json");
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_EQ(report.warnings[0], "display :4242 cannot draw: mode pictures left out");
}

TEST(Report, DamagedModeFilesCostTheirPicturesOnly) {
  const fs::path folder = fresh_folder("damaged");
  fixture::write_fit(folder, {.n_specimens = 2, .sounds = false});
  write_file(folder / "modes-specimen0.vtu", "<VTKFile type=\"UnstructuredGrid\"><broken");
  const ReportResult report = write_report(folder / "fit.json", {.pictures = true, .max_mode_pictures = 4});
  ASSERT_EQ(report.warnings.size(), 1u);
  // Four pictures of two tubes: three of the first one, one of the second.
  EXPECT_EQ(report.warnings[0], "mode shapes missing or not readable: 3 mode pictures left out");
  EXPECT_TRUE(fs::exists(folder / "figures" / "mode-E3-0000.png"));
}
#endif

TEST(VirtualDisplay, StartsAndLeavesNoProcessBehind) {
  pid_t server = -1;
  {
    const VirtualDisplay display;
    ASSERT_TRUE(display.problem().empty()) << display.problem();
    EXPECT_EQ(display.name()[0], ':');
    server = display.process();
    EXPECT_EQ(::kill(server, 0), 0);
  }
  EXPECT_EQ(::kill(server, 0), -1);
  EXPECT_EQ(errno, ESRCH);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "no child left to reap";
}

TEST(VirtualDisplay, SaysWhyItCannotStart) {
  const Environment nowhere({{"PATH", "/nonexistent"}});
  EXPECT_EQ(VirtualDisplay().problem(), "no Xvfb");
  const fs::path folder = fresh_folder("fake");
  write_file(folder / "Xvfb", "#!/bin/sh\nexec /bin/sleep 60\n");
  fs::permissions(folder / "Xvfb", fs::perms::owner_all);
  const Environment fake({{"PATH", folder.c_str()}});
  const VirtualDisplay hung(0.2);
  EXPECT_EQ(hung.problem(), "Xvfb does not start");
  EXPECT_EQ(hung.process(), -1);
}

}  // namespace
}  // namespace klang::reports
