#include "core/physics/fracture/pattern/fragment_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/surface_coarsening.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;

constexpr int kDirections = 200;
constexpr double kOffPlanes = 1e-6;  // of the piece's size
constexpr double kLeastPart = 1e-6;  // of the piece's size: thinner parts do not collide

/// The corners that are farthest in some direction, in order.
rigid::ConvexPart own_hull(const mesh::TetMesh& mesh) {
  std::vector<int> corners;
  const auto add_farthest = [&](const Vector3d& direction) {
    Eigen::Index farthest = 0;
    (mesh.nodes_m * direction).maxCoeff(&farthest);
    corners.push_back(static_cast<int>(farthest));
  };
  for (int axis = 0; axis < 3; ++axis) {
    add_farthest(Vector3d::Unit(axis));
    add_farthest(-Vector3d::Unit(axis));
  }
  for (int i = 0; i < kDirections; ++i) {  // evenly on the sphere: a spiral by the golden angle
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, turn = kPi * (3.0 - std::sqrt(5.0)) * i;
    add_farthest({std::sqrt(1.0 - z * z) * std::cos(turn), std::sqrt(1.0 - z * z) * std::sin(turn), z});
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  rigid::ConvexPart part{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(corners.size()))};
  for (std::size_t i = 0; i < corners.size(); ++i)
    part.corners_m.col(static_cast<Eigen::Index>(i)) = mesh.nodes_m.row(corners[i]).transpose();
  return part;
}

bool has_volume(const Eigen::Matrix3Xd& corners_m, double size_m) {
  if (corners_m.cols() < 4) return false;
  const Eigen::Matrix3Xd from = corners_m.colwise() - corners_m.rowwise().mean();
  const Eigen::Matrix3d spread = from * from.transpose() / static_cast<double>(corners_m.cols());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues()[0] >
         kLeastPart * kLeastPart * size_m * size_m;
}

/// The fragment whose element of that region is nearest.
int owner_of(const Fragments& fragments, int region, const Vector3d& at) {
  const mesh::TetMesh& mesh = fragments.cut.mesh;
  int owner = -1;
  double nearest = HUGE_VAL;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    if (fragments.cut.region[e] != region) continue;
    Vector3d centre = Vector3d::Zero();
    for (int c = 0; c < 4; ++c) centre += 0.25 * mesh.nodes_m.row(mesh.elements(e, c)).transpose();
    const double distance = (centre - at).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      owner = fragments.fragment[e];
    }
  }
  return owner;
}

void clip_parts(const FracturePattern& pattern, const std::vector<rigid::ConvexPart>& parts,
                std::vector<FragmentBody>& bodies) {
  const mesh::TetMesh& mesh = pattern.fragments.cut.mesh;
  const double size_m = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  for (std::size_t region = 0; region < pattern.half_spaces.size(); ++region)
    for (const rigid::ConvexPart& part : parts) {
      Eigen::Matrix3Xd corners = part.corners_m;
      for (const HalfSpace& half_space : pattern.half_spaces[region]) corners = clipped_corners(corners, half_space);
      if (!has_volume(corners, size_m)) continue;
      const int owner = owner_of(pattern.fragments, static_cast<int>(region), corners.rowwise().mean());
      if (owner >= 0) bodies[owner].parts.push_back({std::move(corners)});
    }
}

}  // namespace

std::vector<FragmentBody> fragment_bodies(const FracturePattern& pattern, double density_kg_m3) {
  std::vector<FragmentBody> bodies(static_cast<std::size_t>(pattern.fragments.n_fragments));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    FragmentBody& body = bodies[i];
    body.mesh = fragment_mesh(pattern.fragments, static_cast<int>(i), &body.element);
    for (int& e : body.element) e = pattern.fragments.cut.element[e];
    const mesh::MassProperties mass = mesh::mass_properties(body.mesh);
    body.volume_m3 = mass.volume_m3;
    body.mass_kg = density_kg_m3 * mass.volume_m3;
    body.centre_m = mass.centre_m;
    body.inertia_kg_m2 = density_kg_m3 * mass.inertia_m5;
  }
  return bodies;
}

void give_parts(const FracturePattern& pattern, const std::vector<rigid::ConvexPart>& parts,
                std::vector<FragmentBody>& bodies) {
  const bool planes = std::any_of(pattern.half_spaces.begin(), pattern.half_spaces.end(),
                                  [](const auto& list) { return !list.empty(); });
  if (planes && !parts.empty()) clip_parts(pattern, parts, bodies);
  for (FragmentBody& body : bodies) {
    if (body.parts.empty()) body.parts.push_back(own_hull(body.mesh));
    rigid::RigidBodySpec hulls;
    hulls.parts = body.parts;
    rigid::set_mass_from_parts(hulls, 1.0);
    body.concavity = std::max(0.0, 1.0 - body.volume_m3 / hulls.mass_kg);
  }
}

std::vector<FragmentBody> fragment_bodies(const FracturePattern& pattern, const std::vector<rigid::ConvexPart>& parts,
                                          double density_kg_m3) {
  std::vector<FragmentBody> bodies = fragment_bodies(pattern, density_kg_m3);
  give_parts(pattern, parts, bodies);
  return bodies;
}

mesh::SurfaceMesh fragment_surface(const FragmentBody& piece, double edge_m) {
  const double size_m = (piece.mesh.nodes_m.colwise().maxCoeff() - piece.mesh.nodes_m.colwise().minCoeff()).norm();
  mesh::CoarseningOptions options;
  options.edge_m = edge_m;
  options.tolerance_m = kOffPlanes * size_m;
  return mesh::checked_coarsened(mesh::boundary_surface(piece.mesh), options);
}

}  // namespace klang::fracture
