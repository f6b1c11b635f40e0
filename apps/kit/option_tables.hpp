#pragma once
#include <string>

#include "apps/kit/program.hpp"

namespace klang::apps {

/// docs/options.md: a Markdown table of the options of each subcommand, as the program has them.
std::string option_tables_markdown(const Program& program);

}  // namespace klang::apps
