#include "core/geometry/shapes/profile_dimensions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "tests/process_file.hpp"

namespace klang::mesh {
namespace {

/// A hollow cylinder with a wall of 10 mm whose inside has two points in zone 1.
ShapeSpec cylinder(std::map<std::string, double> dims = {}) {
  const auto path = klang::test::process_file("profile.csv");
  std::ofstream(path) << "r_m,z_m,zone\n0.04,0,0\n0.05,0,0\n0.05,0.1,0\n0.04,0.1,0\n0.04,0.07,1\n0.04,0.03,1\n";
  return {"revolution", std::move(dims), path};
}

double frustum_m3(double r0, double r1, double height_m) {
  return kPi / 3.0 * (r0 * r0 + r0 * r1 + r1 * r1) * height_m;
}

/// Of the cylinder whose inside stands at inner_m between 30 and 70 mm.
double turned_volume_m3(double inner_m) {
  return frustum_m3(0.05, 0.05, 0.1) - 2.0 * frustum_m3(0.04, inner_m, 0.03) - frustum_m3(inner_m, inner_m, 0.04);
}

TEST(ProfileDimensions, AreThoseOfTheDrawing) {
  const auto drawn = drawn_dimensions_m(cylinder());
  ASSERT_EQ(drawn.size(), 2U);
  EXPECT_LE(std::abs(drawn.at("size_m") - 0.1), 1e-15);
  EXPECT_LE(std::abs(drawn.at("wall_1_m") - 0.01), 1e-15);
  EXPECT_TRUE(drawn_dimensions_m({"sphere", {{"radius_m", 0.1}}, {}}).empty());
}

TEST(ProfileDimensions, SizeScalesEveryLength) {
  EXPECT_LE(std::abs(shape_volume_m3(cylinder({{"size_m", 0.3}})) / (27.0 * shape_volume_m3(cylinder())) - 1.0), 1e-12);
}

TEST(ProfileDimensions, WallOfAZoneMovesItsPointsAlongTheirNormals) {
  EXPECT_LE(std::abs(shape_volume_m3(cylinder({{"wall_1_m", 0.008}})) / turned_volume_m3(0.042) - 1.0), 1e-12);
  EXPECT_LE(std::abs(shape_volume_m3(cylinder({{"wall_1_m", 0.013}})) / turned_volume_m3(0.037) - 1.0), 1e-12);
  // Of the scaled body the wall is the asked one, not its multiple.
  EXPECT_LE(
      std::abs(shape_volume_m3(cylinder({{"size_m", 0.2}, {"wall_1_m", 0.016}})) / (8.0 * turned_volume_m3(0.042)) -
               1.0),
      1e-12);
}

TEST(ProfileDimensions, MeshOfAChangedBodyKeepsItsTopologyAndFillsIt) {
  const ShapeDivisions divisions = shape_divisions(cylinder(), {});
  const TetMesh drawn = mesh_shape(cylinder(), divisions, 1),
                turned = mesh_shape(cylinder({{"wall_1_m", 0.008}}), divisions, 1);
  EXPECT_EQ(drawn.elements, turned.elements);
  // Of a polygon of n corners instead of a circle the same share is missing.
  const double share = mesh_volume_m3(drawn) / shape_volume_m3(cylinder());
  EXPECT_LE(std::abs(mesh_volume_m3(turned) / (share * turned_volume_m3(0.042)) - 1.0), 1e-9);
}

TEST(ProfileDimensions, WrittenProfileIsTheChangedBodyAgain) {
  const auto path = klang::test::process_file("written.csv");
  std::ofstream(path) << profile_csv(cylinder({{"size_m", 0.12}, {"wall_1_m", 0.009}}));
  const ShapeSpec read{"revolution", {}, path};
  EXPECT_LE(std::abs(shape_volume_m3(read) / shape_volume_m3(cylinder({{"size_m", 0.12}, {"wall_1_m", 0.009}})) - 1.0),
            1e-12);
  // Normals tilt with the sides, so that the wall measured anew is a little longer: by the cosine of half a kink here, 1.4e-4.
  EXPECT_LE(std::abs(drawn_dimensions_m(read).at("wall_1_m") / 0.009 - 1.0), 1e-3);
}

TEST(ProfileDimensions, WhatCannotBeIsRefused) {
  EXPECT_THROW(validate(cylinder({{"wall_2_m", 0.01}})), InputError);
  EXPECT_THROW(validate(cylinder({{"wall_1_m", 0.001}})), InputError);
  EXPECT_THROW(validate(cylinder({{"wall_1_m", 0.05}})), InputError);
  EXPECT_THROW(validate(cylinder({{"size_m", -0.1}})), InputError);
  EXPECT_THROW(validate(cylinder({{"size_m", std::nan("")}})), InputError);
}

}  // namespace
}  // namespace klang::mesh
