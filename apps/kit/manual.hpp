#pragma once
#include <map>
#include <string>

#include "apps/kit/program.hpp"

namespace klang::apps {

/// Manual pages by file name, "klang.1" and one for each command ("klang-bubble-fit.1"), in roff, from the descriptions that --help
/// shows.
std::map<std::string, std::string> manual_pages(const Program& program);

/// Completion of commands and options for bash, zsh and fish.
std::string bash_completion(const Program& program);
std::string zsh_completion(const Program& program);
std::string fish_completion(const Program& program);

}  // namespace klang::apps
