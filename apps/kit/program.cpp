#include "apps/kit/program.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <new>
#include <sstream>

#include "apps/kit/ranks.hpp"
#include "apps/kit/signals.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::apps {
namespace {

/// What complain() said last, for the other processes of the run.
std::string last_complaint;

/// One line whatever the parser or the library had to say; bytes of a file never reach the terminal as its commands.
int complain(const char* what, int code) {
  std::string line(what);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
  }
  std::fprintf(stderr, "klang: %s\n", line.c_str());
  last_complaint = line;
  return code;
}

std::vector<const CLI::App*> children_of(const CLI::App& group) {
  return group.get_subcommands([](const CLI::App*) { return true; });
}

/// Whether the next word is this option's value: "--threads 2".
bool takes_next_word(const CLI::App& group, const std::string& word) {
  const CLI::Option* option = group.get_option_no_throw(word);
  return option != nullptr && option->get_items_expected_max() > 0;
}

/// Where in the words, from a place on, a word stands that is no option of the group and no option's value; their number if none.
std::size_t next_plain_word(const CLI::App& group, const std::vector<std::string>& words, std::size_t at) {
  for (; at < words.size(); ++at) {
    if (words[at].empty() || words[at].front() != '-') return at;
    if (takes_next_word(group, words[at])) ++at;
  }
  return words.size();
}

/// What a mistyped option was meant to be.
std::string option_meant(const CLI::App& command, const std::vector<std::string>& left_over) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (const std::string& word : left_over) {
    if (!word.starts_with("-")) continue;
    return did_you_mean(word.substr(0, word.find('=')), known);
  }
  return {};
}

/// What a mistyped choice was meant to be: of the parser's "NAME: WORD not in {a,b,c}".
std::string choice_meant(const std::string& said) {
  static constexpr std::string_view kNotIn = " not in {";
  const std::size_t name_end = said.find(": "), word_end = said.find(kNotIn), list_end = said.rfind('}');
  if (name_end == std::string::npos || word_end == std::string::npos || list_end == std::string::npos) return {};
  const std::size_t word_begin = name_end + 2, list_begin = word_end + kNotIn.size();
  if (word_begin > word_end || list_begin > list_end) return {};
  std::istringstream list(said.substr(list_begin, list_end - list_begin));
  std::vector<std::string> known;
  for (std::string word; std::getline(list, word, ',');) known.push_back(word);
  return did_you_mean(said.substr(word_begin, word_end - word_begin), known);
}

}  // namespace

Program::Program(std::span<const CommandEntry> commands)
    : app_("Klangprobe: from recordings of struck objects to their material, with honest error bars", "klang") {
  app_.set_version_flag("--version", version());
  add_common_options(app_, common_);
  app_.require_subcommand(1);
  app_.footer(
      "Exit codes: 0 done; 1 ran, and a check did not pass; 2 bad input; 3 numerical failure; 130 interrupted "
      "(143 by SIGTERM, 129 by SIGHUP).\n"
      "klang SUBCOMMAND --help and klang help SUBCOMMAND show its options and examples.");
  for (const CommandEntry& entry : commands) {
    if (entry.add == nullptr) {
      CLI::App* group = app_.add_subcommand(entry.group, entry.description)->require_subcommand(1);
      add_common_options(*group, common_);
      continue;
    }
    const std::string group = entry.group;
    CLI::App& parent = group.empty() ? app_ : *app_.get_subcommand(group);
    subcommands_.push_back(entry.add(parent, common_));
    add_common_options(*subcommands_.back().app, common_);
    subcommands_.back().app->set_version_flag("--version", version())->group("");
  }
}

int Program::run(int argc, char** argv) {
  common_.command_line = "klang";
  for (int i = 1; i < argc; ++i) common_.command_line.append(" ").append(argv[i]);
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  int code = kDone;
  std::unique_ptr<Ranks> ranks;
  try {
    ranks = Ranks::join(words);
    ask_for_help(words);
    std::vector<std::string> backwards(words.rbegin(), words.rend());
    app_.parse(backwards);
    set_thread_count(common_.n_threads);
    heed_signals();
    code = run_parsed();
  } catch (const std::exception&) {
    code = exit_code_of_exception(words);
  }
  if (ranks) {
    work_is_over(code);
    const Ranks::End end = ranks->leave(code, last_complaint);
    if (end.code != code) code = complain(end.complaint.c_str(), end.code);
  }
  work_is_over(code);
  return code;
}

int Program::call(std::vector<std::string> words) {
  common_.command_line = "klang";
  for (const std::string& word : words) common_.command_line.append(" ").append(word);
  try {
    std::vector<std::string> backwards(words.rbegin(), words.rend());
    app_.parse(backwards);
    set_thread_count(common_.n_threads);
    return run_parsed();
  } catch (const CLI::ParseError& error) {
    throw InputError(parse_complaint(words, error));
  } catch (const OptionsError& error) {
    throw InputError(error.text([this](const std::string& field) { return flag_or_field(field); }));
  }
}

void Program::ask_for_help(std::vector<std::string>& words) const {
  const std::size_t first = next_plain_word(app_, words, 0);
  const bool asks = first < words.size() && words[first] == "help";
  const auto is_help = [](const std::string& word) { return word == "--help" || word == "-h"; };
  if (!asks && std::any_of(words.begin(), words.end(), is_help)) {  // the whole help is no answer to a mistyped name
    if (const std::string wrong = unknown_subcommand(words); !wrong.empty()) throw InputError(wrong);
  }
  if (!asks && !words.empty()) return;
  if (asks) {
    // "klang help 'scene run'": a name in quotes is its words.
    std::string rest;
    for (std::size_t i = 0; i < words.size(); ++i)
      if (i != first) rest += words[i] + " ";
    std::istringstream separate(rest);
    words.assign(std::istream_iterator<std::string>(separate), {});
    if (next_plain_word(app_, words, 0) < words.size() && words[next_plain_word(app_, words, 0)] == "help")
      words.clear();  // help on help is the whole
  }
  if (const std::string wrong = unknown_subcommand(words); !wrong.empty()) throw InputError(wrong);
  words.emplace_back("--help");
}

int Program::run_parsed() const {
  for (const Subcommand& subcommand : subcommands_) {
    if (subcommand.app->parsed()) return subcommand.run();
  }
  return kBadInput;
}

int Program::exit_code_of_exception(const std::vector<std::string>& words) const {
  try {
    throw;
  } catch (const CLI::Success& success) {  // --help, --version
    return app_.exit(success);
  } catch (const CLI::ParseError& error) {
    return complain(parse_complaint(words, error).c_str(), kBadInput);
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
  std::string own_flag = "--" + field;
  std::replace(own_flag.begin(), own_flag.end(), '_', '-');
  for (const Subcommand& subcommand : subcommands_) {
    if (!subcommand.app->parsed()) continue;
    const std::string flag = flag_of_field(*subcommand.app, field);
    if (!flag.empty()) return flag;
    if (subcommand.app->get_option_no_throw(own_flag) != nullptr) return own_flag;
  }
  return field;
}

std::string Program::parse_complaint(const std::vector<std::string>& words, const CLI::ParseError& error) const {
  const std::string unknown = unknown_subcommand(words);
  if (!unknown.empty()) return unknown;
  const std::vector<std::string> left_over = app_.remaining(true);
  const bool mistyped =
      std::any_of(left_over.begin(), left_over.end(), [](const auto& w) { return w.starts_with("-"); });
  const CLI::App* command = &app_;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  if (!mistyped) return error.what() + choice_meant(error.what());
  // An option that is required may be the one that was mistyped.
  return CLI::ExtrasError(left_over).what() + option_meant(*command, left_over);
}

std::string Program::unknown_subcommand(const std::vector<std::string>& words) const {
  const CLI::App* group = &app_;
  std::string place;
  for (std::size_t at = next_plain_word(app_, words, 0); at < words.size();
       at = next_plain_word(*group, words, at + 1)) {
    const std::vector<const CLI::App*> children = children_of(*group);
    if (children.empty()) return {};
    const CLI::App* child = nullptr;
    std::vector<std::string> names;
    for (const CLI::App* candidate : children) {
      if (candidate->get_name() == words[at]) child = candidate;
      names.push_back(candidate->get_name());
    }
    if (child == nullptr) return unknown_word(place + words[at], "is no subcommand", "", words[at], names).what();
    place += words[at] + " ";
    group = child;
  }
  return {};
}

}  // namespace klang::apps
