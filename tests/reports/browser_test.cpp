#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "reports/report/report.hpp"
#include "reports/scenes/field_files.hpp"
#include "tests/reports/fixture.hpp"
#include "validate/studies/study_document.hpp"

/// The pages in a real browser. A copy of the page gets a script in front that catches every error and one
/// behind that waits for all pictures and sounds and writes what it saw into the document, which the browser
/// prints.
namespace klang::reports {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kWatch = R"(<script>window.__errors=[];
addEventListener("error",function(e){__errors.push(String(e.message||(e.target&&(e.target.tagName+" did not load"))||e));},true);
addEventListener("securitypolicyviolation",function(e){__errors.push("policy: "+e.violatedDirective+" "+e.blockedURI);});
addEventListener("unhandledrejection",function(e){__errors.push("promise: "+e.reason);});
["error","warn"].forEach(function(k){var o=console[k];console[k]=function(){__errors.push(k+": "+[].join.call(arguments," "));o.apply(console,arguments);};});
</script>)";

constexpr const char* kJudge = R"(<script>addEventListener("load",function(){
var images=[].slice.call(document.images),sounds=[].slice.call(document.querySelectorAll("audio")),tries=0;
var pictures=[].slice.call(document.querySelectorAll("svg image"));
function look(){
  var waiting=sounds.filter(function(s){return s.readyState<4&&!s.error;}).length+images.filter(function(i){return !i.complete;}).length;
  if(waiting&&tries++<400){setTimeout(look,50);return;}
  var sounds_bad=sounds.filter(function(s){return s.error||!(s.readyState>=2)||!isFinite(s.duration)||!(s.duration>0);}).length;
  var button=document.querySelector("[data-switch] button"),said=[];
  if(button){said.push(button.textContent);button.click();said.push(button.textContent);button.click();said.push(button.textContent);}
  var hooks={figures:[].map.call(document.querySelectorAll("[data-figure]"),function(f){return f.dataset.figure;}),
    layers:[].map.call(document.querySelectorAll("[data-layer]"),function(f){return f.dataset.layer;}),playing:[],sorted:[]};
  var spectrum=document.querySelector("[data-range-hz]"),zoom=document.querySelector("[data-action=zoom-in]");
  if(spectrum){hooks.range=[spectrum.dataset.rangeHz];}
  ["hear","hear-without"].forEach(function(action){
    var hear=document.querySelector("button[data-action="+action+"]");
    if(!hear)return;
    hear.click();hooks.playing.push(document.body.hasAttribute("data-playing"));
    document.querySelector("button.hush").click();hooks.playing.push(document.body.hasAttribute("data-playing"));
  });
  var loop=document.querySelector("button[data-action=loop]");
  if(loop){loop.click();hooks.loop=document.querySelector("audio").loop;loop.click();}
  var head=document.querySelector("th[aria-sort]");
  if(head){
    var column=[].indexOf.call(head.parentNode.children,head),cells=function(){
      return [].map.call(head.closest("table").tBodies[0].rows,function(r){return parseFloat(r.cells[column].textContent);});};
    head.click();hooks.sorted.push(head.getAttribute("aria-sort"));hooks.up=cells();
    hooks.ranks=[].map.call(head.closest("table").tBodies[0].rows,function(r){return r.getAttribute("data-rank");});
    head.click();hooks.sorted.push(head.getAttribute("aria-sort"));hooks.down=cells();
  }
  if(zoom)zoom.click();
  var verdict={hooks:hooks,errors:__errors,images:images.length,images_bad:images.filter(function(i){return !(i.naturalWidth>0&&i.alt);}).length,
    sounds:sounds.length,sounds_bad:sounds_bad,
    durations:sounds.map(function(s){return s.duration;}),pictures:pictures.length,
    pictures_bad:pictures.filter(function(p){return !(p.getBoundingClientRect().height>=0&&p.href.baseVal.indexOf("data:image/png")===0);}).length,
    nameless:[].filter.call(document.querySelectorAll("svg[role=img]"),function(s){return !s.getAttribute("aria-label");}).length,
    wide:document.documentElement.scrollWidth-innerWidth,said:said,headings:document.querySelectorAll("h1").length};
  setTimeout(function(){
  if(spectrum)hooks.range.push(spectrum.dataset.rangeHz);
  var out=document.createElement("pre");out.id="verdict";out.textContent="VERDICT"+JSON.stringify(verdict)+"TCIDREV";
  document.body.appendChild(out);
  },200);
}
look();});</script>)";

std::string output_of(const std::string& command, int& status) {
  std::string text;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return {};
  std::array<char, 65536> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) text.append(buffer.data(), n);
  status = ::pclose(pipe);
  return text;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.rfind(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

/// What the browser says about the page in this width.
json judged(const fs::path& page, const fs::path& folder, int width) {
  std::string text = read_file(page);
  const std::size_t head = text.find("<head>\n<meta charset=\"utf-8\">");
  EXPECT_NE(head, std::string::npos);
  text.insert(text.find('\n', head + 7), kWatch);
  text = replaced(std::move(text), "</body>", std::string(kJudge) + "</body>");
  write_file(folder / "watched.html", text);
  const std::string base =
      "timeout 250 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-dev-shm-usage "
      "--autoplay-policy=no-user-gesture-required --enable-logging=stderr --user-data-dir=" +
      (folder / "profile").string() + " --window-size=" + std::to_string(width) + ",900 ";
  int status = 0;
  const std::string log = (folder / "log.txt").string();
  const std::string dom = output_of(
      base + "--virtual-time-budget=30000 --dump-dom file://" + (folder / "watched.html").string() + " 2>" + log,
      status);
  EXPECT_EQ(status, 0);
  const std::string logged = read_file(log);
  EXPECT_EQ(logged.find("CONSOLE"), std::string::npos) << logged.substr(logged.find("CONSOLE"), 300);
  const std::size_t from = dom.rfind("VERDICT{"), to = dom.rfind("TCIDREV");
  EXPECT_NE(from, std::string::npos) << dom.substr(dom.size() > 500 ? dom.size() - 500 : 0);
  if (from == std::string::npos) return {};
  std::string verdict = dom.substr(from + 7, to - from - 7);
  for (std::size_t at; (at = verdict.find("&amp;")) != std::string::npos;) verdict.replace(at, 5, "&");
  return json::parse(verdict);
}

void screenshot(const fs::path& page, const std::string& name, int width, int height, const std::string& extra = {}) {
  fs::create_directories(KLANG_SCREENSHOTS);
  const fs::path profile = fs::temp_directory_path() / ("klang-shot-" + std::to_string(::getpid()));
  int status = 0;
  output_of(
      "timeout 250 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-dev-shm-usage "
      "--hide-scrollbars --user-data-dir=" +
          profile.string() + " --window-size=" + std::to_string(width) + "," + std::to_string(height) + " " + extra +
          " --screenshot=" + std::string(KLANG_SCREENSHOTS) + "/" + name + ".png file://" + page.string() +
          " 2>/dev/null",
      status);
  EXPECT_EQ(status, 0);
  EXPECT_GT(fs::file_size(fs::path(KLANG_SCREENSHOTS) / (name + ".png")), 20000u);
  fs::remove_all(profile);
}

class Browser : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("klang-browser-" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void expect_clean(const json& verdict, int n_sounds, int n_images) {
    ASSERT_TRUE(verdict.is_object());
    EXPECT_TRUE(verdict["errors"].empty()) << verdict["errors"].dump();
    EXPECT_EQ(verdict["sounds"], n_sounds);
    EXPECT_EQ(verdict["sounds_bad"], 0) << verdict["durations"].dump();
    EXPECT_EQ(verdict["images"], n_images);
    EXPECT_EQ(verdict["images_bad"], 0);
    EXPECT_EQ(verdict["pictures_bad"], 0);
    EXPECT_EQ(verdict["nameless"], 0);
    EXPECT_EQ(verdict["headings"], 1);
    EXPECT_LE(verdict["wide"].get<int>(), 0) << "the page itself must not scroll sideways";
  }

  /// What a page of a recording answers to: figures, zoom, single partials by ear, stop, loop, tables that sort.
  static void expect_hooks(const json& hooks) {
    EXPECT_EQ(hooks["figures"], json({"spectrogram", "spectrum"}));
    EXPECT_EQ(hooks["layers"], json({"measured", "model", "partials"}));
    EXPECT_EQ(hooks["playing"], json({true, false, true, false}));
    EXPECT_EQ(hooks["loop"], true);
    EXPECT_EQ(hooks["sorted"], json({"ascending", "descending"}));
    std::vector<double> up = hooks["up"], down = hooks["down"];
    EXPECT_TRUE(std::is_sorted(up.begin(), up.end())) << hooks["up"];
    EXPECT_TRUE(std::is_sorted(down.rbegin(), down.rend())) << hooks["down"];
    ASSERT_EQ(hooks["range"].size(), 2u);
    const auto width = [&](std::size_t i) {
      double low = 0, high = 0;
      EXPECT_EQ(std::sscanf(hooks["range"][i].get<std::string>().c_str(), "%lf %lf", &low, &high), 2);
      return high - low;
    };
    EXPECT_NEAR(width(1) / width(0), 0.5, 1e-3);
  }

  fs::path folder_;
};

TEST_F(Browser, SeesTheFitPageWithoutAnyErrorAndPlaysItsSounds) {
  fixture::write_fit(folder_, {.n_specimens = 6});
  const ReportResult report = write_report(folder_ / "fit.json", {.pictures = true, .max_mode_pictures = 6});
  const int n_shapes = report.warnings.empty() ? 6 : 0;
  const json verdict = judged(report.page, folder_, 1200);
  expect_clean(verdict, 12, n_shapes);
  EXPECT_EQ(verdict["pictures"], 6 * 4);
  ASSERT_EQ(verdict["said"].size(), 3u);
  EXPECT_EQ(verdict["said"][1], "Hearing recorded – switch");
  EXPECT_EQ(verdict["said"][2], "Hearing fitted model – switch");
  for (const json& duration : verdict["durations"]) EXPECT_NEAR(duration.get<double>(), 3.0, 0.01);
  expect_clean(judged(report.page, folder_, 500), 12, n_shapes);
  screenshot(report.page, "fit-light", 1200, 5200);
  screenshot(report.page, "fit-dark", 1200, 5200,
             "--force-dark-mode --enable-features=WebUIDarkMode --blink-settings=preferredColorScheme=0");
  screenshot(report.page, "fit-phone", 500, 2600);
}

TEST_F(Browser, TablesSortByTheValuesOfTheirNumbersNotByTheirDigits) {
  fixture::write_fit(folder_, {.n_specimens = 1, .shapes = false});
  const ReportResult report = write_report(folder_ / "fit.json", {.pictures = false});
  std::string text = read_file(report.page);
  // Each row says which one it is, the smallest first; missing ones go last. "0.0" twice: what is printed hides the order.
  const std::pair<const char*, const char*> cells[] = {
      {"4", "980"},  {"5", "1.2 × 10³"}, {"3", "1/100"},  {"0", "−4.5 × 10⁻²"},
      {"6", "12e3"}, {"7", "—"},         {"2", "1/1000"}, {"1", "0.0\" data-value=\"1e-9"}};
  std::string table = "<table><thead><tr><th scope=\"col\">Loss</th><th scope=\"col\">What</th></tr></thead><tbody>";
  for (const auto& [rank, cell] : cells) {
    const std::string shown = cell, value = shown.substr(std::min(shown.size(), shown.find('"')));
    table += "<tr data-rank=\"" + std::string(rank) + "\"><td class=\"n" + (value.empty() ? "\"" : value + "\"") + ">" +
             shown.substr(0, shown.find('"')) + "</td><td>x</td></tr>";
  }
  text.insert(text.find("<main"), table + "</tbody></table>");
  const fs::path page = folder_ / "sorting.html";
  write_file(page, text);
  EXPECT_EQ(judged(page, folder_, 1400)["hooks"]["ranks"], json({"0", "1", "2", "3", "4", "5", "6", "7"}));
}

TEST_F(Browser, EveryNumberOfATableOfPartialsCarriesItsValue) {
  fixture::write_fit(folder_, {.n_specimens = 1, .shapes = false});
  const ReportResult report = write_report(folder_ / "fit.json", {.pictures = false});
  const std::string text = read_file(report.page);
  const json fit = json::parse(read_file(folder_ / "fit.json"));
  ASSERT_FALSE(fit["matches"].empty());
  for (const json& match : fit["matches"])
    EXPECT_NE(text.find("data-value=\"" + to_text(match["frequency_hz"].get<double>()) + "\""), std::string::npos)
        << match;
}

TEST_F(Browser, PlaysRecordingsOf384Kilohertz) {
  fixture::write_fit(folder_, {.n_specimens = 1, .shapes = false, .sample_rate_hz = 384000});
  const json verdict = judged(write_report(folder_ / "fit.json").page, folder_, 1200);
  expect_clean(verdict, 2, 0);
  for (const json& duration : verdict["durations"]) EXPECT_NEAR(duration.get<double>(), 3.0, 0.01);
}

TEST_F(Browser, SeesAnalysisAndModesWithoutAnyError) {
  fixture::write_analysis(folder_ / "a");
  const ReportResult analysis = write_report(folder_ / "a" / "analysis.json");
  const json seen = judged(analysis.page, folder_, 1200);
  expect_clean(seen, 2, 0);
  expect_hooks(seen["hooks"]);
  expect_clean(judged(analysis.page, folder_, 500), 2, 0);
  screenshot(analysis.page, "analysis", 1200, 3000);
  fixture::write_modes(folder_ / "m");
  const ReportResult modes = write_report(folder_ / "m" / "modes.json", {.pictures = true, .max_mode_pictures = 9});
  expect_clean(judged(modes.page, folder_, 1200), 0, modes.warnings.empty() ? 9 : 0);
  screenshot(modes.page, "modes", 1200, 2600);
}

TEST_F(Browser, SeesTheStudyPageWithoutAnyErrorAndLoadsItsPictures) {
  const validate::Study study = validate::run_study("multipole", {.levels = 4, .only = {}, .fields = true});
  const fs::path folder = folder_ / "study";
  fs::create_directories(folder);
  write_fields(study.fields, folder);
  ResultHeader header;
  header.kind = "study";
  write_file(folder / "study.json", json_of(validate::study_document(header, study)).dump());
  const ReportResult report = write_report(folder / "study.json");
  const json verdict = judged(report.page, folder_, 1200);
  expect_clean(verdict, 0, 0);
  const int n_balloons = report.warnings.empty() ? 2 : 0;
  EXPECT_EQ(verdict["pictures"], 2 * (3 + n_balloons)) << "each slice and balloon with its colour bar";
  expect_clean(judged(report.page, folder_, 500), 0, 0);
  screenshot(report.page, "study-light", 1200, 3600);
  screenshot(report.page, "study-dark", 1200, 3600,
             "--force-dark-mode --enable-features=WebUIDarkMode --blink-settings=preferredColorScheme=0");
  screenshot(report.page, "study-phone", 500, 3000);
}

}  // namespace
}  // namespace klang::reports
