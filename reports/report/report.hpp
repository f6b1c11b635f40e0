#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "reports/kit/report_folder.hpp"

namespace klang::reports {

struct ReportResult {
  std::filesystem::path page;
  std::vector<std::filesystem::path> files;  ///< everything written
  std::vector<std::string> warnings;         ///< "no display and no Xvfb: mode pictures left out"
};

/// Builds DIR/report.html, DIR/figures/*.png (and .svg), and CSV tables from a result (DIR/fit.json, DIR/study.json, ...) and
/// the files named there (recordings, resyntheses, mode shapes): docs/result-json.md.
/// Reads nothing else, so that `klang report DIR/fit.json` gives the same page again. The page is one file
/// that works offline.
ReportResult write_report(const std::filesystem::path& result_json, const ReportOptions& options = {},
                          Monitor& monitor = silent_monitor());

}  // namespace klang::reports
