#include "reports/report/report.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/result_header.hpp"
#include "reports/kit/report_folder.hpp"
#include "reports/pages/page.hpp"

namespace klang::reports {
namespace {

using namespace detail;

/// @throws InputError for a kind that has no page
const PageKind& kind_of(const ResultHeader& header, const std::string& place) {
  std::string known;
  for (const PageKind& kind : page_kinds()) {
    if (kind.kind == header.kind) return kind;
    known += (known.empty() ? "" : ", ") + kind.kind;
  }
  throw InputError(place + ".kind", "has no report", header.kind, known);
}

}  // namespace

ReportResult write_report(const std::filesystem::path& result_json, const ReportOptions& options, Monitor& monitor) {
  const std::string place = result_json.string();
  const nlohmann::json result = read_result_json(result_json);
  const PageKind& kind = kind_of(read_fields<ResultHeader>(result, place), place);
  ReportFolder folder(result_json, options, monitor);
  monitor.progress("report", 0.0);
  Page page = kind.make(result, place, folder);
  monitor.progress("report", 0.95);
  page.downloads.insert(page.downloads.begin(), {result_json.filename().string(), "– the result this page is made of"});
  folder.add_file("report.html", page_html(page, folder.warnings()));
  ReportResult report;
  report.files = folder.write();
  report.page = folder.path() / "report.html";
  report.warnings = folder.warnings();
  monitor.progress("report", 1.0);
  return report;
}

}  // namespace klang::reports
