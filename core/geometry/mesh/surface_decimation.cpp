#include "core/geometry/mesh/surface_decimation.hpp"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/surface_coarsening.hpp"

namespace klang::mesh {
namespace {

/// Adds the distances of one surface's vertices from the other.
void add_distances(const SurfaceMesh& from, const SurfaceMesh& to, double& max_sq, double& sum_sq, double& n) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (Eigen::Index v = 0; v < to.vertices_m.rows(); ++v) points->InsertNextPoint(to.vertices_m.row(v).data());
  vtkNew<vtkCellArray> cells;
  for (Eigen::Index t = 0; t < to.triangles.rows(); ++t) {
    const vtkIdType corners[3] = {to.triangles(t, 0), to.triangles(t, 1), to.triangles(t, 2)};
    cells->InsertNextCell(3, corners);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  vtkNew<vtkStaticCellLocator> locator;
  locator->SetDataSet(data);
  locator->BuildLocator();
  std::vector<bool> used(static_cast<std::size_t>(from.vertices_m.rows()), false);
  for (const int v : from.triangles.reshaped()) used[static_cast<std::size_t>(v)] = true;
  for (Eigen::Index v = 0; v < from.vertices_m.rows(); ++v) {
    if (!used[static_cast<std::size_t>(v)]) continue;
    double nearest[3], distance_sq = 0.0;
    vtkIdType cell = -1;
    int sub_id = 0;
    locator->FindClosestPoint(from.vertices_m.row(v).data(), nearest, cell, sub_id, distance_sq);
    max_sq = std::max(max_sq, distance_sq);
    sum_sq += distance_sq;
    n += 1.0;
  }
}

bool is_sound(const SurfaceMesh& surface) {
  try {
    check_closed_surface(surface, "decimated surface");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

CoarseningOptions coarsening_to(const SurfaceMesh& surface, int max_triangles) {
  CoarseningOptions options;
  options.stop_at_triangles = max_triangles;
  // Twice the edge of as many equilateral triangles: collapses go by the shortest edge and stop at the number.
  options.edge_m = 2.0 * std::sqrt(4.0 / std::sqrt(3.0) * surface_area_m2(surface) / max_triangles);
  return options;
}

}  // namespace

SurfaceMesh decimated_surface(const SurfaceMesh& surface, int max_triangles, SurfaceDecimation& report) {
  const auto n_before = static_cast<int>(surface.triangles.rows());
  report = {n_before, n_before, 0.0, 0.0, 0.0};
  if (n_before <= max_triangles) return surface;
  CoarseningOptions options = coarsening_to(surface, max_triangles);
  const double tolerance_m = wall_tolerance_m(surface);
  SurfaceMesh best = surface;
  // A result that cuts itself needs a tighter tolerance, one with too many triangles a wider one.
  bool tighter = false;
  double factor = 1.0;
  for (int attempt = 0; attempt < 5; ++attempt) {
    options.tolerance_m = factor * tolerance_m;
    const SurfaceMesh result = coarsened(surface, options);
    const bool sound = is_sound(result);
    if (sound && result.triangles.rows() < best.triangles.rows()) best = result;
    if (best.triangles.rows() <= max_triangles || (sound && (tighter || factor > 2.0))) break;
    tighter = tighter || !sound;
    factor *= tighter ? 0.125 : 2.0;
  }
  report.n_faces_after = static_cast<int>(best.triangles.rows());
  double max_sq = 0.0, sum_sq = 0.0, n = 0.0;
  add_distances(surface, best, max_sq, sum_sq, n);
  add_distances(best, surface, max_sq, sum_sq, n);
  report.max_distance_m = std::sqrt(max_sq);
  report.rms_distance_m = std::sqrt(sum_sq / n);
  report.relative_volume_change = mass_properties(best).volume_m3 / mass_properties(surface).volume_m3 - 1.0;
  return best;
}

SurfaceMesh drawn_surface(const SurfaceMesh& surface, int max_triangles) {
  if (surface.triangles.rows() <= max_triangles) return surface;
  CoarseningOptions options = coarsening_to(surface, max_triangles);
  SurfaceMesh result = surface;
  options.tolerance_m = wall_tolerance_m(surface);
  for (int attempt = 0; attempt < 3 && result.triangles.rows() > max_triangles; ++attempt, options.tolerance_m *= 2.0)
    result = coarsened(surface, options);
  return result;
}

}  // namespace klang::mesh
