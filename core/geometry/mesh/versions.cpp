#include "core/geometry/mesh/versions.hpp"

namespace klang::mesh {

std::map<std::string, std::string> library_versions() {
  return {{"TetGen", "1.5"}};  // neither its header nor its library tells more
}

}  // namespace klang::mesh
