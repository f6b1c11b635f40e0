#include "core/physics/fracture/pattern/fragment_body.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/surface_coarsening.hpp"
#include "core/physics/rigid/convex_parts.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;

constexpr int kDirections = 200, kPartDirections = 60;
constexpr double kFacets = 0.005;    // of the piece's size: how far a round wall lies beside its facets
constexpr double kSliver = 0.75;     // of the median of a hollow body's own parts
constexpr double kOffPlanes = 1e-6;  // of the piece's size
constexpr double kLeastPart = 1e-6;  // of the piece's size: thinner parts do not collide

/// The corners that are farthest in some direction, in order.
/// @param nodes_m  one per row
rigid::ConvexPart own_hull(const mesh::Points& nodes_m, int n_directions) {
  std::vector<int> corners;
  const auto add_farthest = [&](const Vector3d& direction) {
    Eigen::Index farthest = 0;
    (nodes_m * direction).maxCoeff(&farthest);
    corners.push_back(static_cast<int>(farthest));
  };
  for (int axis = 0; axis < 3; ++axis) {
    add_farthest(Vector3d::Unit(axis));
    add_farthest(-Vector3d::Unit(axis));
  }
  for (int i = 0; i < n_directions; ++i) {  // evenly on the sphere: a spiral by the golden angle
    const double z = 1.0 - (2.0 * i + 1.0) / n_directions, turn = kPi * (3.0 - std::sqrt(5.0)) * i;
    add_farthest({std::sqrt(1.0 - z * z) * std::cos(turn), std::sqrt(1.0 - z * z) * std::sin(turn), z});
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  rigid::ConvexPart part{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(corners.size()))};
  for (std::size_t i = 0; i < corners.size(); ++i)
    part.corners_m.col(static_cast<Eigen::Index>(i)) = nodes_m.row(corners[i]).transpose();
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

double least_extent_m(const Eigen::Matrix3Xd& corners_m) {
  return (corners_m.rowwise().maxCoeff() - corners_m.rowwise().minCoeff()).minCoeff();
}

/// A part by the planes of its hull, each once.
struct PartPlanes {
  Eigen::Matrix3Xd normals;
  Eigen::VectorXd offsets_m;
  double over(const Vector3d& at) const { return (normals.transpose() * at - offsets_m).maxCoeff(); }
};

PartPlanes planes_of(const rigid::ConvexPart& part) {
  constexpr double kSamePlane = 1e-6;
  const mesh::SurfaceMesh hull = rigid::hull_of(part);
  const double size_m = (hull.vertices_m.colwise().maxCoeff() - hull.vertices_m.colwise().minCoeff()).norm();
  std::vector<Eigen::Vector4d> planes;
  for (Eigen::Index t = 0; t < hull.triangles.rows(); ++t) {
    const auto corner = [&](int c) -> Vector3d { return hull.vertices_m.row(hull.triangles(t, c)).transpose(); };
    const Vector3d area = (corner(1) - corner(0)).cross(corner(2) - corner(0)), normal = area.normalized();
    if (!(area.norm() > kSamePlane * size_m * size_m)) continue;
    const Eigen::Vector4d plane(normal.x(), normal.y(), normal.z(), normal.dot(corner(0)) / size_m);
    const bool known = std::any_of(planes.begin(), planes.end(),
                                   [&](const Eigen::Vector4d& other) { return (other - plane).norm() < kSamePlane; });
    if (!known) planes.push_back(plane);
  }
  PartPlanes result{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(planes.size())),
                    Eigen::VectorXd(static_cast<Eigen::Index>(planes.size()))};
  for (std::size_t i = 0; i < planes.size(); ++i) {
    result.normals.col(static_cast<Eigen::Index>(i)) = planes[i].head<3>();
    result.offsets_m[static_cast<Eigen::Index>(i)] = size_m * planes[i][3];
  }
  return result;
}

/// Of a hollow body's piece: of its elements that reach into each of the body's convex parts a hull, clipped by that part, so that it collides
/// only where the body did.
void divide_by_parts(const std::vector<PartPlanes>& parts, FragmentBody& body) {
  const mesh::TetMesh& mesh = body.mesh;
  const double size_m = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  for (const PartPlanes& part : parts) {
    // A corner of an element or its middle in the part, or as near as round walls lie beside their facets.
    const double near_m = kFacets * size_m;
    std::vector<char> inside(static_cast<std::size_t>(mesh.n_nodes()));
    for (int i = 0; i < mesh.n_nodes(); ++i)
      inside[static_cast<std::size_t>(i)] = part.over(mesh.nodes_m.row(i).transpose()) <= near_m;
    std::vector<int> nodes;
    for (int e = 0; e < mesh.n_elements(); ++e) {
      bool reaches = false;
      Vector3d centre = Vector3d::Zero();
      for (int c = 0; c < 4; ++c) {
        reaches = reaches || inside[static_cast<std::size_t>(mesh.elements(e, c))] != 0;
        centre += 0.25 * mesh.nodes_m.row(mesh.elements(e, c)).transpose();
      }
      if (!reaches && !(part.over(centre) <= 0.0)) continue;
      for (int c = 0; c < 4; ++c) nodes.push_back(mesh.elements(e, c));
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    if (nodes.size() < 4) continue;
    Eigen::Matrix3Xd corners = own_hull(mesh.nodes_m(nodes, Eigen::all), kPartDirections).corners_m;
    for (Eigen::Index p = 0; p < part.offsets_m.size() && corners.cols() > 0; ++p)
      corners = clipped_corners(corners, {part.normals.col(p), part.offsets_m[p]});
    if (!has_volume(corners, size_m)) continue;
    body.parts.push_back({std::move(corners)});
  }
}

/// Slivers, at a crack or where a body's parts are narrow, become one with the neighbour with which they bulge least, or do not collide where
/// each would bulge: a body may move by no more in a step than its thinnest part is thick.
void join_slivers(double thinnest_m, std::vector<rigid::ConvexPart>& parts) {
  constexpr double kBulge = 1.1;
  constexpr std::size_t kNearest = 8;
  const auto volume = [](const Eigen::Matrix3Xd& corners_m) {
    return mesh::mass_properties(rigid::hull_of({corners_m})).volume_m3;
  };
  const auto is_sliver = [&](const rigid::ConvexPart& part) { return least_extent_m(part.corners_m) < thinnest_m; };
  for (auto sliver = std::find_if(parts.begin(), parts.end(), is_sliver); sliver != parts.end() && parts.size() > 1;
       sliver = std::find_if(parts.begin(), parts.end(), is_sliver)) {
    const rigid::ConvexPart thin = std::move(*sliver);
    parts.erase(sliver);
    const Vector3d middle = thin.corners_m.rowwise().mean();
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < parts.size(); ++i)
      near.emplace_back((parts[i].corners_m.rowwise().mean() - middle).squaredNorm(), i);
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), kNearest));
    double least = kBulge;
    std::size_t with = 0;
    Eigen::Matrix3Xd joined;
    for (const auto& [distance, i] : near) {
      Eigen::Matrix3Xd both(3, thin.corners_m.cols() + parts[i].corners_m.cols());
      both << thin.corners_m, parts[i].corners_m;
      const double bulge = volume(both) / (volume(thin.corners_m) + volume(parts[i].corners_m));
      if (!(bulge < least)) continue;
      least = bulge;
      with = i;
      joined = std::move(both);
    }
    if (joined.cols() > 0) parts[with].corners_m = rigid::hull_of({joined}).vertices_m.transpose();
  }
}

/// Below which a piece's part is a sliver: three quarters of what half of the body's parts are thicker than.
double sliver_m(const std::vector<rigid::ConvexPart>& parts) {
  std::vector<double> extents_m;
  for (const rigid::ConvexPart& part : parts) extents_m.push_back(least_extent_m(part.corners_m));
  std::nth_element(extents_m.begin(), extents_m.begin() + static_cast<long>(extents_m.size() / 2), extents_m.end());
  return kSliver * extents_m[extents_m.size() / 2];
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
  std::vector<PartPlanes> hollow;
  if (!planes && parts.size() > 1)
    for (const rigid::ConvexPart& part : parts) hollow.push_back(planes_of(part));
  for (FragmentBody& body : bodies) {
    if (!hollow.empty()) {
      divide_by_parts(hollow, body);
      join_slivers(sliver_m(parts), body.parts);
    }
    if (body.parts.empty()) body.parts.push_back(own_hull(body.mesh.nodes_m, kDirections));
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
