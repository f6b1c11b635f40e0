#pragma once
#include <string>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid {

/// Outward triangles of a part's hull.
mesh::SurfaceMesh hull_of(const ConvexPart& part);

struct ConvexPartsOptions {
  double bulge = 0.01;  ///< a part's hull may exceed what it fills by this share of its volume, 0 to 1
  int most_parts = 500;
};

/// Convex parts that fill a mesh: the hull of all its corners where the mesh is convex, else its tetrahedra joined, pair of
/// neighbours by pair, the ones that bulge least first, as long as hulls do not bulge by more than is allowed.
/// @param name  of the body, for messages
/// @throws InputError where more parts remain than most_parts
std::vector<ConvexPart> convex_parts_of(const mesh::TetMesh& mesh, const std::string& name,
                                        const ConvexPartsOptions& options = {});

}  // namespace klang::rigid
