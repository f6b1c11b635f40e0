#pragma once
#include <CLI/App.hpp>
#include <CLI/Error.hpp>
#include <span>
#include <vector>

#include "apps/kit/command.hpp"

namespace klang::apps {

using AddSubcommand = Subcommand (*)(CLI::App& parent, CommonOptions& common);

/// A subcommand, alone or in a group that only holds others (`klang bubble fit`); or such a group, before its members.
struct CommandEntry {
  const char* group = "";             ///< name of the group; empty at the top
  AddSubcommand add = nullptr;        ///< nullptr: the entry is the group itself
  const char* description = nullptr;  ///< of a group
};

/// The command line with all its subcommands. Every one of them, but no group, takes the common options.
class Program {
 public:
  explicit Program(std::span<const CommandEntry> commands);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Parses, runs the subcommand and says what went wrong in one line. @return the exit code
  int run(int argc, char** argv);

  /// Parses and runs one command within another program: no signals are heeded, nothing is said of errors. Once for each object.
  /// @return the exit code @throws InputError: the words too; NumericalError and others as the command
  int call(std::vector<std::string> words);

  const CLI::App& app() const { return app_; }
  std::vector<const CLI::App*> commands() const;       ///< without groups, in the order of --help
  std::string path_of(const CLI::App& command) const;  ///< "klang bubble fit"
  /// What this command calls a field of its options; empty: it does not take it.
  std::string flag_of_field(const CLI::App& command, const std::string& field) const;

 private:
  int run_parsed() const;
  /// Of an exception that is being handled: the one place where it becomes an exit code.
  int exit_code_of_exception(const std::vector<std::string>& words) const;
  /// The flag of a field of the options of the subcommand that was called: what it calls the field, else an option of that name
  /// ("frame_step_s", --frame-step-s), else the field's name.
  std::string flag_or_field(const std::string& field) const;
  /// "help X" becomes "X --help", no words "--help". @throws InputError for an X that is no subcommand
  void ask_for_help(std::vector<std::string>& words) const;
  /// One line on a command line that the parser refused: a word that is no subcommand, an option that is none, or his own words.
  std::string parse_complaint(const std::vector<std::string>& words, const CLI::ParseError& error) const;
  /// The complaint where a word stands in a subcommand's place, at the top or in a group; else empty.
  std::string unknown_subcommand(const std::vector<std::string>& words) const;

  CLI::App app_;
  CommonOptions common_;
  std::vector<Subcommand> subcommands_;
};

}  // namespace klang::apps
