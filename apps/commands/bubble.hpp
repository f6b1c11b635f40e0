#pragma once
#include <string>

#include "apps/kit/command.hpp"
#include "core/physics/bubble/bubble_physics.hpp"

namespace klang::apps {

/// Each adds one subcommand to the group `klang bubble` and its common options to itself; cmd_bubble.cpp lists them.
Subcommand add_bubble_info(CLI::App& group, CommonOptions& common);
Subcommand add_bubble_synth(CLI::App& group, CommonOptions& common);
Subcommand add_bubble_fit(CLI::App& group, CommonOptions& common);
Subcommand add_bubble_transfer(CLI::App& group, CommonOptions& common);

/// `--thermal`: how the loss by heat is told. @throws InputError
bubble::BubbleTheory thermal_theory(const std::string& choice);
void add_thermal_option(CLI::App& app, std::string& choice);

}  // namespace klang::apps
