#pragma once
#include "command.hpp"

namespace klang::apps {

/// Each adds one subcommand to the group `klang proxy`; cmd_proxy.cpp lists them.
Subcommand add_proxy_build(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_info(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_fit(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_lookup(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_study(CLI::App& group, CommonOptions& common);

}  // namespace klang::apps
