#include "core/geometry/shapes/detail/revolution.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"

namespace klang::mesh::detail {
namespace {

/// Numbers the nodes of the swept body on demand: flat point (corner or mid-point of a flat edge) at
/// half-layer. Points on the axis are the same in every layer.
class SweptNodes {
 public:
  SweptNodes(const FlatMesh& flat, int n_around) : flat_points_(flat.points_m), n_half_layers_(2 * n_around) {}

  int corner(int point, int half_layer) { return node(point, half_layer); }

  /// Mid-node of the edge between two swept corners. An edge that ends on the axis lies in the plane of its
  /// other end.
  int mid(int a, int layer_a, int b, int layer_b) {
    int half_layer = (layer_a + layer_b) / 2;
    if (on_axis(a)) half_layer = layer_b;
    if (on_axis(b)) half_layer = layer_a;
    return node(a == b ? a : mid_point(a, b), half_layer);
  }

  bool on_axis(int point) const { return flat_points_[point].x() == 0.0; }
  std::vector<Eigen::Vector3d> nodes_m;

 private:
  int mid_point(int a, int b) {
    const std::array<int, 2> key{std::min(a, b), std::max(a, b)};
    const auto [it, added] = mid_points_.try_emplace(key, static_cast<int>(flat_points_.size()));
    if (added) flat_points_.push_back(0.5 * (flat_points_[a] + flat_points_[b]));
    return it->second;
  }

  int node(int point, int half_layer) {
    const int layer = on_axis(point) ? 0 : half_layer % n_half_layers_;
    const auto [it, added] = index_.try_emplace({layer, point}, static_cast<int>(nodes_m.size()));
    if (added) {
      const double angle = 2.0 * kPi * layer / n_half_layers_;
      const Eigen::Vector2d& p = flat_points_[point];
      nodes_m.emplace_back(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
    }
    return it->second;
  }

  std::vector<Eigen::Vector2d> flat_points_;
  int n_half_layers_;
  std::map<std::array<int, 2>, int> mid_points_;
  std::map<std::array<int, 2>, int> index_;
};

}  // namespace

TetMesh mesh_revolution(const Profile& profile, const std::array<int, 3>& counts, int order) {
  const int n_around = std::max(6, counts[0]);
  Eigen::Vector2d low = profile.points_m[0], high = low;
  for (const Eigen::Vector2d& point : profile.points_m) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  FlatMesh flat = mesh_profile(profile, (high - low).maxCoeff() / std::max(1, counts[1]));
  for (int level = 0; level < counts[2]; ++level) {
    check_element_count(12.0 * static_cast<double>(flat.triangles.size()) * n_around);
    flat = refined(flat);
  }
  check_element_count(3.0 * static_cast<double>(flat.triangles.size()) * n_around);

  // A prism over a triangle with corners in rising order a < b < c falls into three tetrahedra; neighbours
  // share the diagonal from the lower corner below to the higher one above. On the axis corners coincide and
  // some vanish.
  struct End {
    int point, layer;
  };
  SweptNodes nodes(flat, n_around);
  std::vector<std::array<int, 10>> rows;
  for (int sector = 0; sector < n_around; ++sector)
    for (std::array<int, 3> t : flat.triangles) {
      std::sort(t.begin(), t.end());
      const int below = 2 * sector, above = below + 2;
      const std::array<std::array<End, 4>, 3> tets{{{{{t[0], below}, {t[1], below}, {t[2], below}, {t[2], above}}},
                                                    {{{t[0], below}, {t[1], below}, {t[1], above}, {t[2], above}}},
                                                    {{{t[0], below}, {t[0], above}, {t[1], above}, {t[2], above}}}}};
      for (std::array<End, 4> tet : tets) {
        std::array<int, 4> corner;
        for (int c = 0; c < 4; ++c) corner[c] = nodes.corner(tet[c].point, tet[c].layer);
        bool collapsed = false;
        for (const auto& edge : kTetEdges) collapsed |= corner[edge[0]] == corner[edge[1]];
        if (collapsed) continue;
        const Eigen::Vector3d p0 = nodes.nodes_m[corner[0]];
        const double det =
            (nodes.nodes_m[corner[1]] - p0).dot((nodes.nodes_m[corner[2]] - p0).cross(nodes.nodes_m[corner[3]] - p0));
        if (det < 0.0) {
          std::swap(tet[1], tet[2]);
          std::swap(corner[1], corner[2]);
        }
        if (!(std::abs(det) > 0.0))
          throw InputError(profile.name, "element without volume", std::to_string(rows.size()));
        std::array<int, 10> row{};
        std::copy(corner.begin(), corner.end(), row.begin());
        if (order == 2)
          for (int e = 0; e < 6; ++e) {
            const End& a = tet[kTetEdges[e][0]];
            const End& b = tet[kTetEdges[e][1]];
            row[4 + e] = nodes.mid(a.point, a.layer, b.point, b.layer);
          }
        rows.push_back(row);
      }
    }

  TetMesh mesh;
  mesh.nodes_m.resize(static_cast<Eigen::Index>(nodes.nodes_m.size()), 3);
  for (std::size_t i = 0; i < nodes.nodes_m.size(); ++i)
    mesh.nodes_m.row(static_cast<Eigen::Index>(i)) = nodes.nodes_m[i];
  mesh.elements.resize(static_cast<Eigen::Index>(rows.size()), order == 2 ? 10 : 4);
  for (std::size_t e = 0; e < rows.size(); ++e)
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) mesh.elements(static_cast<Eigen::Index>(e), c) = rows[e][c];

  const SurfaceMesh surface = boundary_surface(mesh);
  std::vector<char> on_surface(mesh.n_nodes(), 0);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (Eigen::Index c = 0; c < surface.triangles.cols(); ++c) on_surface[surface.triangles(t, c)] = 1;
  const double tolerance_m = 1e-9 * (high - low).maxCoeff();
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    if (!on_surface[i]) continue;
    mesh.node_sets["surface"].push_back(i);
    if (mesh.nodes_m(i, 2) <= low.y() + tolerance_m) mesh.node_sets["z_min"].push_back(i);
    if (mesh.nodes_m(i, 2) >= high.y() - tolerance_m) mesh.node_sets["z_max"].push_back(i);
  }
  return mesh;
}

}  // namespace klang::mesh::detail
