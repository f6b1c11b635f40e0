#include "apps/kit/program.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>

#include "apps/kit/signals.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::apps {
namespace {

/// One line whatever the parser or the library had to say; bytes of a file never reach the terminal as its commands.
int complain(const char* what, int code) {
  std::string line(what);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
  }
  std::fprintf(stderr, "klang: %s\n", line.c_str());
  return code;
}

}  // namespace

Program::Program(std::span<const CommandEntry> commands)
    : app_("Klangprobe: from recordings of struck objects to their material, with honest error bars", "klang") {
  app_.set_version_flag("--version", version());
  app_.require_subcommand(1);
  app_.footer(
      "Exit codes: 0 done; 1 ran, and a check did not pass; 2 bad input; 3 numerical failure; 130 interrupted "
      "(143 by SIGTERM, 129 by SIGHUP).\n"
      "klang SUBCOMMAND --help shows its options and examples.");
  for (const CommandEntry& entry : commands) {
    if (entry.add == nullptr) {
      app_.add_subcommand(entry.group, entry.description)->require_subcommand(1);
      continue;
    }
    const std::string group = entry.group;
    CLI::App& parent = group.empty() ? app_ : *app_.get_subcommand(group);
    subcommands_.push_back(entry.add(parent, common_));
    add_common_options(*subcommands_.back().app, common_);
  }
}

int Program::run(int argc, char** argv) {
  common_.command_line = "klang";
  for (int i = 1; i < argc; ++i) common_.command_line.append(" ").append(argv[i]);
  int code = kDone;
  try {
    app_.parse(argc, argv);
    set_thread_count(common_.n_threads);
    heed_signals();
    code = run_parsed();
  } catch (const std::exception&) {
    code = exit_code_of_exception(argc, argv);
  }
  work_is_over(code);
  return code;
}

int Program::run_parsed() const {
  for (const Subcommand& subcommand : subcommands_) {
    if (subcommand.app->parsed()) return subcommand.run();
  }
  return kBadInput;
}

int Program::exit_code_of_exception(int argc, char** argv) const {
  try {
    throw;
  } catch (const CLI::Success& success) {  // --help, --version
    return app_.exit(success);
  } catch (const CLI::ParseError& error) {
    const std::string unknown = unknown_subcommand(argc, argv);
    return complain(unknown.empty() ? error.what() : unknown.c_str(), kBadInput);
  } catch (const OptionsError& error) {
    return complain(error.text([this](const std::string& field) { return flag_or_field(field); }).c_str(), kBadInput);
  } catch (const InputError& error) {
    return complain(error.what(), kBadInput);
  } catch (const Interrupted& error) {
    return complain(error.what(), stop_signal() != 0 ? 128 + stop_signal() : kInterrupted);
  } catch (const NumericalError& error) {
    return complain(error.what(), kNumericalFailure);
  } catch (const std::bad_alloc&) {
    return complain("out of memory", kNumericalFailure);
  } catch (const std::exception& error) {
    return complain(error.what(), kNumericalFailure);
  }
}

std::vector<const CLI::App*> Program::commands() const {
  std::vector<const CLI::App*> commands;
  for (const Subcommand& subcommand : subcommands_) commands.push_back(subcommand.app);
  return commands;
}

std::string Program::path_of(const CLI::App& command) const {
  std::string path = command.get_name();
  for (const CLI::App* at = command.get_parent(); at != nullptr; at = at->get_parent())
    path = at->get_name() + " " + path;
  return path;
}

std::string Program::flag_of_field(const CLI::App& command, const std::string& field) const {
  const auto flags = common_.flags.find(&command);
  if (flags == common_.flags.end()) return {};
  const auto found = flags->second.find(field);
  return found == flags->second.end() ? std::string() : found->second;
}

std::string Program::flag_or_field(const std::string& field) const {
  for (const Subcommand& subcommand : subcommands_) {
    const std::string flag = flag_of_field(*subcommand.app, field);
    if (subcommand.app->parsed() && !flag.empty()) return flag;
  }
  return field;
}

std::string Program::unknown_subcommand(int argc, char** argv) const {
  const CLI::App* group = &app_;
  std::string place;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const auto children = group->get_subcommands([](const CLI::App*) { return true; });
    if (children.empty()) return {};
    const CLI::App* child = nullptr;
    std::string names;
    for (const CLI::App* candidate : children) {
      if (candidate->get_name() == argv[i]) child = candidate;
      names += (names.empty() ? "" : ", ") + candidate->get_name();
    }
    if (child == nullptr) return InputError(place + argv[i], "is no subcommand", "", names).what();
    place += std::string(argv[i]) + " ";
    group = child;
  }
  return {};
}

}  // namespace klang::apps
