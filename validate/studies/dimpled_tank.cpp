#include "validate/studies/dimpled_tank.hpp"

#include <cmath>
#include <vector>

namespace klang::validate::detail {

double DimpledTank::height_m(double x, double y) const {
  const double t = (x * x + y * y) / (width_m * width_m);
  return -dimple_m * (1.0 - t) * std::exp(-t);
}

bool DimpledTank::inside(const Eigen::Vector3d& x_m) const {
  return std::abs(x_m.x()) < 0.5 * side_m && std::abs(x_m.y()) < 0.5 * side_m && x_m.z() > -depth_m &&
         x_m.z() < height_m(x_m.x(), x_m.y());
}

bubble::BoundaryMesh DimpledTank::mesh(double h_m) const {
  bubble::BoundaryMesh mesh;
  mesh.name = "dimpled tank";
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  const double a = 0.5 * side_m;
  const int n = static_cast<int>(std::lround(side_m / h_m)), n_down = static_cast<int>(std::lround(depth_m / h_m));
  // Patches with u x v outwards; the height of the top is put on vertices at z = 0, those of the walls' upper edges too.
  const auto patch = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v, int nu,
                         int nv, int region) {
    const int first = static_cast<int>(vertices.size());
    for (int j = 0; j <= nv; ++j)
      for (int i = 0; i <= nu; ++i) {
        Eigen::Vector3d x = corner + u * i / nu + v * j / nv;
        if (std::abs(x.z()) < 1e-12) x.z() = height_m(x.x(), x.y());
        vertices.push_back(x);
      }
    for (int j = 0; j < nv; ++j)
      for (int i = 0; i < nu; ++i) {
        const int p = first + j * (nu + 1) + i, q = p + 1, r = p + nu + 1, s = r + 1;
        if ((i + j) % 2 == 0) {
          triangles.emplace_back(p, q, s);
          triangles.emplace_back(p, s, r);
        } else {
          triangles.emplace_back(p, q, r);
          triangles.emplace_back(q, s, r);
        }
        mesh.region.insert(mesh.region.end(), 2, region);
      }
  };
  const Eigen::Vector3d x(side_m, 0, 0), y(0, side_m, 0), z(0, 0, depth_m), floor(-a, -a, -depth_m);
  patch({-a, -a, 0}, x, y, n, n, 0);
  patch(floor, y, x, n, n, 1);
  patch(floor, x, z, n, n_down, 1);
  patch(floor + y, z, x, n_down, n, 1);
  patch(floor, z, y, n_down, n, 1);
  patch(floor + x, y, z, n, n_down, 1);
  mesh.surface.vertices_m.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    mesh.surface.vertices_m.row(static_cast<Eigen::Index>(i)) = vertices[i].transpose();
  mesh.surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    mesh.surface.triangles.row(static_cast<Eigen::Index>(i)) = triangles[i].transpose();
  return mesh;
}

}  // namespace klang::validate::detail
