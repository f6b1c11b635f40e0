#pragma once
#include <map>
#include <string>

namespace klang::modal {

/// Name and version of the libraries that this layer is built with.
std::map<std::string, std::string> library_versions();

}  // namespace klang::modal
