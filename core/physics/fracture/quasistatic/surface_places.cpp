#include "core/physics/fracture/quasistatic/surface_places.hpp"

#include <Eigen/LU>
#include <cmath>
#include <map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/surface_point.hpp"

namespace klang::fracture {
namespace {

constexpr int kNewtonSteps = 20;
constexpr double kNoWeight = 1e-13;  // a place at a node needs no other

using Triangle = Eigen::Matrix<double, 3, 6>;

Eigen::Matrix<double, 6, 1> functions(const Eigen::Vector3d& l) {
  Eigen::Matrix<double, 6, 1> n;
  for (int c = 0; c < 3; ++c) {
    n[c] = l[c] * (2.0 * l[c] - 1.0);
    n[3 + c] = 4.0 * l[c] * l[(c + 1) % 3];
  }
  return n;
}

/// By l1 and l2, with l0 = 1 - l1 - l2.
Eigen::Matrix<double, 6, 2> derivatives(const Eigen::Vector3d& l) {
  Eigen::Matrix<double, 6, 3> by_l = Eigen::Matrix<double, 6, 3>::Zero();
  for (int c = 0; c < 3; ++c) {
    by_l(c, c) = 4.0 * l[c] - 1.0;
    by_l(3 + c, c) = 4.0 * l[(c + 1) % 3];
    by_l(3 + c, (c + 1) % 3) = 4.0 * l[c];
  }
  return by_l.rightCols<2>().colwise() - by_l.col(0);
}

/// Into the triangle, along no particular way: the rest of the place's distance is told to the caller.
Eigen::Vector3d clamped(const Eigen::Vector3d& l) {
  const Eigen::Vector3d inside = l.cwiseMax(0.0);
  return inside / inside.sum();
}

/// The nearest point of a curved triangle by Gauss-Newton from that of its plane.
Eigen::Vector3d nearest_on_curved(const Triangle& x, const Eigen::Vector3d& point, Eigen::Vector3d l) {
  Eigen::Vector3d best = l;
  double least = (x * functions(l) - point).norm();
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Eigen::Matrix<double, 3, 2> tangents = x * derivatives(l);
    const Eigen::Vector2d move =
        (tangents.transpose() * tangents).inverse() * (tangents.transpose() * (point - x * functions(l)));
    if (!move.allFinite()) break;
    l = clamped(l + Eigen::Vector3d(-move.sum(), move[0], move[1]));
    const double distance = (x * functions(l) - point).norm();
    if (distance < least) least = distance, best = l;
    if (move.norm() <= 1e-14) break;
  }
  return best;
}

/// Leaves out weights that are round-off; the others still add up to 1.
void drop_round_off(SurfacePlace& place) {
  const double all = place.weights.sum();
  std::vector<int> nodes;
  std::vector<double> weights;
  double kept = 0.0;
  for (std::size_t k = 0; k < place.nodes.size(); ++k) {
    const double weight = place.weights[static_cast<Eigen::Index>(k)] / all;
    if (std::abs(weight) <= kNoWeight) continue;
    nodes.push_back(place.nodes[k]);
    weights.push_back(weight);
    kept += weight;
  }
  place.nodes = std::move(nodes);
  place.weights = Eigen::Map<const Eigen::VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size())) / kept;
}

}  // namespace

SurfacePlaces::SurfacePlaces(const mesh::TetMesh& mesh) {
  if (mesh.n_elements() == 0) throw InputError("mesh", "has no elements");
  surface_ = mesh::boundary_surface(mesh);
  tolerance_m_ = kTolerance * (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
}

SurfacePlace SurfacePlaces::at(const Eigen::Vector3d& place_m) const {
  mesh::SurfacePoint point = mesh::nearest_surface_point(surface_, place_m);
  SurfacePlace place{point.nodes, point.weights, Eigen::Vector3d::Zero(), 0.0};
  if (point.nodes.size() == 6) {
    Triangle x;
    for (int k = 0; k < 6; ++k)
      x.col(k) = surface_.vertices_m.row(point.nodes[static_cast<std::size_t>(k)]).transpose();
    place.weights = functions(nearest_on_curved(x, place_m, point.barycentric));
  }
  drop_round_off(place);
  for (std::size_t k = 0; k < place.nodes.size(); ++k)
    place.place_m += place.weights[static_cast<Eigen::Index>(k)] * surface_.vertices_m.row(place.nodes[k]).transpose();
  place.distance_m = (place.place_m - place_m).norm();
  if (!(place.distance_m <= tolerance_m_))
    throw InputError("place " + to_text(place_m[0]) + "," + to_text(place_m[1]) + "," + to_text(place_m[2]),
                     "is not on the body's surface", to_text(place.distance_m) + " m off",
                     "up to " + to_text(tolerance_m_) + " m, 1 % of the body's diagonal");
  return place;
}

std::vector<NodeForce> SurfacePlaces::at_nodes(const std::vector<PointForce>& forces) const {
  std::map<int, Eigen::Vector3d> sum;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const std::string number = "force " + std::to_string(i + 1);
    if (!forces[i].place_m.allFinite() || !forces[i].force_n.allFinite()) throw InputError(number, "is not finite");
    const SurfacePlace place = at(forces[i].place_m);
    for (std::size_t k = 0; k < place.nodes.size(); ++k) {
      const Eigen::Vector3d share = place.weights[static_cast<Eigen::Index>(k)] * forces[i].force_n;
      const auto [entry, is_new] = sum.try_emplace(place.nodes[k], share);
      if (!is_new) entry->second += share;
    }
  }
  std::vector<NodeForce> nodes;
  for (const auto& [node, force] : sum) nodes.push_back({node, force});
  return nodes;
}

Eigen::VectorXd nodal_force_n(const mesh::TetMesh& mesh, const std::vector<NodeForce>& forces) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(3 * mesh.n_nodes());
  for (const NodeForce& at : forces) {
    KLANG_CHECK(at.node >= 0 && at.node < mesh.n_nodes(), "a node of the mesh");
    all.segment<3>(3 * static_cast<Eigen::Index>(at.node)) += at.force_n;
  }
  return all;
}

}  // namespace klang::fracture
