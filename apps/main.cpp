#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>

#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"

namespace {

using namespace klang::apps;

std::string joined_command_line(int argc, char** argv) {
  std::string text = "klang";
  for (int i = 1; i < argc; ++i) text.append(" ").append(argv[i]);
  return text;
}

/// One line whatever the parser or the library had to say.
int complain(const char* what, int code) {
  std::string line(what);
  for (char& c : line) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "klang: %s\n", line.c_str());
  return code;
}

/// The complaint where a word stands in a subcommand's place, at the top or in a group; else empty.
std::string unknown_subcommand(const CLI::App& program, int argc, char** argv) {
  const CLI::App* group = &program;
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
    if (child == nullptr) return klang::InputError(place + argv[i], "is no subcommand", "", names).what();
    place += std::string(argv[i]) + " ";
    group = child;
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Klangprobe: from recordings of struck objects to their material, with honest error bars", "klang"};
  program.set_version_flag("--version", klang::version());
  program.require_subcommand(1);
  program.footer(
      "Exit codes: 0 done; 1 ran, and a check did not pass; 2 bad input; 3 numerical failure; 130 interrupted.\n"
      "klang SUBCOMMAND --help shows its options and examples.");
  CommonOptions common;
  common.command_line = joined_command_line(argc, argv);
  const Subcommand subcommands[] = {
      add_mesh(program, common),     add_modes(program, common),   add_analyze(program, common),
      add_fit(program, common),      add_tune(program, common),    add_synth(program, common),
      add_transfer(program, common), add_bubble(program, common),  add_proxy(program, common),
      add_converge(program, common), add_regress(program, common), add_validate(program, common),
      add_dataset(program, common),  add_report(program, common),  add_doctor(program, common)};
  for (const Subcommand& subcommand : subcommands) {
    const bool is_group = !subcommand.app->get_subcommands([](const CLI::App*) { return true; }).empty();
    if (!is_group) add_common_options(*subcommand.app, common);  // a group's children have them
  }

  try {
    program.parse(argc, argv);
    klang::set_thread_count(common.n_threads);
    for (const Subcommand& subcommand : subcommands) {
      if (subcommand.app->parsed()) return subcommand.run();
    }
    return kBadInput;
  } catch (const CLI::Success& success) {  // --help, --version
    return program.exit(success);
  } catch (const CLI::ParseError& error) {
    const std::string unknown = unknown_subcommand(program, argc, argv);
    return complain(unknown.empty() ? error.what() : unknown.c_str(), kBadInput);
  } catch (const klang::InputError& error) {
    return complain(error.what(), kBadInput);
  } catch (const klang::Interrupted& error) {
    return complain(error.what(), kInterrupted);
  } catch (const klang::NumericalError& error) {
    return complain(error.what(), kNumericalFailure);
  } catch (const std::bad_alloc&) {
    return complain("out of memory", kNumericalFailure);
  } catch (const std::exception& error) {
    return complain(error.what(), kNumericalFailure);
  }
}
