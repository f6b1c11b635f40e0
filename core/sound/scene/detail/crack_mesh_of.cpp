#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "core/foundation/base/errors.hpp"
#include "core/sound/scene/detail/deforming_body.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSmoothFace = 0.9;  ///< cosine to the mean normal: less is an edge
constexpr double kSamePlace = 1e-9;  ///< of the body's size
constexpr double kPerCube = 6.0;     ///< elements in a cube of max_edge_m, a little less than meshes of boxes have

std::size_t row_of(int i) { return static_cast<std::size_t>(i); }

InputError too_many(const SceneBody& body, const std::string& n) {
  return InputError(body.place + ": max_edge_m", "gives too many elements to be stepped", n,
                    "up to " + std::to_string(kMostElements) + " of a cracking body");
}

/// What is beyond doubt, without the time and memory that the mesh itself would need.
void refuse_too_many(const SceneBody& body) {
  if (!body.shape || !(body.max_edge_m > 0.0)) return;
  const double n = kPerCube * mesh::shape_volume_m3(*body.shape) / std::pow(body.max_edge_m, 3);
  if (!(n <= 2.0 * kMostElements)) throw too_many(body, "about " + to_text(std::round(n)));
}

/// Nodes whose place another node has: those of the two lips of a slit, which part where only one of them moves.
std::vector<bool> twins_of(const mesh::TetMesh& mesh) {
  const double grid_m = kSamePlace * (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  std::vector<std::pair<std::array<std::int64_t, 3>, int>> places;
  for (int i = 0; i < mesh.n_nodes(); ++i)
    places.push_back({{std::llround(mesh.nodes_m(i, 0) / grid_m), std::llround(mesh.nodes_m(i, 1) / grid_m),
                       std::llround(mesh.nodes_m(i, 2) / grid_m)},
                      i});
  std::sort(places.begin(), places.end());
  std::vector<bool> is_twin(places.size(), false);
  for (std::size_t k = 1; k < places.size(); ++k)
    if (places[k].first == places[k - 1].first)
      is_twin[row_of(places[k].second)] = is_twin[row_of(places[k - 1].second)] = true;
  return is_twin;
}

}  // namespace

FittedFrame fitted_frame(const fracture::CrackMesh& mesh, const std::vector<int>& nodes) {
  FittedFrame frame;
  Vector3d rest = Vector3d::Zero(), place = Vector3d::Zero(), momentum = Vector3d::Zero(), spin = Vector3d::Zero();
  for (const int i : nodes) {
    const double mass = mesh.mass_kg_of[row_of(i)];
    frame.mass_kg += mass;
    rest += mass * mesh.rest_m[row_of(i)];
    place += mass * mesh.place_m[row_of(i)];
    momentum += mass * mesh.velocity_m_s[row_of(i)];
  }
  rest /= frame.mass_kg;
  place /= frame.mass_kg;
  Matrix3d moment = Matrix3d::Zero(), inertia = Matrix3d::Zero();
  for (const int i : nodes) {
    const double mass = mesh.mass_kg_of[row_of(i)];
    const Vector3d arm = mesh.place_m[row_of(i)] - place;
    moment += mass * arm * (mesh.rest_m[row_of(i)] - rest).transpose();
    inertia += mass * (arm.squaredNorm() * Matrix3d::Identity() - arm * arm.transpose());
    spin += mass * arm.cross(mesh.velocity_m_s[row_of(i)] - momentum / frame.mass_kg);
  }
  const Eigen::JacobiSVD<Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  const Matrix3d turn = svd.matrixU() * flip * svd.matrixV().transpose();
  const Eigen::Quaterniond q(turn);
  frame.pose.position_m = place - turn * rest;
  frame.pose.orientation_wxyz = {q.w(), q.x(), q.y(), q.z()};
  frame.state.position_m = place;
  frame.state.orientation_wxyz = frame.pose.orientation_wxyz;
  frame.state.velocity_m_s = momentum / frame.mass_kg;
  frame.state.angular_velocity_rad_s =
      inertia.determinant() > 0.0 ? Vector3d(inertia.ldlt().solve(spin)) : Vector3d::Zero();
  return frame;
}

mesh::TetMesh crack_mesh_of(const SceneBody& body, std::uint64_t seed, const SceneNotes& notes, Monitor& monitor) {
  refuse_too_many(body);
  mesh::TetMesh mesh = mesh::to_linear(mesh_of(body, notes, monitor));
  if (mesh.n_elements() > kMostElements) throw too_many(body, std::to_string(mesh.n_elements()));
  const mesh::SurfaceMesh surface = mesh::boundary_surface(mesh);
  // Nodes of faces move along them, nodes of edges and of slits not at all.
  const std::vector<bool> is_twin = twins_of(mesh);
  std::vector<std::vector<Vector3d>> normals(row_of(mesh.n_nodes()));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto corner = [&](int c) -> Vector3d { return mesh.nodes_m.row(surface.triangles(t, c)).transpose(); };
    const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (int c = 0; c < 3; ++c) normals[row_of(surface.triangles(t, c))].push_back(normal);
  }
  std::vector<double> shortest(row_of(mesh.n_nodes()), HUGE_VAL);
  std::vector<std::vector<int>> star(row_of(mesh.n_nodes()));
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int a = 0; a < 4; ++a) {
      star[row_of(mesh.elements(e, a))].push_back(e);
      for (int b = 0; b < 4; ++b)
        if (a != b)
          shortest[row_of(mesh.elements(e, a))] =
              std::min(shortest[row_of(mesh.elements(e, a))],
                       (mesh.nodes_m.row(mesh.elements(e, a)) - mesh.nodes_m.row(mesh.elements(e, b))).norm());
    }
  const auto volume = [&](int e) {
    Matrix3d edges;
    for (int k = 0; k < 3; ++k)
      edges.col(k) = (mesh.nodes_m.row(mesh.elements(e, k + 1)) - mesh.nodes_m.row(mesh.elements(e, 0))).transpose();
    return edges.determinant();
  };
  std::mt19937_64 random(seed);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    Eigen::RowVector3d move;
    for (int axis = 0; axis < 3; ++axis)
      move[axis] = 0.2 * (static_cast<double>(random() >> 11) * 0x1.0p-53 - 0.5) * shortest[row_of(i)];
    if (is_twin[row_of(i)]) continue;
    if (!normals[row_of(i)].empty()) {
      Vector3d mean = Vector3d::Zero();
      for (const Vector3d& normal : normals[row_of(i)]) mean += normal;
      mean.normalize();
      bool is_face = true;
      for (const Vector3d& normal : normals[row_of(i)]) is_face = is_face && normal.dot(mean) > kSmoothFace;
      if (!is_face) continue;
      move -= move.dot(mean) * mean.transpose();
    }
    std::vector<double> before;
    for (const int e : star[row_of(i)]) before.push_back(volume(e));
    mesh.nodes_m.row(i) += move;
    for (std::size_t k = 0; k < before.size(); ++k)
      if (!(volume(star[row_of(i)][k]) >= 0.5 * before[k])) {
        mesh.nodes_m.row(i) -= move;
        break;
      }
  }
  return mesh;
}

}  // namespace klang::scene::detail
