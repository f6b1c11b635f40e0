#include "apps/kit/manual.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "core/foundation/base/provenance.hpp"

namespace klang::apps {
namespace {

/// Text that roff takes as it stands.
std::string roff(const std::string& text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
    line_begins = c == '\n';
  }
  return out;
}

std::vector<const CLI::Option*> shown_options(const CLI::App& app) {
  std::vector<const CLI::Option*> options;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty()) options.push_back(option);
  return options;
}

std::string dashed(std::string path) {
  std::replace(path.begin(), path.end(), ' ', '-');
  return path;
}

/// Commands and groups below an app, in the order of --help.
std::vector<const CLI::App*> commands_below(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::string page(const CLI::App& app, const std::string& path, const std::string& more,
                 const std::string& see_also = "") {
  std::string upper = dashed(path);
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string text = ".TH " + upper + " 1 \"\" \"klangprobe " + version() + "\" \"Klangprobe\"\n.SH NAME\n" +
                     roff(dashed(path)) + " \\- " + roff(app.get_description()) + "\n.SH SYNOPSIS\n.B " + roff(path) +
                     "\n";
  for (const CLI::Option* option : shown_options(app)) {
    if (!option->get_positional()) continue;
    text += ".I " + roff(option->get_name(true)) + "\n";
  }
  text += commands_below(app).empty() ? "[options]\n.SH OPTIONS\n" : "command [options]\n.SH OPTIONS\n";
  for (const CLI::Option* option : shown_options(app)) {
    const bool positional = option->get_positional();
    const std::string value = option->get_items_expected_max() > 0 && !positional ? " " + option->get_type_name() : "";
    text += ".TP\n\\fB" + roff(positional ? option->get_name(true) : option->get_name(false, true)) + "\\fR" +
            roff(value) + "\n" + roff(option->get_description());
    if (option->get_required()) text += " (required)";
    if (!option->get_default_str().empty()) text += " (default: " + roff(option->get_default_str()) + ")";
    text += "\n";
  }
  text += more;
  if (!app.get_footer().empty()) text += ".SH NOTES\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
  return text + ".SH SEE ALSO\nklang(1)" + see_also + "\n";
}

/// Options of a command with their long and short names: "--json", "-q".
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  return names;
}

std::string option_words(const CLI::App& app) {
  std::string words;
  for (const CLI::Option* option : shown_options(app)) {
    for (const std::string& name : names_of(*option)) words += (words.empty() ? "" : " ") + name;
  }
  return words;
}

/// Within single quotes of a shell.
std::string shell_quoted(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return "'" + out + "'";
}

}  // namespace

std::map<std::string, std::string> manual_pages(const Program& program) {
  std::map<std::string, std::string> pages;
  std::string list = ".SH COMMANDS\n";
  for (const CLI::App* command : program.commands()) {
    const std::string path = program.path_of(*command);
    pages[dashed(path) + ".1"] = page(*command, path, "");
    list += ".TP\n\\fB" + roff(path) + "\\fR\n" + roff(command->get_description()) + "\n";
  }
  for (const CLI::App* group : commands_below(program.app())) {
    const std::vector<const CLI::App*> members = commands_below(*group);
    if (members.empty()) continue;
    std::string of_group = ".SH COMMANDS\n", see_also;
    for (const CLI::App* member : members) {
      const std::string path = program.path_of(*member);
      of_group += ".TP\n\\fB" + roff(path) + "\\fR\n" + roff(member->get_description()) + "\n";
      see_also += ", " + roff(dashed(path)) + "(1)";
    }
    const std::string path = program.path_of(*group);
    pages[dashed(path) + ".1"] = page(*group, path, of_group, see_also);
  }
  pages["klang.1"] = page(program.app(), "klang", list);
  return pages;
}

std::string bash_completion(const Program& program) {
  std::string cases;
  const auto add = [&](const CLI::App& app, const std::string& path) {
    std::string words = option_words(app);
    for (const CLI::App* child : commands_below(app)) words += " " + child->get_name();
    cases += "    \"" + path + "\") words=" + shell_quoted(words) + " ;;\n";
  };
  add(program.app(), "klang");
  for (const CLI::App* child : commands_below(program.app())) {
    add(*child, "klang " + child->get_name());
    for (const CLI::App* member : commands_below(*child))
      add(*member, "klang " + child->get_name() + " " + member->get_name());
  }
  std::string groups;
  for (const CLI::App* child : commands_below(program.app()))
    if (!commands_below(*child).empty()) groups += (groups.empty() ? "'klang " : "|'klang ") + child->get_name() + "'";
  return "# bash completion for klang, made from its own descriptions\n"
         "_klang() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} path=klang words='' i\n"
         "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
         "    case ${COMP_WORDS[i]} in\n"
         "      -*) ;;\n"
         "      *)\n"
         "        case $path in\n"
         "          klang) path=\"klang ${COMP_WORDS[i]}\" ;;\n"
         "          " +
         groups +
         ") path=\"$path ${COMP_WORDS[i]}\" ;;\n"
         "        esac ;;\n"
         "    esac\n"
         "  done\n"
         "  case $path in\n" +
         cases +
         "  esac\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "  if [[ $current != -* && $path != klang ]]; then\n"
         "    mapfile -t -O \"${#COMPREPLY[@]}\" COMPREPLY < <(compgen -f -- \"$current\")\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F _klang klang\n";
}

std::string zsh_completion(const Program& program) {
  const auto described = [](const std::string& name, std::string meaning) {
    std::string safe;
    for (const char c : meaning) safe += c == '[' || c == ']' || c == ':' ? std::string("\\") + c : std::string(1, c);
    return shell_quoted(name + "[" + safe + "]");
  };
  const auto arguments = [&](const CLI::App& app) {
    std::string text = "_arguments -s";
    for (const CLI::Option* option : shown_options(app)) {
      for (const std::string& name : names_of(*option)) {
        std::string entry = described(name, option->get_description());
        if (option->get_items_expected_max() > 0) entry += ":value:_files";
        text += " \\\n        " + entry;
      }
    }
    return text + " \\\n        '*:file:_files'";
  };
  std::string text =
      "#compdef klang\n# zsh completion for klang, made from its own descriptions\n_klang() {\n  local -a commands\n  "
      "commands=(\n";
  for (const CLI::App* child : commands_below(program.app()))
    text += "    " + shell_quoted(child->get_name() + ":" + child->get_description()) + "\n";
  text += "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n  case $words[2] in\n";
  for (const CLI::App* child : commands_below(program.app())) {
    const auto members = commands_below(*child);
    text += "    " + child->get_name() + ")\n";
    if (members.empty()) {
      text += "      " + arguments(*child) + " ;;\n";
      continue;
    }
    text += "      if (( CURRENT == 3 )); then\n        local -a members\n        members=(";
    for (const CLI::App* member : members)
      text += " " + shell_quoted(member->get_name() + ":" + member->get_description());
    text += " )\n        _describe member members\n        return\n      fi\n      case $words[3] in\n";
    for (const CLI::App* member : members)
      text += "      " + member->get_name() + ")\n        " + arguments(*member) + " ;;\n";
    text += "      esac ;;\n";
  }
  return text + "  esac\n}\n_klang \"$@\"\n";
}

std::string fish_completion(const Program& program) {
  std::string text = "# fish completion for klang, made from its own descriptions\n";
  const auto options = [&](const CLI::App& app, const std::string& condition) {
    for (const CLI::Option* option : shown_options(app)) {
      if (option->get_positional()) continue;
      text += "complete -c klang -n " + shell_quoted(condition);
      for (const std::string& name : option->get_lnames()) text += " -l " + name;
      for (const std::string& name : option->get_snames()) text += " -s " + name;
      if (option->get_items_expected_max() > 0) text += " -r";
      text += " -d " + shell_quoted(option->get_description()) + "\n";
    }
  };
  for (const CLI::App* child : commands_below(program.app())) {
    text += "complete -c klang -f -n __fish_use_subcommand -a " + child->get_name() + " -d " +
            shell_quoted(child->get_description()) + "\n";
    const auto members = commands_below(*child);
    const std::string seen = "__fish_seen_subcommand_from " + child->get_name();
    if (members.empty()) options(*child, seen);
    for (const CLI::App* member : members) {
      text += "complete -c klang -f -n " + shell_quoted(seen) + " -a " + member->get_name() + " -d " +
              shell_quoted(member->get_description()) + "\n";
      options(*member, seen + "; and __fish_seen_subcommand_from " + member->get_name());
    }
  }
  return text;
}

}  // namespace klang::apps
