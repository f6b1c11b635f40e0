#pragma once
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

struct TetgenOptions {
  double max_edge_m = 0.0;         ///< > 0: no edge of the tetrahedra longer than this; 0: from the surface alone
  double radius_edge_ratio = 1.4;  ///< quality bound of TetGen's refinement, 1.1 to 10
  double min_dihedral_deg = 10.0;  ///< as TetGen tries to reach it, 0 to 18
  int order = 2;                   ///< 1 or 2; mid-nodes lie half-way (the surface is flat facets)
  double max_elements = 4e6;       ///< refuse, before meshing, what would need clearly more
  /// In a process of its own (foundation/base/child.hpp): a crash of TetGen becomes an InputError, and a stop is heeded.
  /// Not inside parallel jobs.
  bool in_child = false;
  void validate() const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"max_edge_m", "Longest edge of the tetrahedra; 0: from the surface alone", between(0.0, 1e6)},
          self.max_edge_m);
    visit({"radius_edge_ratio", "Bound of the refinement's quality", between(1.1, 10.0)}, self.radius_edge_ratio);
    visit({"min_dihedral_deg", "Smallest dihedral angle as TetGen tries to reach it", between(0.0, 18.0)},
          self.min_dihedral_deg);
    visit({"order", "Order of the elements", between(1.0, 2.0)}, self.order);
    visit({"max_elements", "More are refused before meshing", between(1.0, 2e7)}, self.max_elements);
    visit({"in_child", "In a process of its own, whose crash becomes an error"}, self.in_child);
  }
};

/// How many tetrahedra mesh_surface() will make, to about a factor of two: those that max_edge_m asks for in the volume, and
/// those that grow inwards from each triangle of the surface (most of them in scans), 8 A / s^2 of a triangle of area A whose
/// corners' shortest edge is s. Measured on balls, rings and scans of 10,000 triangles: 0.4 to 1.8 times that.
double expected_elements(const SurfaceMesh& surface, double volume_m3, const TetgenOptions& options);

/// Fills a closed surface with tetrahedra (TetGen 1.5, constrained Delaunay with refinement). The surface is
/// checked first (see check_closed_surface); its facets are kept as they are, but may be cut finer. One call
/// at a time runs in TetGen; others wait. Node set "surface" holds the boundary.
/// @param name  the file, for messages
/// @throws InputError for a surface that bounds no solid, or one that TetGen gives up on
/// and, with in_child, Interrupted
TetMesh mesh_surface(const SurfaceMesh& surface, const TetgenOptions& options, const std::string& name,
                     Monitor& monitor = silent_monitor());

}  // namespace klang::mesh
