#include "reports/kit/report_folder.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "reports/kit/raster.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kPngScale = 1.5;

bool lies_inside(const std::filesystem::path& path) {
  return path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

}  // namespace

audio::Signal loudest_channel(const audio::Signal& signal) {
  audio::Signal sound;
  sound.sample_rate_hz = signal.sample_rate_hz;
  sound.origin = signal.origin;
  Eigen::Index loudest = 0;
  for (Eigen::Index c = 1; c < signal.n_channels(); ++c) {
    if (signal.samples.col(c).squaredNorm() > signal.samples.col(loudest).squaredNorm()) loudest = c;
  }
  if (signal.n_channels() > 0) sound.samples = signal.samples.col(loudest);
  return sound;
}

ReportFolder::ReportFolder(const std::filesystem::path& result_json, const ReportOptions& options, Monitor& monitor)
    : folder_(result_json.parent_path().empty() ? "." : result_json.parent_path()),
      options_(options),
      monitor_(monitor) {}

std::filesystem::path ReportFolder::beside(const std::string& name) {
  if (name.empty()) return {};
  const std::filesystem::path path(name);
  const bool inside = lies_inside(path);
  if (!inside || !has(name)) {
    warn(name.substr(0, 200) + (inside ? ": no such file beside the result" : ": lies outside the result's folder") +
         ", left out");
    return {};
  }
  return folder_ / path;
}

audio::Signal ReportFolder::sound_beside(const std::string& name) {
  const std::filesystem::path path = beside(name);
  if (path.empty()) return {};
  try {
    return loudest_channel(audio::read_sound(path));
  } catch (const InputError& error) {
    warn(std::string(error.what()) + "; left out");
    return {};
  }
}

bool ReportFolder::has(const std::string& name) const {
  std::error_code ignored;
  return lies_inside(name) && std::filesystem::is_regular_file(folder_ / name, ignored);
}

void ReportFolder::add_file(const std::string& name, std::string bytes) {
  output_.emplace_back(folder_ / name, std::move(bytes));
}

void ReportFolder::add_figure(const std::string& stem, const Svg& svg) {
  const std::string text = svg.standalone();
  add_file("figures/" + stem + ".svg", text);
  try {
    add_file("figures/" + stem + ".png", png_of_svg(text, kPngScale));
  } catch (const NumericalError& error) {
    warn(stem + ".png left out: " + error.what());
  }
}

std::vector<std::filesystem::path> ReportFolder::write() {
  std::error_code error;
  std::filesystem::create_directories(folder_ / "figures", error);
  if (error) throw InputError((folder_ / "figures").string(), "cannot be made", error.message());
  std::vector<std::filesystem::path> written, made;
  try {
    for (const auto& [path, bytes] : output_) {
      const bool is_new = !std::filesystem::exists(path);
      write_file(path, bytes);
      if (is_new) made.push_back(path);
      written.push_back(path);
    }
  } catch (const std::exception&) {
    for (const std::filesystem::path& path : made) std::filesystem::remove(path, error);
    throw;
  }
  return written;
}

}  // namespace klang::reports::detail
