#pragma once
#include <Eigen/Core>
#include <string>

#include "core/foundation/base/errors.hpp"

/// Values as a scene's TOML has them, for scenes that imports write.
namespace klang::liquid_scene {

inline std::string list(const Eigen::Vector3d& x) {
  return "[" + to_text(x.x()) + ", " + to_text(x.y()) + ", " + to_text(x.z()) + "]";
}

/// In quotation marks; what would end them or the line becomes '_'.
inline std::string quoted(const std::string& name) {
  std::string text;
  for (const char c : name) text += c == '"' || c == '\\' || static_cast<unsigned char>(c) < 32 ? '_' : c;
  return "\"" + text + "\"";
}

}  // namespace klang::liquid_scene
