#pragma once
#include <span>

#include "apps/kit/program.hpp"

namespace klang::apps {

/// What commands.cpp lists.
std::span<const CommandEntry> all_commands();

}  // namespace klang::apps
