#include "fit/run/versions.hpp"

#include <ceres/version.h>
#include <toml++/toml.h>

namespace klang::fit {

std::map<std::string, std::string> library_versions() {
  return {{"Ceres", CERES_VERSION_STRING},
          {"toml++", std::to_string(TOML_LIB_MAJOR) + "." + std::to_string(TOML_LIB_MINOR) + "." +
                         std::to_string(TOML_LIB_PATCH)}};
}

}  // namespace klang::fit
