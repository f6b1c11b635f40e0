#include "apps/kit/command_group.hpp"

#include <CLI/CLI.hpp>
#include <vector>

namespace klang::apps {

Subcommand add_group(CLI::App& program, CommonOptions& common, const std::string& name, const std::string& description,
                     std::initializer_list<AddSubcommand> members) {
  CLI::App* group = program.add_subcommand(name, description);
  group->require_subcommand(1);
  std::vector<Subcommand> children;
  for (const AddSubcommand add : members) {
    children.push_back(add(*group, common));
    add_common_options(*children.back().app, common);
  }
  return {group, [children] {
            for (const Subcommand& child : children) {
              if (child.app->parsed()) return child.run();
            }
            return static_cast<int>(kBadInput);
          }};
}

}  // namespace klang::apps
