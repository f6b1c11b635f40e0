#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/bubble_documents.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/thermal_option.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/bubble/bubble_physics.hpp"

namespace klang::apps {
namespace {

struct InfoOptions {
  double radius_m = 0.0;
  std::string literature = "right";
  std::string thermal = "leighton";
  bubble::BubbleMedium medium;
};

bubble::BubbleTheory theory_of(const InfoOptions& options) {
  if (options.literature != "right" && options.literature != "paper")
    throw InputError("--literature", "unknown choice", options.literature, "right, paper");
  const bubble::BubbleTheory theory = thermal_theory(options.thermal);
  if (options.literature == "right") return theory;
  if (theory != bubble::BubbleTheory::kLeighton)
    throw InputError("--thermal", "the printed forms have no exact thermal theory", options.thermal, "leighton");
  return bubble::BubbleTheory::kPaper;
}

int run_info(const InfoOptions& options, const CommonOptions& common) {
  const bubble::BubbleTheory theory = theory_of(options);
  const bubble::BubbleOscillation found = bubble::bubble_oscillation(options.radius_m, options.medium, theory);
  const nlohmann::json used = {{"radius_m", options.radius_m},
                               {"literature", options.literature},
                               {"thermal", options.thermal},
                               {"liquid_density_kg_m3", options.medium.liquid_density_kg_m3},
                               {"liquid_sound_speed_m_s", options.medium.liquid_sound_speed_m_s},
                               {"liquid_viscosity_pa_s", options.medium.liquid_viscosity_pa_s},
                               {"surface_tension_n_m", options.medium.surface_tension_n_m},
                               {"static_pressure_pa", options.medium.static_pressure_pa},
                               {"heat_capacity_ratio", options.medium.heat_capacity_ratio},
                               {"gas_diffusivity_m2_s", options.medium.gas_diffusivity_m2_s}};
  BubbleInfoDocument document;
  document.header = make_header("bubble_info", "done", common, used, {});
  document.radius_m = options.radius_m;
  document.undamped_frequency_hz = found.undamped_frequency_hz;
  document.damped_frequency_hz = found.damped_frequency_hz;
  document.decay_per_s = found.decay_per_s;
  document.delta_radiation = found.delta_radiation;
  document.delta_viscous = found.delta_viscous;
  document.delta_thermal = found.delta_thermal;
  document.polytropic_index = found.polytropic_index;
  write_json(common, json_of(document));
  say(common, "radius %g mm: %.6g Hz undamped, %.6g Hz heard, decay %.5g per s (-60 dB in %.3g ms)\n",
      1e3 * options.radius_m, found.undamped_frequency_hz, found.damped_frequency_hz, found.decay_per_s,
      6907.755 / found.decay_per_s);
  say(common, "damping: radiation %.5g, viscosity %.5g, heat %.5g; polytropic index %.5g\n", found.delta_radiation,
      found.delta_viscous, found.delta_thermal, found.polytropic_index);
  return kDone;
}

}  // namespace

Subcommand add_bubble_info(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* app = group.add_subcommand("info", "Frequency and damping of one bubble");
  app->add_option("--radius-m", options->radius_m, "Radius of the bubble, 1e-5 to 0.05")->required();
  app->add_option("--literature", options->literature,
                  "right, or paper: the forms as printed by Zheng and James 2009 (docs/errata.md)")
      ->capture_default_str();
  add_thermal_option(*app, options->thermal);
  add_fields(*app, common, options->medium,
             {{"liquid_density_kg_m3"},
              {"liquid_sound_speed_m_s"},
              {"liquid_viscosity_pa_s"},
              {"surface_tension_n_m"},
              {"static_pressure_pa"},
              {"heat_capacity_ratio"},
              {"gas_diffusivity_m2_s"}});
  app->footer("Example:\n  klang bubble info --radius-m 0.001 --json b.json");
  return {app,
          [options, &common] { return run_info(*options, common); },
          {result_kind<BubbleInfoDocument>("bubble_info", "the result of `klang bubble info`")}};
}

}  // namespace klang::apps
