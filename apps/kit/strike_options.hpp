#pragma once
#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/physics/events/impulse.hpp"
#include "core/physics/modal/modal_model.hpp"

/// How a modal model is made to sound: options of the subcommands that do so.
namespace klang::apps {

struct DampingOptions {
  double rayleigh_stiffness_s = 0.0;
  double rayleigh_mass_per_s = 0.0;
  double loss_factor = 0.0;
  void validate() const;  ///< InputError
};

void add_damping_options(CLI::App& app, DampingOptions& damping);
void add_strike_option(CLI::App& app, std::vector<std::string>& strikes);

/// Decay of each mode: Rayleigh and constant loss factor add up.
Eigen::VectorXd decay_per_s(const DampingOptions& damping, const modal::ModalModel& model);

/// Strikes from --strike texts; without one, a unit impulse across the body's thinnest direction at its far end.
std::vector<events::Strike> read_strikes(const std::vector<std::string>& texts, double duration_s,
                                         const modal::ModalModel& model);

}  // namespace klang::apps
