#include "apps/kit/option_tables.hpp"

#include <CLI/CLI.hpp>

namespace klang::apps {
namespace {

const std::string kCommonGroup = "Common options";

std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string row(const CLI::Option& option) {
  const std::string name = option.get_positional() ? option.get_name(true) : option.get_name(false, true);
  const std::string value = option.get_required() ? "required" : option.get_default_str();
  return "| `" + name + "` | " + cell(option.get_type_name()) + " | " + cell(value) + " | " +
         cell(option.get_description()) + " |\n";
}

std::string table(const CLI::App& app, bool common) {
  std::string text = "| option | value | default | meaning |\n| --- | --- | --- | --- |\n";
  for (const CLI::Option* option : app.get_options()) {
    const bool hidden = option == app.get_help_ptr() || option->get_group().empty();
    if (hidden || (option->get_group() == kCommonGroup) != common) continue;
    text += row(*option);
  }
  return text;
}

}  // namespace

std::string option_tables_markdown(const Program& program) {
  std::string text =
      "# Options\n\nAll options of all subcommands, written by a test from the program itself. `klang SUBCOMMAND "
      "--help` shows "
      "the same, with examples.\n";
  const std::vector<const CLI::App*> commands = program.commands();
  text += "\n## Every subcommand\n\n" + table(*commands.front(), true);
  for (const CLI::App* app : commands) {
    text += "\n## " + program.path_of(*app) + "\n\n" + app->get_description() + ".\n\n" + table(*app, false);
  }
  return text;
}

}  // namespace klang::apps
