#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/ringdown/analysis_document.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

namespace fs = std::filesystem;

struct WatchOptions {
  std::string folder, output;
  double every_s = 0.5;
  double settled_s = 1.0;
  double for_s = 0.0;
  double a4_hz = audio::kConcertPitchHz;
};

bool is_sound(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const std::set<std::string> known{".wav", ".flac", ".ogg", ".mp3", ".aif", ".aiff"};
  return known.contains(extension);
}

/// A file as it was last seen.
struct Seen {
  std::uintmax_t size = 0;
  fs::file_time_type changed;
  std::chrono::steady_clock::time_point since;  ///< it has not changed from then on
  bool done = false;
};

void analyse(const fs::path& file, const fs::path& target, const WatchOptions& options, const CommonOptions& common,
             Monitor& monitor) {
  const audio::Signal recording = audio::read_sound(file);
  const fit::RingdownResult result = fit::identify_ringdown(recording, {}, monitor);
  monitor.throw_if_stopped();
  if (!result.usable()) throw NumericalError(file.string() + ": " + result.message);
  OutputDirectory out(target);
  fit::AnalysisDocument document = fit::analysis_document(
      make_header("analysis", "ok", common, {{"a4_hz", options.a4_hz}}, {file}), result, options.a4_hz);
  document.name = file.stem().string();
  document.duration_s = recording.duration_s();
  document.n_channels = static_cast<int>(recording.n_channels());
  document.files = {"recording.wav", "resynthesis.wav"};
  audio::write_sound(out.staging() / "recording.wav", recording);
  audio::write_sound(out.staging() / "resynthesis.wav", fit::resynthesise(result, recording.n_frames()));
  write_file(out.staging() / "analysis.json", json_text(json_of(document)));
  for (const std::string& warning : reports::write_report(out.staging() / "analysis.json", {}, monitor).warnings)
    warn(warning);
  monitor.throw_if_stopped();
  out.commit();
  say(common, "%s: %zu partials", file.filename().c_str(), document.partials.size());
  if (!document.partials.empty()) {
    const auto strongest = std::max_element(document.partials.begin(), document.partials.end(),
                                            [](const fit::Partial& a, const fit::Partial& b) {
                                              return a.amplitude.value_or(0.0) < b.amplitude.value_or(0.0);
                                            });
    say(common, ", strongest %.3f Hz, %s %+.1f cents", strongest->frequency_hz, strongest->note.c_str(),
        strongest->cents.value_or(0.0));
  }
  say(common, "\n");
  std::fflush(stdout);
}

/// The folder of a file: its stem, or its whole name where another file has that stem.
fs::path target_of(const fs::path& file, std::map<std::string, fs::path>& owners, const fs::path& output) {
  const std::string stem = file.stem().string();
  const auto [owner, is_new] = owners.emplace(stem, file);
  return output / (owner->second == file ? stem : file.filename().string());
}

int run_watch(const WatchOptions& options, const CommonOptions& common) {
  if (!common.json.empty())
    throw InputError("--json", "has no meaning here: each file's result is in OUTPUT/NAME/analysis.json",
                     common.json.string());
  checked("command line", "--every-s", options.every_s, 0.05, 3600.0);
  checked("command line", "--settled-s", options.settled_s, 0.05, 3600.0);
  checked("command line", "--for-s", options.for_s, 0.0, 1e9);
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  std::error_code error;
  if (!fs::is_directory(options.folder, error)) throw InputError(options.folder, "is no folder to watch");
  fs::create_directories(options.output, error);
  if (error) throw InputError(options.output, error.message());
  TerminalMonitor monitor(true);
  std::map<fs::path, Seen> files;
  std::map<std::string, fs::path> owners;
  using Clock = std::chrono::steady_clock;
  const auto began = Clock::now();
  const auto seconds_since = [](Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  };
  while (options.for_s == 0.0 || seconds_since(began) < options.for_s) {
    std::vector<fs::path> now;
    for (const auto& entry : fs::directory_iterator(options.folder, error)) {
      if (entry.is_regular_file(error) && is_sound(entry.path())) now.push_back(entry.path());
    }
    std::sort(now.begin(), now.end());
    for (const fs::path& file : now) {
      const std::uintmax_t size = fs::file_size(file, error);
      if (error) continue;
      const fs::file_time_type changed = fs::last_write_time(file, error);
      if (error) continue;
      Seen& seen = files[file];
      if (seen.size != size || seen.changed != changed || seen.since == Clock::time_point()) {
        seen = {size, changed, Clock::now(), false};
        continue;
      }
      if (seen.done || seconds_since(seen.since) < options.settled_s) continue;
      seen.done = true;
      if (size == 0) {
        warn(file.string() + ": is empty (when it grows it is analysed)");
        continue;
      }
      try {
        analyse(file, target_of(file, owners, options.output), options, common, monitor);
      } catch (const Interrupted&) {
        throw;
      } catch (const std::exception& problem) {  // the next file may be whole
        warn(problem.what());
      }
    }
    monitor.throw_if_stopped();
    std::this_thread::sleep_for(std::chrono::duration<double>(options.every_s));
    monitor.throw_if_stopped();
  }
  return kDone;
}

}  // namespace

Subcommand add_watch(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App* app = program.add_subcommand("watch", "Analyse sound files as they arrive in a folder, until stopped");
  app->add_option("folder", options->folder, "Where sound files arrive")->required();
  app->add_option("-o,--output", options->output, "Folder for a folder NAME with analysis.json and report.html of each")
      ->required();
  app->add_option("--every-s", options->every_s, "Look so often, 0.05 to 3600")->capture_default_str();
  app->add_option("--settled-s", options->settled_s, "A file that has not changed for so long is whole, 0.05 to 3600")
      ->capture_default_str();
  app->add_option("--for-s", options->for_s, "Stop after so long; 0: only when stopped (Ctrl-C)")
      ->capture_default_str();
  app->add_option("--a4-hz", options->a4_hz, "Frequency of A4, 300 to 600")->capture_default_str();
  app->footer("Example:\n  klang watch recordings -o analysed");
  return {app, [options, &common] { return run_watch(*options, common); }};
}

}  // namespace klang::apps
