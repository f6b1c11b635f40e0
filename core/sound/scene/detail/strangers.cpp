#include "core/sound/scene/detail/strangers.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace klang::scene::detail {
namespace {

using Eigen::Vector3d;

/// Corners of the surface and middles of its triangles that lie in a box, in the world, by their first coordinate.
std::vector<Vector3d> places_in(const Eigen::AlignedBox3d& box, const ModalBody& body) {
  std::vector<Vector3d> found;
  const Eigen::Matrix3d turn = body.turn.toRotationMatrix();
  const auto add = [&](const Vector3d& own) {
    const Vector3d x = body.centre_m + turn * own;
    if (box.contains(x)) found.push_back(x);
  };
  const auto vertex = [&](int i) -> Vector3d {
    Vector3d own = body.surface.vertices_m.row(i).transpose();
    if (body.modes.z.size() > 0) own += body.surface_shapes.middleRows(3 * i, 3) * body.modes.z;
    return own;
  };
  for (const ModalPlace& place : body.places) {
    Vector3d own = place.rest_m;
    if (body.modes.z.size() > 0) own += place.shape * body.modes.z;
    add(own);
  }
  for (Eigen::Index t = 0; t < body.surface.triangles.rows(); ++t)
    add((vertex(body.surface.triangles(t, 0)) + vertex(body.surface.triangles(t, 1)) +
         vertex(body.surface.triangles(t, 2))) /
        3.0);
  std::sort(found.begin(), found.end(), [](const Vector3d& a, const Vector3d& b) { return a.x() < b.x(); });
  return found;
}

bool holds_one_of(const fracture::CrackMesh& mesh, int element, const std::vector<Vector3d>& places) {
  const auto nodes = mesh.nodes_of(element);
  Eigen::AlignedBox3d box;
  for (const int node : nodes) box.extend(mesh.place_m[static_cast<std::size_t>(node)]);
  auto place = std::lower_bound(places.begin(), places.end(), box.min().x(),
                                [](const Vector3d& a, double x) { return a.x() < x; });
  for (; place != places.end() && place->x() <= box.max().x(); ++place) {
    if (!box.contains(*place)) continue;
    const Vector3d& origin = mesh.place_m[static_cast<std::size_t>(nodes[0])];
    Eigen::Matrix3d edges;
    for (int c = 0; c < 3; ++c)
      edges.col(c) = mesh.place_m[static_cast<std::size_t>(nodes[static_cast<std::size_t>(c + 1)])] - origin;
    const Vector3d share = edges.inverse() * (*place - origin);
    if (share.minCoeff() >= 0.0 && share.sum() <= 1.0) return true;
  }
  return false;
}

}  // namespace

bool meet(const ModalBody& body, const fracture::CrackMesh& mesh) {
  Eigen::AlignedBox3d box;
  bool near = false;
  for (const Vector3d& x : mesh.place_m) {
    box.extend(x);
    if (!body.is_near(x, 0.0)) continue;
    near = true;
    if (body.depth_of(x)) return true;
  }
  const double reach_m = body.reach_m + body.bent_m();
  if (!near && box.exteriorDistance(body.centre_m) > reach_m) return false;
  const std::vector<Vector3d> places = places_in(box, body);
  if (places.empty()) return false;
  for (int e = 0; e < mesh.n_elements(); ++e)
    if (holds_one_of(mesh, e, places)) return true;
  return false;
}

}  // namespace klang::scene::detail
