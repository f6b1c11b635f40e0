#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/mesh/quality.hpp"
#include "tests/core/geometry/mesh/mesh_checks.hpp"
#include "tests/core/geometry/shapes/shape_examples.hpp"

using namespace klang;
using namespace klang::mesh;
using namespace klang::mesh::test;

TEST(Shapes, DefaultMeshesConformAndAreNotFolded) {
  for (const ShapeSpec& spec : all_shapes())
    for (const int order : {1, 2}) {
      SCOPED_TRACE(name_of(spec) + " order " + std::to_string(order));
      ShapeMeshOptions options;
      options.order = order;
      const TetMesh mesh = mesh_shape(spec, options);
      EXPECT_EQ(mesh.order(), order);
      expect_conforming(mesh);
      const MeshQuality quality = mesh_quality(mesh);
      RecordProperty(name_of(spec), quality.brief());
      if (order == 2) {
        EXPECT_LE(std::abs(quality.volume_m3 / shape_volume_m3(spec) - 1.0), 2e-3);
        EXPECT_LE(std::abs(quality.surface_area_m2 / shape_area_m2(spec) - 1.0), 2e-3);
      }
    }
}

TEST(Shapes, QuadraticVolumeConvergesAtOrderFourAndLinearAtOrderTwo) {
  const std::vector<ShapeSpec> curved{
      {"tube", {{"length_m", 0.05}, {"outer_radius_m", 0.0125}, {"wall_m", 0.003}}, {}},
      {"rod", {{"length_m", 0.02}, {"radius_m", 0.01}}, {}},
      {"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.03}, {"c_m", 0.04}}, {}},
      {"bowl", {{"outer_radius_m", 0.08}, {"wall_m", 0.01}, {"depth_m", 0.05}}, {}},
      {"revolution", {}, profile_file("order", "0.03,0\n0.05,0\n0.04,0.03\n0.025,0.03\n")}};
  for (const ShapeSpec& spec : curved)
    for (const int order : {1, 2}) {
      SCOPED_TRACE(name_of(spec) + " order " + std::to_string(order));
      const std::array<int, 3> coarse = spec.kind == "tube"         ? std::array<int, 3>{2, 8, 1}
                                        : spec.kind == "revolution" ? std::array<int, 3>{8, 1, 0}
                                                                    : std::array<int, 3>{1, 1, 1};
      std::vector<double> volume_error, area_error;
      for (int level = 0; level < 4; ++level) {
        ShapeDivisions divisions;
        for (int i = 0; i < 3; ++i) divisions.counts[i] = coarse[i] << level;
        if (spec.kind == "revolution") divisions.counts = {coarse[0] << level, coarse[1], level};
        const TetMesh mesh = mesh_shape(spec, divisions, order);
        volume_error.push_back(std::abs(mesh_volume_m3(mesh) / shape_volume_m3(spec) - 1.0));
        area_error.push_back(std::abs(surface_area_m2(boundary_surface(mesh)) / shape_area_m2(spec) - 1.0));
      }
      EXPECT_GE(volume_error.back(), 1e-12) << "at round-off the order means nothing";
      const double expected = order == 2 ? 4.0 : 2.0, band = order == 2 ? 0.4 : 0.2;
      for (std::size_t level = 2; level < 4; ++level) {
        EXPECT_LE(std::abs(std::log2(volume_error[level - 1] / volume_error[level]) - expected), band) << level;
        EXPECT_LE(std::abs(std::log2(area_error[level - 1] / area_error[level]) - expected), band) << level;
      }
    }
}

TEST(ShapeRegistry, EveryKindsVolumeAndAreaAreThoseOfItsMesh) {
  for (const ShapeSpec& spec : examples_and_profile()) {
    ShapeMeshOptions fine;
    fine.refinement = 1;
    const MeshQuality quality = mesh_quality(mesh_shape(spec, fine));
    EXPECT_LE(std::abs(quality.volume_m3 / shape_volume_m3(spec) - 1.0), 1e-4) << spec.kind;
    EXPECT_LE(std::abs(quality.surface_area_m2 / shape_area_m2(spec) - 1.0), 1e-4) << spec.kind;
  }
}
