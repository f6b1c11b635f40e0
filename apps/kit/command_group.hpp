#pragma once
#include <initializer_list>
#include <string>

#include "apps/kit/command.hpp"

namespace klang::apps {

/// A command that only holds others (`klang bubble info`, `klang bubble fit`): one of them is required, and each takes the
/// common options.
using AddSubcommand = Subcommand (*)(CLI::App& group, CommonOptions& common);
Subcommand add_group(CLI::App& program, CommonOptions& common, const std::string& name, const std::string& description,
                     std::initializer_list<AddSubcommand> members);

}  // namespace klang::apps
