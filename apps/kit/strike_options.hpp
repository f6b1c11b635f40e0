#pragma once
#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/physics/events/impulse.hpp"
#include "core/physics/modal/modal_model.hpp"

/// How a modal model is made to sound: options of the subcommands that do so.
namespace klang::apps {

/// The parameters of every damping law that is offered as options; laws add up.
struct DampingOptions {
  std::vector<std::vector<double>> parameters;  ///< of each law of damping_laws(LawUse::kOptions)
  DampingOptions();
  bool given = false;                         ///< by an option, be it 0
  bool any() const;                           ///< one of them is not 0
  void validate() const;                      ///< InputError
  void write(nlohmann::json& options) const;  ///< by parameter name
};

void add_damping_options(CLI::App& app, DampingOptions& damping);
void add_strike_option(CLI::App& app, std::vector<std::string>& strikes);

/// "--rayleigh-stiffness-s, --rayleigh-mass-per-s or --loss-factor", for messages.
std::string damping_option_names();

/// Decay of each mode by all laws together.
Eigen::VectorXd decay_per_s(const DampingOptions& damping, const modal::ModalModel& model);

/// Strikes from --strike texts; without one, a unit impulse across the body's thinnest direction at its far end.
std::vector<events::Strike> read_strikes(const std::vector<std::string>& texts, double duration_s,
                                         const modal::ModalModel& model);

}  // namespace klang::apps
