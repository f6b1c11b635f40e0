#pragma once
#include <map>
#include <string>

namespace klang::fit {

/// Name and version of the libraries that this layer is built with.
std::map<std::string, std::string> library_versions();

}  // namespace klang::fit
