#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/audio/signal.hpp"
#include "reports/kit/svg_plot.hpp"

namespace klang::reports {

struct ReportOptions {
  bool pictures = true;  ///< VTK pictures of mode shapes and fields (needs a display or Xvfb)
  int max_mode_pictures = 12;
};

}  // namespace klang::reports

namespace klang::reports::detail {

/// The folder of a result while its page is made: the files beside the result are read from it, and what belongs to the page is
/// collected, to be written at once.
class ReportFolder {
 public:
  /// @param result_json  in the folder
  ReportFolder(const std::filesystem::path& result_json, const ReportOptions& options, Monitor& monitor);

  const ReportOptions& options() const { return options_; }
  Monitor& monitor() const { return monitor_; }
  const std::filesystem::path& path() const { return folder_; }

  /// A file that the result names, if it lies in the folder and is there; empty and, for a name, a warning otherwise.
  std::filesystem::path beside(const std::string& name);
  /// Its loudest channel; no frames where it cannot be had.
  audio::Signal sound_beside(const std::string& name);
  /// Whether a file of this name lies in the folder.
  bool has(const std::string& name) const;

  void warn(std::string warning) { warnings_.push_back(std::move(warning)); }
  const std::vector<std::string>& warnings() const { return warnings_; }

  void add_file(const std::string& name, std::string bytes);
  /// figures/STEM.svg and figures/STEM.png.
  void add_figure(const std::string& stem, const Svg& svg);

  /// Writes what was added, in that order: the page comes last, so that it never points at what is not there yet. After a
  /// failure files that are new go again. @return what was written. @throws InputError
  std::vector<std::filesystem::path> write();

 private:
  std::filesystem::path folder_;
  ReportOptions options_;
  Monitor& monitor_;
  std::vector<std::pair<std::filesystem::path, std::string>> output_;
  std::vector<std::string> warnings_;
};

/// The channel with the most energy, alone.
audio::Signal loudest_channel(const audio::Signal& signal);

}  // namespace klang::reports::detail
