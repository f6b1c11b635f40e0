#include "apps/kit/thermal_option.hpp"

#include <CLI/CLI.hpp>

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

}  // namespace klang::apps
