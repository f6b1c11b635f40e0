#include "core/physics/rigid/convex_parts.hpp"

#include <gtest/gtest.h>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

namespace klang::rigid {
namespace {

double mass_of(const std::vector<ConvexPart>& parts) {
  RigidBodySpec body;
  body.parts = parts;
  set_mass_from_parts(body, 1.0);
  return body.mass_kg;
}

std::vector<ConvexPart> parts_of(const mesh::ShapeSpec& shape) {
  std::vector<ConvexPart> parts;
  for (const Eigen::Matrix3Xd& corners_m : mesh::convex_parts(shape)) parts.push_back({corners_m});
  return parts;
}

TEST(ConvexParts, OfShapesFillThem) {
  const struct {
    mesh::ShapeSpec shape;
    double tolerance;
    std::size_t n_parts;
  } cases[] = {
      {{"box", {{"length_m", 0.3}, {"width_m", 0.2}, {"height_m", 0.01}}, {}}, 1e-12, 1},
      {{"rod", {{"length_m", 0.3}, {"radius_m", 0.01}}, {}}, 0.01, 1},
      {{"sphere", {{"radius_m", 0.1}}, {}}, 0.07, 1},
      {{"ellipsoid", {{"a_m", 0.1}, {"b_m", 0.05}, {"c_m", 0.08}}, {}}, 0.07, 1},
      {{"tube", {{"length_m", 0.505}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}}, 0.5, 12},
      {{"tube", {{"length_m", 0.1}, {"outer_radius_m", 0.1}, {"wall_m", 0.05}}, {}}, 0.05, 12},
      {{"bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.02}, {"depth_m", 0.07}}, {}}, 0.1, 0},
  };
  for (const auto& c : cases) {
    const std::vector<ConvexPart> parts = parts_of(c.shape);
    if (c.n_parts > 0) {
      EXPECT_EQ(parts.size(), c.n_parts) << c.shape.kind;
    }
    const double volume = mesh::shape_volume_m3(c.shape);
    EXPECT_LE(std::abs(mass_of(parts) - volume), c.tolerance * volume) << c.shape.kind << " " << parts.size();
  }
}

// A ball falls within a hollow box, which falls too and lands: it comes to lie on the inner floor.
TEST(ConvexParts, OfAClosedHollowAreItsWalls) {
  const mesh::ShapeSpec shape{"shell_box", {{"edge_m", 0.1}, {"wall_m", 0.004}}, {}};
  const std::vector<ConvexPart> parts = parts_of(shape);
  ASSERT_EQ(parts.size(), 6u);
  EXPECT_LE(std::abs(mass_of(parts) - mesh::shape_volume_m3(shape)), 1e-15);
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = skin(0.3, 0.4);
  RigidWorld world(options);
  RigidBodySpec box;
  box.name = "box";
  box.parts = parts;
  set_mass_from_parts(box, 1200);
  box.skin = skin(0.3, 0.4);
  box.position_m = Eigen::Vector3d(0, 0, 0.07);
  RigidBodySpec inside = ball("ball", 0.01, 0.01);
  inside.skin = box.skin;
  inside.position_m = Eigen::Vector3d(0.004, -0.003, 0.08);
  world.add(box);
  world.add(inside);
  EXPECT_FALSE(world.overlap(1e-9));
  for (int i = 0; i < 5000; ++i) world.step();
  EXPECT_NEAR(world.centre_m(0).z(), 0.05, 1e-5);
  EXPECT_NEAR(world.centre_m(1).z(), 0.014, 1e-5);
}

TEST(ConvexParts, OfAConvexMeshAreItsHullAndOfAnAngleJustTwo) {
  const mesh::TetMesh box =
      mesh::to_linear(mesh::mesh_shape({"box", {{"length_m", 0.3}, {"width_m", 0.2}, {"height_m", 0.1}}, {}}));
  ASSERT_EQ(convex_parts_of(box, "box").size(), 1u);
  EXPECT_LE(std::abs(mass_of(convex_parts_of(box, "box")) - 0.006), 1e-12);
  EXPECT_EQ(convex_parts_of(box, "box")[0].corners_m.cols(), 8);

  // An L of two cuboids, 0.2 x 0.1 x 0.1 and 0.1 x 0.1 x 0.1 m, meshed together from a coarse box without an octant's column.
  mesh::TetMesh angle;
  const mesh::TetMesh square = mesh::to_linear(
      mesh::mesh_shape({"box", {{"length_m", 0.2}, {"width_m", 0.2}, {"height_m", 0.1}}, {}}, {1, 0.11, 0.0, 4.0, 0}));
  angle.nodes_m = square.nodes_m;
  std::vector<int> kept;
  for (int e = 0; e < square.n_elements(); ++e) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) centre += 0.25 * square.nodes_m.row(square.elements(e, c)).transpose();
    if (!(centre.x() > 0.0 && centre.y() > 0.0)) kept.push_back(e);
  }
  angle.elements = square.elements(kept, Eigen::all);
  const std::vector<ConvexPart> parts = convex_parts_of(angle, "angle");
  EXPECT_GE(parts.size(), 2u);
  EXPECT_LE(parts.size(), 4u);
  EXPECT_LE(std::abs(mass_of(parts) - 0.003), 1e-12);
}

TEST(ConvexParts, ABoxOfOneMetreRestsAsHighWhetherMeshOrShape) {
  const mesh::ShapeSpec shape{"box", {{"length_m", 1.0}, {"width_m", 0.7}, {"height_m", 0.31}}, {}};
  mesh::TetMesh mesh = mesh::to_linear(mesh::mesh_shape(shape));
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.9, 0.3, -0.2, 0.4).normalized();  // of the mesh's frame
  mesh.nodes_m = mesh.nodes_m * turn.toRotationMatrix().transpose();
  double height_m[2];
  for (const bool meshed : {false, true}) {
    RigidBodySpec body;
    body.name = "box";
    body.parts = meshed ? convex_parts_of(mesh, "box") : parts_of(shape);
    set_mass_from_parts(body, 1000);
    if (meshed) body.orientation = turn.conjugate();
    body.position_m.z() = 0.155;
    RigidWorldOptions options;
    options.floor = skin(0.0, 0.5);
    RigidWorld world(options);
    world.add(body);
    for (int i = 0; i < 200; ++i) world.step();
    height_m[meshed ? 1 : 0] = world.centre_m(0).z();
    EXPECT_LE(std::abs(body.mass_kg - 217), 1e-9);
  }
  EXPECT_LE(std::abs(height_m[1] - height_m[0]), 1e-9);
}

TEST(ConvexParts, OfATurnedMeshOverlapOthersAsDeepAsTheShape) {
  const mesh::TetMesh straight =
      mesh::to_linear(mesh::mesh_shape({"box", {{"length_m", 1.0}, {"width_m", 0.7}, {"height_m", 0.31}}, {}}));
  RandomStream random(1, 0);
  const auto draw = [&] { return 2 * random.uniform() - 1; };
  const auto turn = [&] { return Eigen::Quaterniond(draw(), draw(), draw(), draw()).normalized(); };
  int n_overlaps = 0;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Quaterniond of_mesh = turn(), of_body = turn();
    mesh::TetMesh turned = straight;
    turned.nodes_m = turned.nodes_m * of_mesh.toRotationMatrix().transpose();
    RigidBodySpec body = cuboid("box", {1.0, 0.7, 0.31}, 1);
    body.position_m = 0.6 * Eigen::Vector3d(draw(), draw(), draw());
    double depth_m[2];
    for (const bool meshed : {false, true}) {
      if (meshed) body.parts = convex_parts_of(turned, "box");
      body.orientation = meshed ? of_body * of_mesh.conjugate() : of_body;
      RigidWorld world(RigidWorldOptions{});
      world.add(cuboid("other", {0.5, 0.9, 0.6}, 1));
      world.add(body);
      const auto overlap = world.overlap(0.0);
      depth_m[meshed ? 1 : 0] = overlap ? overlap->depth_m : 0.0;
    }
    n_overlaps += depth_m[0] > 0 ? 1 : 0;
    EXPECT_LE(std::abs(depth_m[1] - depth_m[0]), 1e-9) << k;
  }
  EXPECT_GT(n_overlaps, 40);
}

TEST(ConvexParts, TooManyAreRefused) {
  const mesh::TetMesh bowl =
      mesh::to_linear(mesh::mesh_shape({"bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.005}, {"depth_m", 0.07}}, {}}));
  EXPECT_THROW(convex_parts_of(bowl, "bowl", {0.0, 10}), InputError);
}

}  // namespace
}  // namespace klang::rigid
