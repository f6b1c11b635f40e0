#pragma once
#include <cstdint>
#include <string>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// What was mended in a surface that another program wrote, counted.
struct SurfaceRepairs {
  int n_unused_vertices = 0, n_welded_vertices = 0;
  double weld_distance_m = 0.0;
  int n_collapsed_faces = 0, n_duplicate_faces = 0, n_recut_faces = 0, n_turned_faces = 0, n_turned_parts = 0;
  std::int64_t n_extra_bytes = 0;  ///< in the file; the reader's to count

  bool any() const;
  /// "16 repeated corners welded, 1 facet turned"; empty where nothing was mended.
  std::string text() const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_unused_vertices", "left out: no face has them"}, self.n_unused_vertices);
    visit({"n_welded_vertices", "repeated corners joined with the first at their place"}, self.n_welded_vertices);
    visit({"weld_distance_m", "the furthest that one of them was moved"}, self.weld_distance_m);
    visit({"n_collapsed_faces", "left out: two of their corners are one"}, self.n_collapsed_faces);
    visit({"n_duplicate_faces", "left out: another face has the same corners"}, self.n_duplicate_faces);
    visit({"n_recut_faces", "without height, cut anew together with the neighbour at their longest edge"},
          self.n_recut_faces);
    visit({"n_turned_faces", "wound against their neighbours"}, self.n_turned_faces);
    visit({"n_turned_parts", "closed parts that were inside out"}, self.n_turned_parts);
    visit({"n_extra_bytes", "behind the last facet of the file, left out"}, self.n_extra_bytes);
  }
};

/// The surface as other programs read it, with no more mended than it takes. Corners are joined only while edges stay open:
/// first those that agree to the last bit, then those within 1e-6 of the surface's size (or four last places of 32-bit
/// coordinates, where these are coarser). Collapsed faces and repeated ones are left out; faces without height are cut anew
/// with their neighbour; faces wound against most of their part are turned, and parts that are inside out as a whole (a
/// hollow only together with what it lies in: alone it may be meant as a body). What stays open comes back as it is, for
/// check_closed_surface() to refuse. A surface that needs nothing comes back bit for bit.
/// @throws InputError for an index out of range or a vertex that is not finite
SurfaceMesh repaired_surface(const SurfaceMesh& surface, const std::string& name, SurfaceRepairs& repairs);

}  // namespace klang::mesh
