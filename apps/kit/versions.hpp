#pragma once
#include <map>
#include <string>

namespace klang::apps {

/// Name and version of every library that the program is linked with.
std::map<std::string, std::string> library_versions();

bool program_in_path(const std::string& name);

}  // namespace klang::apps
