#include "core/geometry/mesh/surface_repair.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/random.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "tests/core/geometry/mesh/mesh_checks.hpp"

using namespace klang;
using namespace klang::mesh;
using klang::mesh::test::expect_input_error;

namespace {

/// A ball, a plate of 1:100 and a ring with a hole through it.
std::vector<SurfaceMesh> bodies() {
  std::vector<SurfaceMesh> result;
  result.push_back(boundary_surface(mesh_shape({"sphere", {{"radius_m", 0.05}}, {}}, {{4, 4, 1}}, 1)));
  result.push_back(boundary_surface(
      mesh_shape({"box", {{"length_m", 0.2}, {"width_m", 0.15}, {"height_m", 0.002}}, {}}, {{3, 2, 1}}, 1)));
  result.push_back(boundary_surface(
      mesh_shape({"tube", {{"length_m", 0.1}, {"outer_radius_m", 0.03}, {"wall_m", 0.01}}, {}}, {{2, 12, 1}}, 1)));
  SurfaceRepairs unheard;
  for (SurfaceMesh& surface : result) surface = repaired_surface(surface, "body", unheard);  // no inner nodes
  return result;
}

SurfaceMesh split(const SurfaceMesh& surface) {
  SurfaceMesh result;
  result.triangles.resize(surface.triangles.rows(), 3);
  result.vertices_m.resize(3 * surface.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) {
      result.vertices_m.row(3 * t + c) = surface.vertices_m.row(surface.triangles(t, c));
      result.triangles(t, c) = static_cast<int>(3 * t + c);
    }
  return result;
}

void turn(SurfaceMesh& surface, Eigen::Index t) { std::swap(surface.triangles(t, 1), surface.triangles(t, 2)); }

double volume(const SurfaceMesh& surface) { return check_closed_surface(surface, "s").volume_m3; }

double mended_volume(const SurfaceMesh& surface, SurfaceRepairs& repairs) {
  return volume(repaired_surface(surface, "s", repairs));
}

}  // namespace

TEST(SurfaceRepair, ASoundSurfaceComesBackBitForBit) {
  for (const SurfaceMesh& surface : bodies()) {
    SurfaceRepairs repairs;
    const SurfaceMesh mended = repaired_surface(surface, "s", repairs);
    EXPECT_FALSE(repairs.any());
    EXPECT_EQ(repairs.text(), "");
    EXPECT_TRUE(mended.vertices_m == surface.vertices_m);
    EXPECT_TRUE(mended.triangles == surface.triangles);
  }
}

TEST(SurfaceRepair, CornersRepeatedForNormalsBecomeOne) {
  for (const SurfaceMesh& surface : bodies()) {
    SurfaceRepairs repairs;
    EXPECT_LE(std::abs(mended_volume(split(surface), repairs) / volume(surface) - 1.0), 1e-12);
    EXPECT_EQ(repairs.n_welded_vertices, 3 * surface.triangles.rows() - surface.vertices_m.rows());
    EXPECT_EQ(repairs.weld_distance_m, 0.0);
    EXPECT_EQ(repairs.n_turned_faces + repairs.n_collapsed_faces + repairs.n_duplicate_faces, 0);
  }
}

TEST(SurfaceRepair, CornersThatDifferInTheLastBitAreWeldedButThoseOfAThinWallAreNot) {
  for (const SurfaceMesh& surface : bodies()) {
    SurfaceMesh shaken = split(surface);
    RandomStream random(7, 0);
    for (double& x : shaken.vertices_m.reshaped()) x = static_cast<float>(x) * (1.0 + 1e-7 * random.uniform(-1, 1));
    SurfaceRepairs repairs;
    EXPECT_LE(std::abs(mended_volume(shaken, repairs) / volume(surface) - 1.0), 1e-6);
    EXPECT_GT(repairs.weld_distance_m, 0.0);
    EXPECT_LE(repairs.weld_distance_m, 1e-6 * 0.2);
    // Far from the origin 32-bit coordinates are coarser than a millionth of the size.
    for (double& x : shaken.vertices_m.reshaped()) x = static_cast<float>(x + 10.0);
    EXPECT_LE(std::abs(mended_volume(shaken, repairs) / volume(surface) - 1.0), 1e-2);
  }
}

TEST(SurfaceRepair, FacetsWoundTheOtherWayAreTurnedAndCounted) {
  for (const SurfaceMesh& surface : bodies()) {
    SurfaceMesh wrong = surface;
    turn(wrong, 3);
    turn(wrong, 11);
    SurfaceRepairs repairs;
    EXPECT_LE(std::abs(mended_volume(wrong, repairs) / volume(surface) - 1.0), 1e-12);
    EXPECT_EQ(repairs.n_turned_faces, 2);
    EXPECT_EQ(repairs.n_turned_parts, 0);
    EXPECT_EQ(repairs.text(), "2 facets turned");
    for (Eigen::Index t = 0; t < wrong.triangles.rows(); ++t) turn(wrong, t);  // now nearly all
    EXPECT_LE(std::abs(mended_volume(wrong, repairs) / volume(surface) - 1.0), 1e-12);
    EXPECT_EQ(repairs.n_turned_faces, 2);
    EXPECT_EQ(repairs.n_turned_parts, 1);
  }
}

TEST(SurfaceRepair, CollapsedRepeatedAndFlatFacetsGo) {
  for (const SurfaceMesh& surface : bodies()) {
    const Eigen::Index n = surface.triangles.rows();
    SurfaceMesh wrong = surface;
    wrong.triangles.conservativeResize(n + 3, 3);
    wrong.triangles.row(n) << 0, 0, 1;
    wrong.triangles.row(n + 1) = surface.triangles.row(2);
    wrong.triangles.row(n + 2) << surface.triangles(4, 1), surface.triangles(4, 2), surface.triangles(4, 0);
    SurfaceRepairs repairs;
    EXPECT_LE(std::abs(mended_volume(wrong, repairs) / volume(surface) - 1.0), 1e-12);
    EXPECT_EQ(repairs.n_collapsed_faces, 1);
    EXPECT_EQ(repairs.n_duplicate_faces, 2);

    // A corner amid an edge of face 0 alone, joined to the neighbour by a face without height.
    wrong = surface;
    const int a = surface.triangles(0, 0), b = surface.triangles(0, 1), c = surface.triangles(0, 2);
    const auto m = static_cast<int>(surface.vertices_m.rows());
    wrong.vertices_m.conservativeResize(m + 1, 3);
    wrong.vertices_m.row(m) = 0.5 * (surface.vertices_m.row(a) + surface.vertices_m.row(b));
    wrong.triangles.conservativeResize(n + 2, 3);
    wrong.triangles.row(0) << a, m, c;
    wrong.triangles.row(n) << m, b, c;
    wrong.triangles.row(n + 1) << a, b, m;
    EXPECT_LE(std::abs(volume(repaired_surface(wrong, "s", repairs)) / volume(surface) - 1.0), 1e-12);
    EXPECT_EQ(repairs.n_recut_faces, 1);
  }
}

TEST(SurfaceRepair, WhatStaysOpenIsRefusedWithTheNumberOfOpenEdgesAndThePlaceOfTheFirst) {
  SurfaceMesh surface = bodies()[1];
  const Eigen::RowVector3d at = surface.vertices_m.row(surface.triangles(0, 0));
  surface.triangles = surface.triangles.bottomRows(surface.triangles.rows() - 1).eval();
  SurfaceRepairs repairs;
  const SurfaceMesh mended = repaired_surface(split(surface), "plate", repairs);
  expect_input_error([&] { check_closed_surface(mended, "plate"); },
                     {"plate", "open edge", "3 open edges", "the first"});
  EXPECT_TRUE((mended.vertices_m.rowwise() - at).rowwise().norm().minCoeff() <= 1e-12);
}

TEST(SurfaceRepair, AHollowIsTurnedWithItsBodyButNotAlone) {
  const auto cube = [](double half, bool inward) {
    SurfaceMesh s = boundary_surface(mesh_shape(
        {"box", {{"length_m", 2 * half}, {"width_m", 2 * half}, {"height_m", 2 * half}}, {}}, {{1, 1, 1}}, 1));
    if (inward) s.triangles.col(1).swap(s.triangles.col(2));
    return s;
  };
  const auto nested = [&](bool outer_inward, bool inner_inward) {
    const SurfaceMesh outer = cube(1.0, outer_inward), inner = cube(0.5, inner_inward);
    SurfaceMesh both;
    both.vertices_m.resize(outer.vertices_m.rows() + inner.vertices_m.rows(), 3);
    both.vertices_m << outer.vertices_m, inner.vertices_m;
    both.triangles.resize(outer.triangles.rows() + inner.triangles.rows(), 3);
    both.triangles << outer.triangles, (inner.triangles.array() + static_cast<int>(outer.vertices_m.rows())).matrix();
    return both;
  };
  SurfaceRepairs repairs;
  EXPECT_LE(std::abs(mended_volume(nested(false, true), repairs) - 7.0), 1e-12);
  EXPECT_EQ(repairs.n_turned_parts, 0);
  EXPECT_LE(std::abs(mended_volume(nested(true, false), repairs) - 7.0), 1e-12);
  EXPECT_EQ(repairs.n_turned_parts, 2);
  EXPECT_LE(std::abs(mended_volume(nested(true, true), repairs) - 7.0), 1e-12);
  EXPECT_EQ(repairs.n_turned_parts, 1);
  expect_input_error([&] { mended_volume(nested(false, false), repairs); }, {"inside-out"});
}

TEST(SurfaceFile, LinesOfAnObjGoOnBehindABackslashButRemarksDoNot) {
  const SurfaceMesh box = bodies()[1];
  std::string text = "# made in C:\\\r\nmtllib C:\\\r\n";
  for (Eigen::Index v = 0; v < box.vertices_m.rows(); ++v)
    text += "v " + to_text(box.vertices_m(v, 0)) + " \\\r\n " + to_text(box.vertices_m(v, 1)) + " " +
            to_text(box.vertices_m(v, 2)) + "\r\n";
  for (Eigen::Index t = 0; t < box.triangles.rows(); ++t)
    text += "f " + std::to_string(box.triangles(t, 0) + 1) + " \\\r\n  " + std::to_string(box.triangles(t, 1) + 1) +
            " \\\r\n" + std::to_string(box.triangles(t, 2) + 1) + "\r\n";
  EXPECT_LE(std::abs(volume(read_surface_bytes(text, ".obj", "o")) / volume(box) - 1.0), 1e-12);
  const std::string joined = without_continued_lines(text);
  EXPECT_LE(std::abs(volume(read_surface_bytes(joined, ".obj", "o")) / volume(box) - 1.0), 1e-12);
  EXPECT_EQ(std::count(joined.begin(), joined.end(), '\n'), 2 + box.vertices_m.rows() + box.triangles.rows());
}

TEST(SurfaceFile, ABinaryStlMayBeginWithSolidAndHaveBytesBehindItsLastFacet) {
  const SurfaceMesh box = bodies()[1];
  const auto path = std::filesystem::temp_directory_path() / ("klang-solid-" + std::to_string(::getpid()) + ".stl");
  write_stl(path, box);
  std::string bytes = read_file(path);
  std::filesystem::remove(path);
  for (const char* head : {"", "solid of someone "})
    for (const std::string& tail : {std::string(), std::string("\n"), std::string(7, '\0')}) {
      bytes.replace(0, std::strlen(head), head);
      SurfaceRepairs repairs;
      const SurfaceMesh surface = read_surface_bytes(bytes + tail, ".stl", "s", &repairs);
      EXPECT_LE(std::abs(volume(surface) / volume(box) - 1.0), 1e-6);
      EXPECT_EQ(repairs.n_extra_bytes, static_cast<std::int64_t>(tail.size()));
    }
}

TEST(SurfaceDecimation, ReachesTheNumberAndSaysHowFarItIsOff) {
  const SurfaceMesh ball = boundary_surface(mesh_shape({"sphere", {{"radius_m", 0.05}}, {}}, {{16, 16, 1}}, 1));
  SurfaceDecimation report;
  const SurfaceMesh coarse = decimated_surface(ball, 400, report);
  EXPECT_EQ(report.n_faces_before, ball.triangles.rows());
  EXPECT_EQ(report.n_faces_after, coarse.triangles.rows());
  EXPECT_LE(coarse.triangles.rows(), 400);
  EXPECT_GE(coarse.triangles.rows(), 300);
  const double change = volume(coarse) / volume(ball) - 1.0;
  EXPECT_LE(std::abs(report.relative_volume_change - change), 1e-9);
  EXPECT_LE(std::abs(change), 0.02);
  // The sagitta of equal triangles: edge^2 / (8 R) x 4/3 with 400 of them on the ball is 2 % of R.
  EXPECT_LE(report.rms_distance_m, report.max_distance_m);
  EXPECT_GE(report.max_distance_m, 1e-4);
  EXPECT_LE(report.max_distance_m, 3e-3);
  EXPECT_TRUE(decimated_surface(ball, 1000000, report).triangles == ball.triangles);

  // For a picture: as few, and where the ball was (cuts are not looked at).
  const SurfaceMesh drawn = drawn_surface(ball, 400);
  EXPECT_LE(drawn.triangles.rows(), 400);
  EXPECT_NEAR(volume(drawn), volume(ball), 0.03 * volume(ball));
  EXPECT_TRUE(drawn_surface(ball, 1000000).triangles == ball.triangles);
  EXPECT_EQ(report.n_faces_after, report.n_faces_before);
}

TEST(LoadBody, SaysWhatItMendedAndWarnsOfUnitsAndOfSeveralBodies) {
  const auto path = std::filesystem::temp_directory_path() / ("klang-split-" + std::to_string(::getpid()) + ".off");
  const SurfaceMesh box = split(bodies()[1]);
  std::string text =
      "OFF\r\n" + std::to_string(box.vertices_m.rows()) + " " + std::to_string(box.triangles.rows()) + " 0\r\n";
  for (Eigen::Index v = 0; v < box.vertices_m.rows(); ++v)
    text += to_text(1000 * box.vertices_m(v, 0)) + " " + to_text(1000 * box.vertices_m(v, 1)) + " " +
            to_text(1000 * box.vertices_m(v, 2)) + "\r\n";
  for (Eigen::Index t = 0; t < box.triangles.rows(); ++t)
    text += "3 " + std::to_string(3 * t) + " " + std::to_string(3 * t + 1) + " " + std::to_string(3 * t + 2) + "\r\n";
  write_file(path, text);
  std::vector<std::string> notes;
  BodyNotes told;
  told.note = [&](const std::string& line) { notes.push_back(line); };
  const TetMesh mesh = load_body(path, {}, &told);
  std::filesystem::remove(path);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("repeated corners welded"), std::string::npos);
  EXPECT_GT(told.repairs->n_welded_vertices, 0);
  EXPECT_LE(std::abs(mesh_volume_m3(mesh) / (200.0 * 150.0 * 2.0) - 1.0), 1e-9);
  const std::vector<std::string> long_body = body_warnings(mesh, 1.0, "--unit-m");
  ASSERT_EQ(long_body.size(), 1U);
  EXPECT_NE(long_body[0].find("200 m long"), std::string::npos);
  EXPECT_NE(long_body[0].find("--unit-m 0.001"), std::string::npos);
  TetMesh small = mesh;
  small.nodes_m *= 1e-6;
  EXPECT_NE(body_warnings(small, 0.001, "--unit-m").at(0).find("--unit-m 1 "), std::string::npos);
  small.nodes_m *= 1e3;
  EXPECT_TRUE(body_warnings(small, 1.0, "--unit-m").empty());
  TetMesh two = small;
  two.nodes_m.conservativeResize(2 * small.n_nodes(), 3);
  two.nodes_m.bottomRows(small.n_nodes()) = small.nodes_m.array() + 1.0;
  two.elements.conservativeResize(2 * small.n_elements(), small.elements.cols());
  two.elements.bottomRows(small.n_elements()) = small.elements.array() + small.n_nodes();
  EXPECT_NE(body_warnings(two, 1.0, "--unit-m").at(0).find("2 bodies"), std::string::npos);
}
