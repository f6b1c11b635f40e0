#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// How a surface was made coarser, and what that cost.
struct SurfaceDecimation {
  int n_faces_before = 0, n_faces_after = 0;
  double max_distance_m = 0.0, rms_distance_m = 0.0, relative_volume_change = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_faces_before", "triangles of the file"}, self.n_faces_before);
    visit({"n_faces_after", "triangles that went into the mesh"}, self.n_faces_after);
    visit({"max_distance_m", "largest distance of a vertex of either surface from the other"}, self.max_distance_m);
    visit({"rms_distance_m", "root mean square of these distances"}, self.rms_distance_m);
    visit({"relative_volume_change", "of the enclosed volume"}, self.relative_volume_change);
  }
};

/// A closed surface with about max_triangles triangles (at most, where the body allows it) by coarsened(): the shortest edges
/// go first, so that scans become even. No vertex moves further (rms) off the planes it stands for than a tenth of the wall;
/// that becomes less where the result would cut itself, and up to four times as much where the number is not reached.
/// @param surface  closed (check_closed_surface)
SurfaceMesh decimated_surface(const SurfaceMesh& surface, int max_triangles, SurfaceDecimation& report);

/// The same for a picture: whether the result cuts itself and how far it lies from the first is not looked at, which takes most of
/// the time. Not for a mesh.
SurfaceMesh drawn_surface(const SurfaceMesh& surface, int max_triangles);

}  // namespace klang::mesh
