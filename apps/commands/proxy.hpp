#pragma once
#include "apps/kit/command.hpp"
#include "core/foundation/base/json.hpp"

namespace klang::fit {
struct ProxyErrors;
}

namespace klang::apps {

/// Each adds one subcommand to the group `klang proxy`; cmd_proxy.cpp lists them.
Subcommand add_proxy_build(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_info(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_fit(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_lookup(CLI::App& group, CommonOptions& common);
Subcommand add_proxy_study(CLI::App& group, CommonOptions& common);

/// The measures by their names, units in these.
nlohmann::json proxy_errors_json(const fit::ProxyErrors& errors);

}  // namespace klang::apps
