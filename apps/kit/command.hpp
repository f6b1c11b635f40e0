#pragma once
#include <CLI/App.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/result_docs.hpp"

namespace klang::apps {

/// Exit codes of every subcommand. A signal other than Ctrl-C ends with 128 + its number (143 SIGTERM, 129 SIGHUP).
enum ExitCode { kDone = 0, kCheckNotPassed = 1, kBadInput = 2, kNumericalFailure = 3, kInterrupted = 130 };

/// Options that every subcommand has.
struct CommonOptions {
  std::filesystem::path json;  ///< "-" is standard output
  bool quiet = false;
  int n_threads = 0;
  std::uint64_t seed = 1;
  std::string command_line;
  bool table_on_stdout = false;  ///< set by a command whose table goes there
  /// What each command calls the fields of its options structs: library code names fields in its messages, users know flags.
  std::map<const CLI::App*, std::map<std::string, std::string>> flags;
};

/// Messages about this field of the options of a command name the flag. A field of an inner struct ("medium.density_kg_m3") is
/// known by its own name, too, where that is clear.
void name_field(const CLI::App& app, CommonOptions& common, const std::string& field, const std::string& flag);

/// Adds --json, --quiet, --threads and --seed.
void add_common_options(CLI::App& app, CommonOptions& common);

/// Progress on a terminal (stderr), silence elsewhere; stops on a signal (apps/kit/signals.hpp).
class TerminalMonitor : public Monitor {
 public:
  explicit TerminalMonitor(bool quiet);
  ~TerminalMonitor() override;
  void progress(std::string_view stage, double fraction) override;
  bool stop_requested() const override;

 private:
  void clear();
  bool active_;
  std::string shown_;
};

/// What every result begins with. @throws InputError for an input that cannot be read
ResultHeader make_header(std::string_view kind, std::string_view status, const CommonOptions& common,
                         const nlohmann::json& options, const std::vector<std::filesystem::path>& inputs);

/// Writes to --json where it was given.
void write_json(const CommonOptions& common, const nlohmann::json& result);

/// A table to a file, or to standard output where the path is "-" (the caller sets CommonOptions::table_on_stdout).
void write_table(const std::filesystem::path& path, const std::string& text);

/// printf to standard output, unless --quiet or where standard output holds JSON or a table.
void say(const CommonOptions& common, const char* format, ...) __attribute__((format(printf, 2, 3)));

/// One line to standard error, "klang: warning: ...", or to who hears warnings instead.
void warn(std::string_view text);

/// Within another program: who hears warnings from now on; empty: standard error again.
void set_warning_hearer(std::function<void(std::string_view)> hearer);

/// One line to standard error, "klang: note: ...", unless --quiet: what was done to the input without being asked.
void note(const CommonOptions& common, std::string_view text);

/// A subcommand: add_NAME() in apps/commands/NAME.cpp, which apps/commands/commands.cpp lists, adds it with its options and
/// examples to its parent; run() is called after parsing and returns the exit code.
struct Subcommand {
  CLI::App* app = nullptr;
  std::function<int()> run;
  std::vector<ResultKind> results = {};  ///< that it writes, for docs/result-json.md
};

}  // namespace klang::apps
