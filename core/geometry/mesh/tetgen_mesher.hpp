#pragma once
#include <string>

#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

struct TetgenOptions {
  double max_edge_m = 0.0;         ///< > 0: no edge of the tetrahedra longer than this; 0: from the surface alone
  double radius_edge_ratio = 1.4;  ///< quality bound of TetGen's refinement, 1.1 to 10
  double min_dihedral_deg = 10.0;  ///< as TetGen tries to reach it, 0 to 18
  int order = 2;                   ///< 1 or 2; mid-nodes lie half-way (the surface is flat facets)
  double max_elements = 4e6;       ///< refuse, before meshing, what would need clearly more
  void validate() const;
};

/// Fills a closed surface with tetrahedra (TetGen 1.5, constrained Delaunay with refinement). The surface is
/// checked first (see check_closed_surface); its facets are kept as they are, but may be cut finer. One call
/// at a time runs in TetGen; others wait. Node set "surface" holds the boundary.
/// @param name  the file, for messages
/// @throws InputError for a surface that bounds no solid, or one that TetGen gives up on
TetMesh mesh_surface(const SurfaceMesh& surface, const TetgenOptions& options, const std::string& name);

}  // namespace klang::mesh
