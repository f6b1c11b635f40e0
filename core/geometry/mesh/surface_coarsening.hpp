#pragma once
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

struct CoarseningOptions {
  double edge_m = 0.0;        ///< wanted edge length, > 0; none becomes longer than 1.4 times that
  double tolerance_m = 0.0;   ///< rms distance of a vertex to the planes it stands for, >= 0
  int stop_at_triangles = 0;  ///< > 0: no further once there are no more than these
  void validate() const;      ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"edge_m", "Wanted length of an edge", above(0.0)}, self.edge_m);
    visit({"tolerance_m", "Root mean square distance of a vertex to the planes that it stands for", between(0.0, 1e9)},
          self.tolerance_m);
    visit({"stop_at_triangles", "No further once there are no more triangles; 0: no such limit", at_least(0.0)},
          self.stop_at_triangles);
  }
};

/// A coarser closed surface of the same shape and connection: edges are collapsed from the shortest up, each to the point
/// that lies best on the planes of all triangles it replaces (Garland and Heckbert 1997), as long as no triangle turns over
/// or becomes a sliver. Edges and corners of the body stay where they are to the tolerance; the result has straight
/// triangles and no unused vertices. Deterministic. Not checked for parts that come to cut each other: a tolerance of a
/// tenth of the wall keeps them apart, and checked_coarsened() makes sure.
/// @param planes_of_vertex  for a surface that is open at planes across x, y or z, one for each axis: bit 0, 1 or 2 of each
///                          vertex that lies on one; vertices stay on their planes
/// @param times_larger      of each vertex: edges there may be so many times longer; none: as long everywhere
SurfaceMesh coarsened(const SurfaceMesh& surface, const CoarseningOptions& options,
                      const std::vector<int>& planes_of_vertex = {}, const std::vector<double>& times_larger = {});

/// As coarsened; where the result cuts itself the tolerance is cut to a quarter and the work done again, up to three times,
/// then the surface as given (with straight triangles) is returned.
SurfaceMesh checked_coarsened(const SurfaceMesh& surface, CoarseningOptions options);

/// A tenth of the wall: the 10th percentile, over up to 400 triangles, of the way through the solid along the inward
/// normal, times 0.1.
double wall_tolerance_m(const SurfaceMesh& surface);

}  // namespace klang::mesh
