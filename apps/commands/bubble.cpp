#include "apps/commands/bubble.hpp"

#include <CLI/CLI.hpp>

#include "apps/kit/command_group.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::apps {

bubble::BubbleTheory thermal_theory(const std::string& choice) {
  if (choice == "leighton") return bubble::BubbleTheory::kLeighton;
  if (choice == "prosperetti") return bubble::BubbleTheory::kProsperetti;
  throw InputError("--thermal", "unknown choice", choice, "leighton, prosperetti");
}

void add_thermal_option(CLI::App& app, std::string& choice) {
  app.add_option("--thermal", choice, "Loss by heat: leighton, or prosperetti for the exact theory")
      ->capture_default_str();
}

Subcommand add_bubble(CLI::App& program, CommonOptions& common) {
  return add_group(program, common, "bubble", "Gas bubbles: how they ring, their sound, recordings of drops",
                   {add_bubble_info, add_bubble_synth, add_bubble_fit, add_bubble_transfer});
}

}  // namespace klang::apps
