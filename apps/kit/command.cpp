#include "apps/kit/command.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <mutex>

#include "apps/kit/signals.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"

namespace klang::apps {
namespace {

std::mutex terminal_mutex;
bool line_shown = false;  ///< a progress line stands on the terminal
bool verbose = false;
std::function<void(std::string_view)> warning_hearer;

/// Takes the progress line away before anything else is written.
void clear_line() {
  const std::lock_guard lock(terminal_mutex);
  if (line_shown) std::fputs("\r\033[K", stderr);
  line_shown = false;
}

}  // namespace

void add_common_options(CLI::App& app, CommonOptions& common) {
  app.add_option("--json", common.json, "Write the machine-readable result to FILE (- for standard output)")
      ->type_name("FILE")
      ->group("Common options");
  app.add_flag("--quiet,-q", common.quiet, "Print nothing but errors and warnings")->group("Common options");
  app.add_flag("--verbose", verbose, "Say on standard error what runs, and since when")->group("Common options");
  app.add_option("--threads", common.n_threads, "Threads, 0 to 1024; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->group("Common options");
  app.add_option("--seed", common.seed, "Seed of everything that is random")
      ->check([](const std::string& text) {
        return text.starts_with('-') ? text + " is negative (allowed: whole numbers from 0)" : std::string();
      })
      ->capture_default_str()
      ->group("Common options");
}

void name_field(const CLI::App& app, CommonOptions& common, const std::string& field, const std::string& flag) {
  auto& flags = common.flags[&app];
  flags[field] = flag;
  const std::size_t dot = field.rfind('.');
  if (dot == std::string::npos) return;
  const auto [inner, is_new] = flags.emplace(field.substr(dot + 1), flag);
  if (!is_new && inner->second != flag) inner->second.clear();
}

TerminalMonitor::TerminalMonitor(bool quiet) : active_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

TerminalMonitor::~TerminalMonitor() { clear(); }

void TerminalMonitor::progress(std::string_view stage, double fraction) {
  static const auto begin = std::chrono::steady_clock::now();
  static std::string logged;
  if (!active_ && !verbose) return;
  char line[100];
  const int length = static_cast<int>(stage.size() < 70 ? stage.size() : 70);
  std::snprintf(line, sizeof line, "%.*s %3.0f %%", length, stage.data(), 100.0 * fraction);
  const std::lock_guard lock(terminal_mutex);
  if (verbose && logged != stage) {
    logged = stage;
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - begin;
    std::fprintf(stderr, "%sklang: %.2f s: %.*s\n", line_shown ? "\r\033[K" : "", since.count(), length, stage.data());
    line_shown = false;
  }
  if (!active_ || (shown_ == line && line_shown)) return;
  shown_ = line;
  line_shown = true;
  std::fprintf(stderr, "\r\033[K%s", line);
  std::fflush(stderr);
}

void TerminalMonitor::clear() {
  if (active_ && !shown_.empty()) clear_line();
  shown_.clear();
}

bool TerminalMonitor::stop_requested() const { return stop_signal() != 0; }

ResultHeader make_header(std::string_view kind, std::string_view status, const CommonOptions& common,
                         const nlohmann::json& options, const std::vector<std::filesystem::path>& inputs) {
  ResultHeader header;
  header.kind = kind;
  header.status = status;
  header.provenance = make_provenance(common.command_line, common.seed, options, inputs);
  return header;
}

void write_json(const CommonOptions& common, const nlohmann::json& result) {
  if (common.json.empty()) return;
  const std::string text = json_text(result);
  if (common.json == "-") {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else {
    write_file(common.json, text);
  }
}

void write_table(const std::filesystem::path& path, const std::string& text) {
  if (path == "-") {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else {
    write_file(path, text);
  }
}

void say(const CommonOptions& common, const char* format, ...) {
  if (common.quiet || common.json == "-" || common.table_on_stdout) return;
  clear_line();
  std::va_list arguments;
  va_start(arguments, format);
  std::vprintf(format, arguments);
  va_end(arguments);
}

void set_warning_hearer(std::function<void(std::string_view)> hearer) { warning_hearer = std::move(hearer); }

void warn(std::string_view text) {
  if (warning_hearer) return warning_hearer(text);
  clear_line();
  std::fprintf(stderr, "klang: warning: %.*s\n", static_cast<int>(text.size()), text.data());
}

void note(const CommonOptions& common, std::string_view text) {
  clear_line();
  if (!common.quiet) std::fprintf(stderr, "klang: note: %.*s\n", static_cast<int>(text.size()), text.data());
}

}  // namespace klang::apps
