#include "core/physics/rigid/detail/convex_hull.hpp"

#include <LinearMath/btConvexHullComputer.h>

#include <array>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang::rigid::detail {

mesh::SurfaceMesh convex_hull(const Eigen::Matrix3Xd& corners_m) {
  btConvexHullComputer hull;
  hull.compute(corners_m.data(), static_cast<int>(3 * sizeof(double)), static_cast<int>(corners_m.cols()), 0.0, 0.0);
  std::vector<std::array<int, 3>> triangles;
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* first = &hull.edges[hull.faces[f]];
    for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != first->getSourceVertex();
         edge = edge->getNextEdgeOfFace()) {
      triangles.push_back({first->getSourceVertex(), edge->getSourceVertex(), edge->getTargetVertex()});
    }
  }
  if (triangles.size() < 4) throw InputError("convex part", "its corners span no volume");
  mesh::SurfaceMesh surface;
  surface.vertices_m.resize(hull.vertices.size(), 3);
  // The computer's own vertices lie on its grid of integers, 1e-4 of the size apart.
  for (int i = 0; i < hull.vertices.size(); ++i)
    surface.vertices_m.row(i) = corners_m.col(hull.original_vertex_index[i]).transpose();
  surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    surface.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
  }
  return surface;
}

}  // namespace klang::rigid::detail
