#include "apps/commands/proxy.hpp"

#include "apps/kit/command_group.hpp"

namespace klang::apps {

Subcommand add_proxy(CLI::App& program, CommonOptions& common) {
  return add_group(program, common, "proxy",
                   "Ellipsoids that stand for bodies: precomputed soundbanks, retrieval, errors",
                   {add_proxy_build, add_proxy_info, add_proxy_fit, add_proxy_lookup, add_proxy_study});
}

}  // namespace klang::apps
