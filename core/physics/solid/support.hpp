#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::solid {

/// Where and how a body is held.
///   where = "x=0"  nodes with |x - 0| <= 1e-6 of the body's size (also y, z; "x<0.01", "z>0.1")
///         = "box:x0,y0,z0:x1,y1,z1"  nodes inside
///         = "set:NAME"  a named node set of the mesh
/// kClamped and kPinned hold all three displacements of the nodes: with solid elements a pin is a clamped
/// line or point.
enum class SupportKind { kFree, kClamped, kPinned };
struct Support {
  SupportKind kind = SupportKind::kFree;
  std::string where;
};

/// "free", "clamped:x=0", "pinned:set:corner"; InputError otherwise.
Support parse_support(std::string_view text);
/// The text that parse_support reads back.
std::string to_text(const Support& support);

/// The held nodes, ascending; InputError when the region holds none.
std::vector<int> held_nodes(const Support& support, const mesh::TetMesh& mesh);

}  // namespace klang::solid
