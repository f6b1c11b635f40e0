#include "cmd_proxy.hpp"

#include <CLI/CLI.hpp>
#include <memory>

namespace klang::apps {

Subcommand add_proxy(CLI::App& program, CommonOptions& common) {
  CLI::App* group = program.add_subcommand("proxy", "Ellipsoids that stand for bodies: precomputed soundbanks, retrieval, errors");
  group->require_subcommand(1);
  auto children = std::make_shared<std::vector<Subcommand>>();
  children->push_back(add_proxy_build(*group, common));
  children->push_back(add_proxy_info(*group, common));
  children->push_back(add_proxy_fit(*group, common));
  children->push_back(add_proxy_lookup(*group, common));
  for (const Subcommand& child : *children) add_common_options(*child.app, common);
  return {group, [children] {
            for (const Subcommand& child : *children) {
              if (child.app->parsed()) return child.run();
            }
            return static_cast<int>(kBadInput);
          }};
}

}  // namespace klang::apps
