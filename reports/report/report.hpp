#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"

namespace klang::reports {

struct ReportOptions {
  bool pictures = true;  ///< VTK pictures of mode shapes (needs a display or Xvfb)
  int max_mode_pictures = 12;
};

struct ReportResult {
  std::filesystem::path page;
  std::vector<std::filesystem::path> files;  ///< everything written
  std::vector<std::string> warnings;         ///< "no display and no Xvfb: mode pictures left out"
};

/// Builds DIR/report.html, DIR/figures/*.png (and .svg), and CSV tables from DIR/fit.json or
/// DIR/analysis.json and the files named there (recordings, resyntheses, mode shapes): docs/result-json.md.
/// Reads nothing else, so that `klang report DIR/fit.json` gives the same page again. The page is one file
/// that works offline.
ReportResult write_report(const std::filesystem::path& result_json, const ReportOptions& options = {},
                          Monitor& monitor = silent_monitor());

}  // namespace klang::reports
