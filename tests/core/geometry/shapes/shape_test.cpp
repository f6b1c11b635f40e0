#include "core/geometry/shapes/shape.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_point.hpp"
#include "tests/core/geometry/mesh/mesh_checks.hpp"
#include "tests/core/geometry/shapes/shape_examples.hpp"

using namespace klang;
using namespace klang::mesh;
using namespace klang::mesh::test;

TEST(Shapes, FlatBodiesHaveTheirExactVolumeAndArea) {
  for (const ShapeSpec& spec : {all_shapes()[2], all_shapes()[3]}) {
    const MeshQuality quality = mesh_quality(mesh_shape(spec));
    EXPECT_LE(std::abs(quality.volume_m3 / shape_volume_m3(spec) - 1.0), 1e-13);
    EXPECT_LE(std::abs(quality.surface_area_m2 / shape_area_m2(spec) - 1.0), 1e-13);
    EXPECT_LE(std::abs(quality.mass_kg(2000.0) / (2000.0 * shape_volume_m3(spec)) - 1.0), 1e-13);
  }
  EXPECT_DOUBLE_EQ(shape_volume_m3(all_shapes()[2]), 8e-5);
}

TEST(Shapes, MidNodesLieOnTheTrueSurface) {
  const double outer = 0.0125, inner = 0.0115;
  const TetMesh tube = mesh_shape(all_shapes()[0]);
  for (const auto& [set, radius] : {std::pair<const char*, double>{"outer", outer}, {"inner", inner}})
    for (const int node : tube.node_sets.at(set))
      EXPECT_LE(std::abs(tube.nodes_m.row(node).head<2>().norm() / radius - 1.0), 1e-14);
  const TetMesh ball = mesh_shape(all_shapes()[5]);
  for (const int node : ball.node_sets.at("outer"))
    EXPECT_LE(std::abs(ball.nodes_m.row(node).norm() / 0.05 - 1.0), 1e-14);
}

TEST(Shapes, NodeSetsHoldExactlyTheNodesOfTheirFaces) {
  const TetMesh box = mesh_shape(all_shapes()[2]);
  const std::array<double, 3> half{0.05, 0.05, 0.004};
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      const std::string set = std::string(1, "xyz"[axis]) + (high ? "_max" : "_min");
      std::vector<int> expected;
      for (int i = 0; i < box.n_nodes(); ++i)
        if (box.nodes_m(i, axis) == (high ? half[axis] : -half[axis])) expected.push_back(i);
      EXPECT_EQ(box.node_sets.at(set), expected) << set;
    }
  // Every boundary node of every shape is in a set, and no inner one.
  for (const ShapeSpec& spec : all_shapes()) {
    const TetMesh mesh = mesh_shape(spec);
    std::set<int> named, boundary;
    for (const auto& [set, nodes] : mesh.node_sets) named.insert(nodes.begin(), nodes.end());
    const SurfaceMesh surface = boundary_surface(mesh);
    boundary.insert(surface.triangles.data(), surface.triangles.data() + surface.triangles.size());
    EXPECT_EQ(named, boundary) << name_of(spec);
  }
}

TEST(Shapes, TurningARotationalMeshMapsItOntoItself) {
  // By two sectors of the tube's twenty (neighbours are mirror images), by a quarter for the others.
  for (const auto& [shape, angle] :
       std::vector<std::pair<int, double>>{{0, kPi / 5}, {1, kPi / 2}, {5, kPi / 2}, {6, kPi / 2}, {8, kPi / 2}}) {
    const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitZ());
    const TetMesh mesh = mesh_shape(all_shapes()[shape]);
    // Elements as sets of rounded corner positions, before and after the turn.
    std::set<std::set<std::array<long, 3>>> before, after;
    for (int e = 0; e < mesh.n_elements(); ++e) {
      std::set<std::array<long, 3>> here, turned;
      for (int c = 0; c < 4; ++c) {
        // Shifted by an odd part of the rounding step, so that no coordinate sits on a tie.
        const Eigen::Vector3d p = mesh.nodes_m.row(mesh.elements(e, c)).transpose() * 1e7;
        const Eigen::Vector3d q = turn * p;
        here.insert({std::lround(p.x() + 0.137), std::lround(p.y() + 0.137), std::lround(p.z() + 0.137)});
        turned.insert({std::lround(q.x() + 0.137), std::lround(q.y() + 0.137), std::lround(q.z() + 0.137)});
      }
      before.insert(here);
      after.insert(turned);
    }
    EXPECT_TRUE(before == after) << name_of(all_shapes()[shape]);
  }
}

TEST(Shapes, TopologyDependsOnDivisionsAlone) {
  ShapeSpec tube = all_shapes()[0];
  const ShapeDivisions divisions = shape_divisions(tube, {});
  const TetMesh a = mesh_shape(tube, divisions, 2);
  tube.dims["length_m"] *= 1.01;
  tube.dims["wall_m"] *= 1.3;
  EXPECT_TRUE(a.elements == mesh_shape(tube, divisions, 2).elements);
}

TEST(Shapes, EdgesFollowMaxEdgeAndWavelength) {
  ShapeMeshOptions options;
  options.max_edge_m = 0.004;
  const ShapeDivisions by_edge = shape_divisions(all_shapes()[2], options);
  EXPECT_EQ(by_edge.counts, (std::array<int, 3>{30, 30, 2}));  // 25 even ones, graded by up to 1.2
  options.max_edge_m = 0.0;
  options.wavelength_m = 0.016;
  EXPECT_EQ(shape_divisions(all_shapes()[2], options).counts, by_edge.counts);
  options.order = 1;
  options.wavelength_m = 0.032;
  EXPECT_EQ(shape_divisions(all_shapes()[2], options).counts, by_edge.counts);
  const TetMesh box = mesh_shape(all_shapes()[2], by_edge, 1);
  for (int i = 0; i < box.n_nodes(); ++i)  // along the sweep no gap is wider than asked for
    if (box.nodes_m(i, 0) < 0.05 - 1e-12) {
      const double next =
          box.nodes_m.col(0).unaryExpr([&](double x) { return x > box.nodes_m(i, 0) + 1e-9 ? x : 1.0; }).minCoeff();
      ASSERT_LE(next - box.nodes_m(i, 0), 0.004 * (1 + 1e-9));
    }
  options.max_edge_m = 1e-7;
  expect_input_error([&] { shape_divisions(all_shapes()[2], options); }, {"edge"});
}

TEST(Shapes, EachImpossibleDimensionIsOneErrorThatNamesIt) {
  const auto bad = [](const std::string& kind, std::map<std::string, double> dims,
                      const std::vector<std::string>& words) {
    expect_input_error([&] { validate({kind, dims, {}}); }, words);
    expect_input_error([&] { mesh_shape({kind, dims, {}}); }, words);
  };
  bad("cone", {}, {"cone", "tube", "sphere"});
  bad("tube", {{"length_m", 0.5}, {"outer_radius_m", 0.01}, {"wall_m", -0.001}}, {"tube", "wall_m", "-0.001"});
  bad("tube", {{"length_m", 0.5}, {"outer_radius_m", 0.01}, {"wall_m", 0.01}}, {"wall_m", "outer_radius_m"});
  bad("tube", {{"length_m", 0.5}, {"outer_radius_m", 0.01}}, {"missing", "wall_m"});
  bad("tube", {{"length_m", 0.5}, {"outer_radius_m", 0.01}, {"wall_m", 0.001}, {"radius_m", 1}},
      {"unknown", "radius_m"});
  bad("rod", {{"length_m", std::nan("")}, {"radius_m", 0.01}}, {"length_m"});
  bad("box", {{"length_m", 0.5}, {"width_m", 0.0}, {"height_m", 0.1}}, {"width_m", "0"});
  bad("box", {{"length_m", 0.5}, {"width_m", 0.1}, {"height_m", 1e-9}}, {"dimensions too different"});
  bad("shell_box", {{"edge_m", 0.1}, {"wall_m", 0.05}}, {"wall_m", "edge_m / 2"});
  bad("bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.01}, {"depth_m", 0.2}}, {"depth_m"});
  bad("bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.01}, {"depth_m", 0.005}}, {"wall_m", "depth_m"});
  bad("revolution", {}, {"profile_csv"});
}

TEST(Revolution, TubeAndSphereProfilesGiveTheVolumesOfThoseShapes) {
  const ShapeSpec ring{
      "revolution", {}, profile_file("ring", "0.0115,0\n0.0125,0\n0.0125,0.05\n0.0115,0.05\n0.0115,0\n")};
  EXPECT_LE(
      std::abs(shape_volume_m3(ring) /
                   shape_volume_m3({"tube", {{"length_m", 0.05}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}}) -
               1.0),
      1e-13);
  const ShapeSpec rod{"revolution", {}, profile_file("rod", "r_m;z_m\n0;0\n0.01;0\n0.01;0.05\n0;0.05\n")};
  EXPECT_LE(std::abs(shape_area_m2(rod) / shape_area_m2({"rod", {{"length_m", 0.05}, {"radius_m", 0.01}}, {}}) - 1.0),
            1e-13);
  expect_conforming(mesh_shape(rod));
}

TEST(Revolution, EachBadProfileIsOneErrorThatNamesTheLineOrSide) {
  const auto bad = [](const std::string& text, const std::vector<std::string>& words) {
    const ShapeSpec spec{"revolution", {}, profile_file("bad", text)};
    expect_input_error([&] { mesh_shape(spec); }, words);
    std::filesystem::remove(spec.profile_csv);
  };
  bad("r_m,z_m\n0.1,0\n-0.2,0\n0.1,1\n", {"line 3", "r_m", "-0.2"});
  bad("r_m,z_m\n0.1,0\nnan,0\n0.1,1\n", {"line 3", "finite"});
  bad("r_m,z_m\n0.1,0\n0.2\n0.1,1\n", {"line 3", "two numbers"});
  bad("x,y\n0.1,0\n", {"line 1", "r_m"});
  bad("0.1,0\n0.2,0\n", {"too few"});
  bad("", {"too few"});
  bad("1,0\n2,1\n2,0\n1,1\n", {"crosses", "0 to 1", "2 to 3"});
  bad("1,0\n2,0\n2,1\n1.5,0\n1,1\n", {"touches", "side"});
  bad("1,0\n1.1,0.1\n1.2,0.2\n1.3,0.25\n1.4,0.3\n1.5,0.3\n1.6,0.3\n", {"open profile"});
  bad("0,0\n1,1\n1,-1\n", {"axis", "single point"});
  bad("1,0\n1,0\n2,0\n2,1\n", {"line 1", "repeated"});
}

TEST(NearestNode, OnTheSurfaceAndInside) {
  const TetMesh ball = mesh_shape(all_shapes()[5]);
  EXPECT_LE(ball.nodes_m.row(nearest_node(ball, {0, 0, 0})).norm(), 1e-15);
  EXPECT_LE(std::abs(ball.nodes_m.row(nearest_surface_node(ball, {0.001, 0, 0})).norm() - 0.05), 1e-15);
  expect_input_error([&] { nearest_node(ball, {std::nan(""), 0, 0}); }, {"finite"});
}

TEST(SurfacePoint, QuadraticFieldOnABoxIsRepeatedAtTheNearestPointOfItsFaces) {
  const TetMesh mesh = mesh_shape({"box", {{"length_m", 0.1}, {"width_m", 0.08}, {"height_m", 0.02}}, {}});
  const auto field = [](const Eigen::Vector3d& x) {
    return 1.0 + 3.0 * x[0] - x[1] + 40.0 * x[0] * x[1] + 25.0 * x[0] * x[0];
  };
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.031, -0.013, 0.01), Eigen::Vector3d(0.012, 0.007, 0.5), Eigen::Vector3d(0.3, 0.4, 0.5)}) {
    const SurfacePoint place = nearest_surface_point(mesh, p);
    const Eigen::Vector3d foot = p.cwiseMin(Eigen::Vector3d(0.05, 0.04, 0.01));
    double value = 0.0;
    for (std::size_t k = 0; k < place.nodes.size(); ++k)
      value += place.weights[static_cast<Eigen::Index>(k)] * field(mesh.nodes_m.row(place.nodes[k]).transpose());
    EXPECT_LE(std::abs(value - field(foot)), 1e-12);
    EXPECT_LE(std::abs(place.distance_m - (p - foot).norm()), 1e-12);
  }
  expect_input_error([&] { nearest_surface_point(mesh, {0.0, std::nan(""), 0.0}); }, {"not finite"});
}
