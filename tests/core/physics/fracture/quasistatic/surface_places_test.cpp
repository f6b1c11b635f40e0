#include "core/physics/fracture/quasistatic/surface_places.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang::fracture;
using Eigen::Vector3d;
using klang::InputError;
using klang::mesh::TetMesh;
using klang::test::box_mesh;

void expect_exact_resultants(const TetMesh& mesh, const std::vector<PointForce>& forces, double tolerance_m) {
  const SurfacePlaces surface(mesh);
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero(), wanted_force = Vector3d::Zero(),
           wanted_moment = Vector3d::Zero();
  double size = 0.0;
  for (const NodeForce& at : surface.at_nodes(forces)) {
    force += at.force_n;
    moment += Vector3d(mesh.nodes_m.row(at.node).transpose()).cross(at.force_n);
  }
  for (const PointForce& wanted : forces) {
    wanted_force += wanted.force_n;
    wanted_moment += wanted.place_m.cross(wanted.force_n);
    size += wanted.force_n.norm();
  }
  EXPECT_LE((force - wanted_force).norm(), 1e-13 * size);
  EXPECT_LE((moment - wanted_moment).norm(), (tolerance_m + 1e-14) * size);
}

TEST(SurfacePlaces, ForceAndMomentAreExactOnFlatSides) {
  for (const int order : {1, 2})
    expect_exact_resultants(
        box_mesh(0.1, 0.05, 0.02, 3, 2, 1, order),
        {{{0.013, 0.021, 0.02}, {1, 2, -3}}, {{0.1, 0.049, 0.001}, {-5, 0, 1}}, {{0, 0, 0}, {0, 7, 0}}}, 0.0);
}

TEST(SurfacePlaces, CurvedSidesAreTakenAsTheyAre) {
  const TetMesh ball = klang::mesh::mesh_shape({"sphere", {{"radius_m", 0.05}}, {}});
  const SurfacePlaces surface(ball);
  for (const Vector3d& n : {Vector3d(1, 2, 3).normalized(), Vector3d(-0.3, 0.9, 0.1).normalized()}) {
    const SurfacePlace place = surface.at(0.05 * n);
    EXPECT_LE(place.distance_m, 1e-4 * 0.05);  // what quadratic sides are off the sphere
    EXPECT_LE(std::abs(place.weights.sum() - 1.0), 1e-14);
  }
  expect_exact_resultants(ball, {{0.05 * Vector3d(1, 2, 3).normalized(), {0, 0, 1}}}, 1e-4 * 0.05);
}

TEST(SurfacePlaces, PlaceAtANodeIsThatNodeAlone) {
  for (const int order : {1, 2}) {
    const TetMesh mesh = box_mesh(0.1, 0.05, 0.02, 3, 2, 1, order);
    const SurfacePlace place = SurfacePlaces(mesh).at(mesh.nodes_m.row(5).transpose());
    ASSERT_EQ(place.nodes, std::vector<int>{5});
    EXPECT_EQ(place.weights[0], 1.0);
  }
}

TEST(SurfacePlaces, PlacesOffTheSurfaceByMoreThanOnePercentOfTheDiagonalAreRefused) {
  const TetMesh mesh = box_mesh(0.1, 0.05, 0.02, 3, 2, 2, 2);
  const SurfacePlaces surface(mesh);
  const double diagonal = Vector3d(0.1, 0.05, 0.02).norm();
  EXPECT_LE(std::abs(surface.tolerance_m() - 0.01 * diagonal), 1e-15);
  const SurfacePlace near = surface.at({0.05, 0.025, 0.02 + 0.0099 * diagonal});
  EXPECT_LE(std::abs(near.place_m[2] - 0.02), 1e-15);
  EXPECT_THROW(surface.at({0.05, 0.025, 0.02 + 0.0101 * diagonal}), InputError);
  EXPECT_THROW(surface.at({0.05, 0.025, 0.01}), InputError);  // inside
  EXPECT_THROW(surface.at({0.05, std::nan(""), 0.02}), InputError);
  EXPECT_THROW(surface.at_nodes({{{0.05, 0.025, 0.02}, {0, 0, std::nan("")}}}), InputError);
}

}  // namespace
