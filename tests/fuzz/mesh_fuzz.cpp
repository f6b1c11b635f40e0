// Any bytes given as a mesh, a surface or a profile are either read or refused with an InputError; nothing else. The first byte
// picks the format (tools/lib/fuzz_seeds.py has the same numbers).
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/surface_repair.hpp"
#include "core/geometry/shapes/detail/profile.hpp"

namespace {

void read_as(int format, std::string_view bytes) {
  using namespace klang::mesh;
  static constexpr const char* kSurfaces[] = {".stl", ".obj", ".ply", ".off"};
  if (format < 4) {
    SurfaceRepairs repairs;
    const SurfaceMesh surface = read_surface_bytes(bytes, kSurfaces[format], "fuzz", &repairs);
    check_closed_surface(repaired_surface(surface, "fuzz", repairs), "fuzz");
  } else if (format == 4) {
    const std::size_t end = bytes.find('\0');  // of the .node file
    mesh_quality(read_tetgen_bytes(bytes.substr(0, end), end < bytes.size() ? bytes.substr(end + 1) : "", "fuzz"));
  } else if (format == 5) {
    detail::parse_profile(bytes, "fuzz");
  } else {
    mesh_quality(read_tet_mesh_bytes(bytes, format == 6 ? ".msh" : ".vtu", "fuzz"));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read_as(data[0] % 8, {reinterpret_cast<const char*>(data) + 1, size - 1});
  } catch (const klang::InputError&) {
  }
  return 0;
}
