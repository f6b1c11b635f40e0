#include "cmd_bubble.hpp"

#include <CLI/CLI.hpp>
#include <memory>

namespace klang::apps {

Subcommand add_bubble(CLI::App& program, CommonOptions& common) {
  CLI::App* group = program.add_subcommand("bubble", "Gas bubbles: how they ring, their sound, recordings of drops");
  group->require_subcommand(1);
  auto children = std::make_shared<std::vector<Subcommand>>();
  children->push_back(add_bubble_info(*group, common));
  children->push_back(add_bubble_synth(*group, common));
  children->push_back(add_bubble_fit(*group, common));
  children->push_back(add_bubble_transfer(*group, common));
  for (const Subcommand& child : *children) add_common_options(*child.app, common);
  return {group, [children] {
            for (const Subcommand& child : *children) {
              if (child.app->parsed()) return child.run();
            }
            return static_cast<int>(kBadInput);
          }};
}

}  // namespace klang::apps
