#pragma once
#include "command.hpp"

namespace klang::apps {

/// Each adds one subcommand to the group `klang bubble` and its common options to itself; cmd_bubble.cpp lists them.
Subcommand add_bubble_info(CLI::App& group, CommonOptions& common);
Subcommand add_bubble_synth(CLI::App& group, CommonOptions& common);
Subcommand add_bubble_fit(CLI::App& group, CommonOptions& common);
Subcommand add_bubble_transfer(CLI::App& group, CommonOptions& common);

}  // namespace klang::apps
