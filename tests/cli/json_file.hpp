#pragma once
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace klang::test {

inline nlohmann::json read_json(const std::filesystem::path& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

}  // namespace klang::test
