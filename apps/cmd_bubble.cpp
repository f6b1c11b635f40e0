#include "cmd_bubble.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "core/base/errors.hpp"

namespace klang::apps {

bubble::BubbleTheory thermal_theory(const std::string& choice) {
  if (choice == "leighton") return bubble::BubbleTheory::kLeighton;
  if (choice == "prosperetti") return bubble::BubbleTheory::kProsperetti;
  throw InputError("--thermal", "unknown choice", choice, "leighton, prosperetti");
}

void add_thermal_option(CLI::App& app, std::string& choice) {
  app.add_option("--thermal", choice, "Loss by heat: leighton, or prosperetti for the exact theory")->capture_default_str();
}

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
