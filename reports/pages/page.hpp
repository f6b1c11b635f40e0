#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields_json.hpp"
#include "core/foundation/config/result_header.hpp"
#include "reports/kit/report_folder.hpp"

/// A kind of result has one page: a file KIND_page.cpp with a function KIND_page() that says how its document becomes a Page,
/// and one line in CMakeLists.txt. What is common to all pages is in page_html.cpp.
namespace klang::reports::detail {

/// "Converged", "Not converged", ... and its kind for the eye.
struct Verdict {
  std::string words;
  std::string kind;  ///< "good", "fair", "bad"
  std::string details;
};

struct Section {
  std::string id, name, html;  ///< without html it is left out
};

struct Download {
  std::string file;  ///< beside the page
  std::string what;
};

inline const Download kFiguresDownload{"figures/", "– every figure as SVG and PNG"};

/// Lists a file, if it is there.
void add_if_there(const std::optional<std::string>& file, const char* what, const ReportFolder& folder,
                  std::vector<Download>& downloads);

/// Adds a table to the folder and lists it; under another name where that is an input of the result, which stays.
void add_table(const std::string& name, std::string text, const std::vector<InputFile>& inputs, ReportFolder& folder,
               std::vector<Download>& downloads);

/// What a page says. HTML made safe by its maker, but for title, verdict and downloads, which are plain text.
struct Page {
  ResultHeader header;
  std::string over;  ///< small, above the title: "Klangprobe · material from sound"
  std::string title;
  Verdict verdict;
  std::vector<std::string> sentences;  ///< that say what came out
  std::string key_figures;             ///< key_figures.hpp
  std::vector<Section> sections;
  std::string cost;  ///< a row of "How it was made"; may be empty
  std::vector<Download> downloads;
  std::string footer =
      "Numbers: standard deviations are one sigma; frequencies in hertz, decays of the amplitude in 1/s, 100 cents = "
      "one semitone.";
};

/// The status as words; good where it is ok, converged or not said.
Verdict status_verdict(const ResultHeader& header);

/// The whole page. The same input gives the same bytes.
std::string page_html(const Page& page, const std::vector<std::string>& warnings);

struct PageKind {
  std::string kind;  ///< of the result: "fit"
  /// Reads the document, adds figures, tables and sounds to the folder. @throws InputError with place and key
  std::function<Page(const nlohmann::json& result, const std::string& place, ReportFolder& folder)> make;
};

template <Described Document>
PageKind page_kind(std::string kind, Page (*make)(const Document&, ReportFolder&)) {
  return {std::move(kind), [make](const nlohmann::json& result, const std::string& place, ReportFolder& folder) {
            const auto document = read_fields<Document>(result, place);
            if constexpr (requires { document.check(place); }) document.check(place);
            Page page = make(document, folder);
            page.header = document.header;
            return page;
          }};
}

/// All kinds that have a page.
const std::vector<PageKind>& page_kinds();

}  // namespace klang::reports::detail
