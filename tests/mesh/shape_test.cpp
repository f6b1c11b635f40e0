#include "core/mesh/shape.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/base/output_file.hpp"
#include "core/mesh/quality.hpp"
#include "mesh_checks.hpp"

using namespace klang;
using namespace klang::mesh;
using klang::mesh::test::expect_conforming;
using klang::mesh::test::expect_input_error;

namespace {

/// A bell-like open profile of even wall, and a solid goblet that reaches the axis.
std::filesystem::path profile_file(const std::string& name, const std::string& text) {
  const auto path =
      std::filesystem::temp_directory_path() / ("klang-" + std::to_string(::getpid()) + name + ".csv");
  write_file(path, text);
  return path;
}

const char* kBell =
    "r_m,z_m\n0.010,0.060\n0.030,0.050\n0.036,0.020\n0.050,0.000\n0.046,0.000\n0.032,0.019\n0.027,0.046\n0."
    "010,0.055\n";
const char* kGoblet =
    "r_m,z_m\n0,0\n0.03,0\n0.03,0.003\n0.004,0.006\n0.004,0.05\n0.03,0.07\n0.03,0.1\n0.027,0.1\n0.027,0."
    "072\n0,0.055\n";

std::vector<ShapeSpec> all_shapes() {
  return {{"tube", {{"length_m", 0.505}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}},
          {"rod", {{"length_m", 0.2}, {"radius_m", 0.01}}, {}},
          {"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.008}}, {}},
          {"shell_box", {{"edge_m", 0.1}, {"wall_m", 0.004}}, {}},
          {"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.03}, {"c_m", 0.04}}, {}},
          {"sphere", {{"radius_m", 0.05}}, {}},
          {"bowl", {{"outer_radius_m", 0.08}, {"wall_m", 0.003}, {"depth_m", 0.05}}, {}},
          {"bowl", {{"outer_radius_m", 0.08}, {"wall_m", 0.003}, {"depth_m", 0.11}}, {}},
          {"revolution", {}, profile_file("bell", kBell)},
          {"revolution", {}, profile_file("goblet", kGoblet)}};
}

std::string name_of(const ShapeSpec& spec) { return spec.kind + " " + spec.profile_csv.stem().string(); }

}  // namespace

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
