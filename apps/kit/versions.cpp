#include "apps/kit/versions.hpp"

#include <CLI/Version.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include <unistd.h>
#include <Eigen/Core>

#include "core/geometry/mesh/versions.hpp"
#include "core/physics/modal/versions.hpp"
#include "core/sound/audio/versions.hpp"
#include "fit/run/versions.hpp"
#include "reports/report/versions.hpp"

namespace klang::apps {

std::map<std::string, std::string> library_versions() {
  std::map<std::string, std::string> versions = {
      {"CLI11", CLI11_VERSION},
      {"Eigen", std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                    std::to_string(EIGEN_MINOR_VERSION)},
      {"nlohmann-json", std::to_string(NLOHMANN_JSON_VERSION_MAJOR) + "." +
                            std::to_string(NLOHMANN_JSON_VERSION_MINOR) + "." +
                            std::to_string(NLOHMANN_JSON_VERSION_PATCH)}};
  for (const auto& layer : {audio::library_versions(), mesh::library_versions(), modal::library_versions(),
                            fit::library_versions(), reports::library_versions()}) {
    versions.insert(layer.begin(), layer.end());
  }
  return versions;
}

bool program_in_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  if (path == nullptr) return false;
  std::istringstream folders(path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (::access((std::filesystem::path(folder) / name).c_str(), X_OK) == 0) return true;
  }
  return false;
}

}  // namespace klang::apps
