#pragma once
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/foundation/base/output_file.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "tests/process_file.hpp"

namespace klang::mesh::test {

/// A bell-like open profile of even wall, and a solid goblet that reaches the axis.
inline std::filesystem::path profile_file(const std::string& name, const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / ("klang-" + std::to_string(::getpid()) + name + ".csv");
  write_file(path, text);
  return path;
}

inline constexpr const char* kBell =
    "r_m,z_m\n0.010,0.060\n0.030,0.050\n0.036,0.020\n0.050,0.000\n0.046,0.000\n0.032,0.019\n0.027,0.046\n0."
    "010,0.055\n";
inline constexpr const char* kGoblet =
    "r_m,z_m\n0,0\n0.03,0\n0.03,0.003\n0.004,0.006\n0.004,0.05\n0.03,0.07\n0.03,0.1\n0.027,0.1\n0.027,0."
    "072\n0,0.055\n";

inline std::vector<ShapeSpec> all_shapes() {
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

inline std::string name_of(const ShapeSpec& spec) { return spec.kind + " " + spec.profile_csv.stem().string(); }

/// A body of every kind that is given by dimensions.
inline std::vector<ShapeSpec> examples() {
  return {{"tube", {{"length_m", 0.1}, {"outer_radius_m", 0.02}, {"wall_m", 0.004}}, {}},
          {"rod", {{"length_m", 0.1}, {"radius_m", 0.02}}, {}},
          {"box", {{"length_m", 0.1}, {"width_m", 0.06}, {"height_m", 0.03}}, {}},
          {"shell_box", {{"edge_m", 0.1}, {"wall_m", 0.01}}, {}},
          {"ellipsoid", {{"a_m", 0.05}, {"b_m", 0.05}, {"c_m", 0.03}}, {}},
          {"sphere", {{"radius_m", 0.05}}, {}},
          {"bowl", {{"outer_radius_m", 0.05}, {"wall_m", 0.005}, {"depth_m", 0.04}}, {}}};
}

inline ShapeSpec cone_stump() {
  const auto path = klang::test::process_file("cone.csv");
  std::ofstream(path) << "r_m,z_m\n0,0\n0.03,0\n0.02,0.05\n0,0.05\n";
  return {"revolution", {}, path};
}

inline std::vector<ShapeSpec> examples_and_profile() {
  std::vector<ShapeSpec> all = examples();
  all.push_back(cone_stump());
  all.push_back({"undercut_bar",
                 {{"length_m", 0.1},
                  {"width_m", 0.03},
                  {"height_m", 0.02},
                  {"undercut_length_m", 0.06},
                  {"undercut_depth_m", 0.01}},
                 {}});
  return all;
}

}  // namespace klang::mesh::test
