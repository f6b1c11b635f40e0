#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/detail/narrow_facets.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/refinement.hpp"
#include "core/geometry/mesh/slits.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "tests/core/geometry/mesh/mesh_checks.hpp"
#include "tests/core/physics/fracture/dynamic/lattice.hpp"

using namespace klang;
using namespace klang::mesh;
using klang::mesh::test::expect_conforming;
using klang::mesh::test::expect_input_error;

namespace {

/// The outside of a box of half lengths h around c; inward turns the faces into the box.
SurfaceMesh box_surface(const Eigen::Vector3d& c, const Eigen::Vector3d& h, bool inward = false) {
  SurfaceMesh surface;
  surface.vertices_m.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    surface.vertices_m.row(i) << c[0] + (i & 1 ? h[0] : -h[0]), c[1] + (i & 2 ? h[1] : -h[1]),
        c[2] + (i & 4 ? h[2] : -h[2]);
  surface.triangles.resize(12, 3);
  surface.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3,
      7, 1, 7, 5;
  if (inward) surface.triangles.col(1).swap(surface.triangles.col(2));
  return surface;
}

SurfaceMesh joined(const SurfaceMesh& a, const SurfaceMesh& b) {
  SurfaceMesh both;
  both.vertices_m.resize(a.vertices_m.rows() + b.vertices_m.rows(), 3);
  both.vertices_m << a.vertices_m, b.vertices_m;
  both.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  both.triangles << a.triangles, (b.triangles.array() + static_cast<int>(a.vertices_m.rows())).matrix();
  return both;
}

const SurfaceMesh kBox = box_surface({0, 0, 0}, {0.5, 1.0, 1.5});

SurfaceMesh ball_surface(double radius_m, int refinement) {
  const ShapeDivisions divisions{{2 << refinement, 2 << refinement, 1}};
  return boundary_surface(mesh_shape({"sphere", {{"radius_m", radius_m}}, {}}, divisions, 1));
}

std::string text_of(const SurfaceMesh& s, const std::string& kind) {
  std::string text;
  const auto vertex = [&](int v) {
    return to_text(s.vertices_m(v, 0)) + " " + to_text(s.vertices_m(v, 1)) + " " + to_text(s.vertices_m(v, 2));
  };
  const int n_v = static_cast<int>(s.vertices_m.rows()), n_t = static_cast<int>(s.triangles.rows());
  if (kind == "stl") {
    text = "solid a\n";
    for (int t = 0; t < n_t; ++t) {
      text += "facet normal 0 0 0\n outer loop\n";
      for (int c = 0; c < 3; ++c) text += "  vertex " + vertex(s.triangles(t, c)) + "\n";
      text += " endloop\nendfacet\n";
    }
    return text + "endsolid a\n";
  }
  if (kind == "off") text = "OFF # comment\n" + std::to_string(n_v) + " " + std::to_string(n_t) + " 0\n";
  if (kind == "ply")
    text = "ply\nformat ascii 1.0\ncomment x\nelement vertex " + std::to_string(n_v) +
           "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(n_t) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int v = 0; v < n_v; ++v) text += (kind == "obj" ? "v " : "") + vertex(v) + "\n";
  for (int t = 0; t < n_t; ++t) {
    text += kind == "obj" ? "f" : "3";
    for (int c = 0; c < 3; ++c)
      text +=
          " " + (kind == "obj" ? std::to_string(s.triangles(t, c) + 1) + "/1/1" : std::to_string(s.triangles(t, c)));
    text += "\n";
  }
  return text;
}

template <class T>
void put(std::string& bytes, T value, bool swapped) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes += raw[swapped ? sizeof(T) - 1 - i : i];
}

std::string binary_ply(const SurfaceMesh& s, bool big_endian) {
  std::string bytes = std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
                      " 1.0\nelement vertex " + std::to_string(s.vertices_m.rows()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face " +
                      std::to_string(s.triangles.rows()) + "\nproperty list uchar uint vertex_index\nend_header\n";
  for (int v = 0; v < s.vertices_m.rows(); ++v) {
    for (int a = 0; a < 3; ++a) put(bytes, static_cast<float>(s.vertices_m(v, a)), big_endian);
    bytes += '\x7f';
  }
  for (int t = 0; t < s.triangles.rows(); ++t) {
    bytes += '\3';
    for (int c = 0; c < 3; ++c) put(bytes, static_cast<std::uint32_t>(s.triangles(t, c)), big_endian);
  }
  return bytes;
}

void check(const SurfaceMesh& surface) { check_closed_surface(surface, "s.stl"); }

}  // namespace

TEST(SurfaceFile, EveryFormatGivesTheSameBox) {
  const auto stl = std::filesystem::temp_directory_path() / ("klang-box-" + std::to_string(::getpid()) + ".stl");
  write_stl(stl, kBox);
  const std::vector<std::pair<std::string, std::string>> files{
      {".stl", text_of(kBox, "stl")},  {".STL", read_file(stl)},       {".obj", text_of(kBox, "obj")},
      {".off", text_of(kBox, "off")},  {".ply", text_of(kBox, "ply")}, {".ply", binary_ply(kBox, false)},
      {".ply", binary_ply(kBox, true)}};
  std::filesystem::remove(stl);
  for (const auto& [extension, bytes] : files) {
    SCOPED_TRACE(extension + " " + bytes.substr(0, 40));
    const SurfaceMesh surface = read_surface_bytes(bytes, extension, "box");
    EXPECT_EQ(surface.vertices_m.rows(), 8);  // STL vertices are welded
    ASSERT_EQ(surface.triangles.rows(), 12);
    for (int t = 0; t < 12; ++t)
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(surface.vertices_m.row(surface.triangles(t, c)), kBox.vertices_m.row(kBox.triangles(t, c)));
    EXPECT_LE(std::abs(check_closed_surface(surface, "box").volume_m3 - 6.0), 1e-12);
  }
}

TEST(SurfaceFile, QuadrilateralsAndNegativeIndicesOfObjAreTriangulated) {
  std::string text;
  for (int v = 0; v < 8; ++v)
    text += "v " + to_text(kBox.vertices_m(v, 0)) + " " + to_text(kBox.vertices_m(v, 1)) + " " +
            to_text(kBox.vertices_m(v, 2)) + "\n";
  text += "f 1 3 4 2\nf 5//1 6//1 8//1 7//1\nf -8 -7 -3 -4\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  EXPECT_LE(std::abs(check_closed_surface(read_surface_bytes(text, ".obj", "q"), "q").volume_m3 - 6.0), 1e-12);
}

TEST(SurfaceFile, EachBrokenFileIsOneErrorThatNamesThePlace) {
  const auto read = [](const std::string& text, const char* extension) { read_surface_bytes(text, extension, "f"); };
  expect_input_error([&] { read("", ".stl"); }, {"empty"});
  expect_input_error([&] { read("solid a\nendsolid\n", ".stl"); }, {"no faces"});
  std::string stl = text_of(kBox, "stl");
  stl.replace(stl.find("vertex") + 7, 4, "nan ");
  expect_input_error([&] { read(stl, ".stl"); }, {"line 4", "face 0", "not finite"});
  expect_input_error([&] { read(text_of(kBox, "stl").substr(0, 300), ".stl"); }, {"ends"});
  expect_input_error([&] { read("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ".off"); },
                     {"face 0", "out of range", "3"});
  expect_input_error([&] { read("OFF\n2000000000 1 0\n0 0 0\n", ".off"); }, {"vertex count"});
  expect_input_error([&] { read("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", ".off"); }, {"face 0", "corners"});
  expect_input_error([&] { read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", ".obj"); }, {"face 0", "out of range", "3"});
  expect_input_error([&] { read("v 0 0 0\nv 1 0 inf\n", ".obj"); }, {"line 2", "vertex 1", "not finite"});
  expect_input_error([&] { read("v 0 0 0\nf 1 0 1\n", ".obj"); }, {"line 2", "face 0"});
  expect_input_error([&] { read(text_of(kBox, "ply").substr(0, 60), ".ply"); }, {"header"});
  std::string between = text_of(kBox, "ply");
  between = between.substr(0, between.rfind('\n', between.size() - 2) + 1);
  expect_input_error([&] { read(between + "3 0 1.5 2\n", ".ply"); }, {"out of range", "1.5"});
  expect_input_error([&] { read(between + "3.5 0 1 2\n", ".ply"); }, {"list count", "3.5"});
  const std::string ply = binary_ply(kBox, false);
  expect_input_error([&] { read(ply.substr(0, ply.size() - 1), ".ply"); }, {"byte", "ends"});
  expect_input_error([&] { read("ply\nformat ascii 1.0\nelement vertex 99999999\nend_header\n", ".ply"); }, {"vertex"});
  std::string binary_stl(84, '\0');
  binary_stl[80] = 2;
  expect_input_error([&] { read(binary_stl + std::string(60, 'x'), ".stl"); }, {"face 1", "ends"});
  expect_input_error([&] { read(std::string(80, 'x') + "\xff\xff\xff\x7f", ".stl"); }, {"face count"});
}

TEST(SurfaceCheck, EachFaultIsOneErrorThatNamesTheFirstBadFace) {
  EXPECT_NO_THROW(check(kBox));
  SurfaceMesh s = kBox;
  s.vertices_m(5, 1) = std::nan("");
  expect_input_error([&] { check(s); }, {"s.stl", "face 2", "vertex 5", "not finite"});
  s = kBox;
  s.triangles(7, 2) = 8;
  expect_input_error([&] { check(s); }, {"face 7", "out of range", "8"});
  s = kBox;
  s.triangles(4, 1) = s.triangles(4, 0);
  expect_input_error([&] { check(s); }, {"face 4", "degenerate"});
  s = kBox;
  s.vertices_m.row(1) = s.vertices_m.row(0) * 0.5 + s.vertices_m.row(3) * 0.5;  // onto the diagonal of faces 0 and 1
  expect_input_error([&] { check(s); }, {"face 1", "degenerate", "no area"});
  s = kBox;
  s.triangles = kBox.triangles.topRows(11).eval();
  expect_input_error([&] { check(s); }, {"open edge", "face"});
  s = kBox;
  s.triangles.row(3).swap(s.triangles.row(3));
  std::swap(s.triangles(3, 1), s.triangles(3, 2));
  expect_input_error([&] { check(s); }, {"face 2", "face 3", "orientation"});
  expect_input_error([&] { check(box_surface({0, 0, 0}, {1, 1, 1}, true)); }, {"face 0", "inside-out"});
}

TEST(SurfaceCheck, ThreeFacesOnOneEdgeAreNonManifold) {
  // Two boxes that share an edge, vertices and all.
  SurfaceMesh s = joined(box_surface({-1, -1, 0}, {1, 1, 1}), box_surface({1, 1, 0}, {1, 1, 1}));
  for (Eigen::Index t = 0; t < s.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) {
      if (s.triangles(t, c) == 8) s.triangles(t, c) = 3;
      if (s.triangles(t, c) == 12) s.triangles(t, c) = 7;
    }
  expect_input_error([&] { check(s); }, {"non-manifold", "shared by 4 faces", "face 7"});
}

TEST(SurfaceCheck, SelfIntersectionsAreFoundWhereverTheyAre) {
  // Two boxes that cut each other; one that only touches along a face; one apart.
  const SurfaceMesh big = box_surface({0, 0, 0}, {1, 1, 1});
  expect_input_error([&] { check(joined(big, box_surface({0.9, 0.8, 0.7}, {0.5, 0.5, 0.5}))); }, {"intersect", "face"});
  expect_input_error([&] { check(joined(big, box_surface({1.5, 0.1, 0.2}, {0.5, 0.5, 0.5}))); }, {"intersect"});
  EXPECT_NO_THROW(check(joined(big, box_surface({1.6, 0, 0}, {0.5, 0.5, 0.5}))));
  // A corner of the box pushed out through a side.
  SurfaceMesh s = kBox;
  s.vertices_m.row(0) << 0.7, 0.1, 0.2;
  expect_input_error([&] { check(s); }, {"intersect"});
  // A needle a millionth thick through a fine ball.
  const SurfaceMesh ball = ball_surface(1.0, 1);
  EXPECT_NO_THROW(check(ball));
  expect_input_error([&] { check(joined(ball, box_surface({0.01, 0.02, 0}, {1e-6, 1e-6, 3.0}))); }, {"intersect"});
}

TEST(SurfaceCheck, TheSamePairIsNamedOnAnyNumberOfThreads) {
  SurfaceMesh s = joined(ball_surface(1.0, 1), ball_surface(1.0, 1));
  for (Eigen::Index v = s.vertices_m.rows() / 2; v < s.vertices_m.rows(); ++v) s.vertices_m(v, 0) += 0.5;
  std::string first;
  for (const int n_threads : {1, 2, 4}) {
    set_thread_count(n_threads);
    try {
      check(s);
      ADD_FAILURE();
    } catch (const InputError& error) {
      if (first.empty()) first = error.what();
      EXPECT_EQ(first, error.what());
    }
  }
  set_thread_count(0);
}

TEST(SurfaceCheck, HollowsAreToldFromBodies) {
  const SurfaceMesh hollow = joined(box_surface({0, 0, 0}, {1, 1, 1}), box_surface({0, 0, 0}, {0.5, 0.5, 0.5}, true));
  const SurfaceParts parts = check_closed_surface(hollow, "h");
  EXPECT_EQ(parts.n_parts, 2);
  EXPECT_LE(std::abs(parts.volume_m3 - 7.0), 1e-12);
  ASSERT_EQ(parts.point_in_hollow.size(), 1U);
  EXPECT_LE(parts.point_in_hollow[0].cwiseAbs().maxCoeff(), 0.5);
  expect_input_error(
      [&] {
        check(joined(box_surface({0, 0, 0}, {1, 1, 1}), box_surface({0, 0, 0}, {0.5, 0.5, 0.5})));
      },
      {"face 12", "inside-out"});
}

TEST(Tetgen, FillsBoxHollowAndBallWithExactlyTheirVolume) {
  TetgenOptions options;
  options.max_edge_m = 0.4;
  const SurfaceMesh hollow = joined(box_surface({0, 0, 0}, {1, 1, 1}), box_surface({0, 0, 0}, {0.5, 0.5, 0.5}, true));
  const SurfaceMesh ball = ball_surface(1.0, 1);
  for (const auto& [surface, volume] : std::vector<std::pair<SurfaceMesh, double>>{
           {kBox, 6.0}, {hollow, 7.0}, {ball, check_closed_surface(ball, "").volume_m3}}) {
    const TetMesh mesh = mesh_surface(surface, options, "s");
    EXPECT_EQ(mesh.order(), 2);
    expect_conforming(mesh);
    const MeshQuality quality = mesh_quality(mesh);
    EXPECT_LE(std::abs(quality.volume_m3 / volume - 1.0), 1e-12);
    EXPECT_LE(quality.longest_edge_m, 0.4 * 1.001);
    EXPECT_GE(quality.min_dihedral_deg, 5.0);
    EXPECT_FALSE(mesh.node_sets.at("surface").empty());
  }
}

TEST(Tetgen, ConvexStonesOfTwelveCornersAreFilledWhateverTheirAngles) {
  // Corners on an ellipsoid by a fixed recurrence; the hull's facets are the triples with all others on one side.
  std::uint64_t state = 1;
  const auto uniform = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11U) * 0x1.0p-53;
  };
  for (int stone = 0; stone < 6; ++stone) {
    SurfaceMesh surface;
    surface.vertices_m.resize(12, 3);
    for (int i = 0; i < 12; ++i) {
      const double z = 2.0 * uniform() - 1.0, phi = 2.0 * M_PI * uniform(), r = std::sqrt(1.0 - z * z);
      surface.vertices_m.row(i) << 0.05 * r * std::cos(phi), 0.04 * r * std::sin(phi), 0.03 * z;
    }
    const auto at = [&](int i) -> Eigen::Vector3d { return surface.vertices_m.row(i).transpose(); };
    std::vector<Eigen::RowVector3i> facets;
    for (int a = 0; a < 12; ++a)
      for (int b = a + 1; b < 12; ++b)
        for (int c = b + 1; c < 12; ++c) {
          const Eigen::Vector3d normal = (at(b) - at(a)).cross(at(c) - at(a));
          int above = 0, below = 0;
          for (int i = 0; i < 12; ++i) {
            if (i == a || i == b || i == c) continue;
            ++(normal.dot(at(i) - at(a)) > 0.0 ? above : below);
          }
          if (above == 0) facets.emplace_back(a, b, c);
          if (below == 0) facets.emplace_back(a, c, b);
        }
    surface.triangles.resize(static_cast<Eigen::Index>(facets.size()), 3);
    for (std::size_t t = 0; t < facets.size(); ++t) surface.triangles.row(static_cast<Eigen::Index>(t)) = facets[t];
    for (const double edge_m : {0.016, 0.008}) {
      TetgenOptions options;
      options.order = 1;
      options.max_edge_m = edge_m;
      const TetMesh mesh = mesh_surface(surface, options, "stone");
      expect_conforming(mesh);
      const MeshQuality quality = mesh_quality(mesh);
      const double volume = check_closed_surface(surface, "").volume_m3;
      EXPECT_LE(std::abs(quality.volume_m3 / volume - 1.0), 1e-12) << stone;
      EXPECT_LE(quality.longest_edge_m, edge_m) << stone;
      EXPECT_GE(quality.min_dihedral_deg, 2.0) << stone;
    }
  }
}

TEST(Tetgen, PrintsNothingAndLeavesStdoutAsItWas) {
  testing::internal::CaptureStdout();
  TetgenOptions options;
  options.max_edge_m = 0.5;
  mesh_surface(kBox, options, "s");
  std::printf("mine\n");
  std::fflush(stdout);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "mine\n");
}

TEST(Tetgen, TwoThreadsGiveTheSameMeshAsOne) {
  TetgenOptions options;
  options.max_edge_m = 0.5;
  const TetMesh alone = mesh_surface(kBox, options, "s");
  std::vector<TetMesh> both(4);
  for_each_job(both.size(), [&](std::size_t i) { both[i] = mesh_surface(kBox, options, "s"); });
  for (const TetMesh& mesh : both) {
    EXPECT_TRUE(mesh.nodes_m == alone.nodes_m);
    EXPECT_TRUE(mesh.elements == alone.elements);
  }
}

TEST(Tetgen, TooFineAnEdgeIsRefusedBeforeMeshing) {
  TetgenOptions options;
  options.max_edge_m = 1e-4;
  expect_input_error([&] { mesh_surface(kBox, options, "box.stl"); }, {"box.stl", "too many elements", "max_edge_m"});
  options.max_edge_m = std::nan("");
  expect_input_error([&] { mesh_surface(kBox, options, "box.stl"); }, {"max_edge_m"});
}

TEST(Refined, EightOfEachKeepTheVolumeAndMatch) {
  const TetMesh mesh = klang::test::lattice({3, 2, 2}, {0.3, 0.1, 0.2}, 0.2);
  const TetMesh fine = refined(mesh);
  EXPECT_EQ(fine.n_elements(), 8 * mesh.n_elements());
  expect_conforming(fine);
  double volume = 0.0, least = HUGE_VAL;
  for (int e = 0; e < fine.n_elements(); ++e) {
    const auto corner = [&](int c) -> Eigen::Vector3d { return fine.nodes_m.row(fine.elements(e, c)).transpose(); };
    const double own = (corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(corner(3) - corner(0)) / 6.0;
    volume += own;
    least = std::min(least, own);
  }
  EXPECT_NEAR(volume, 0.006, 1e-15);
  EXPECT_GT(least, 0.0);
}

// A slit that comes in from one face and ends inside: shut, the outside of the box is left, and it closes.
TEST(ShutSlits, LeaveTheOutsideOfABoxWithASlit) {
  const TetMesh whole = klang::test::lattice({4, 2, 2}, {0.4, 0.1, 0.1});
  for (const TetMesh& mesh :
       {to_quadratic(klang::test::slit_at(whole, 0.05, 0.2)), klang::test::slit_at(whole, 0.05, 0.2)}) {
    const SurfaceMesh surface = boundary_surface(mesh);
    ASSERT_EQ(surface.triangles.rows(), boundary_surface(whole).triangles.rows() + 2 * 2 * 4);
    const ShutSlits slits = shut_slits(surface);
    EXPECT_TRUE(slits.any);
    SurfaceMesh shut{surface.vertices_m, IndexRows(static_cast<Eigen::Index>(slits.kept.size()), 3)};
    for (Eigen::Index t = 0; t < shut.triangles.rows(); ++t)
      for (int c = 0; c < 3; ++c)
        shut.triangles(t, c) =
            slits.vertex_of[static_cast<std::size_t>(surface.triangles(slits.kept[static_cast<std::size_t>(t)], c))];
    const SurfaceParts parts = check_closed_surface(shut, "shut");
    EXPECT_EQ(parts.n_parts, 1);
    EXPECT_NEAR(parts.volume_m3, 0.004, 1e-15);
    EXPECT_THROW(check_closed_surface({surface.vertices_m, surface.triangles.leftCols(3)}, "open"), InputError);
  }
  EXPECT_FALSE(shut_slits(boundary_surface(whole)).any);
}

TEST(LoadBody, AnStlInMillimetresBecomesABodyInMetres) {
  const auto path = std::filesystem::temp_directory_path() / ("klang-load-" + std::to_string(::getpid()) + ".stl");
  write_stl(path, kBox);
  LoadOptions options;
  options.unit_m = 0.001;
  EXPECT_LE(std::abs(mesh_volume_m3(load_body(path, options)) / 6e-9 - 1.0), 1e-12);
  options.wavelength_m = 0.001;
  options.order = 1;
  EXPECT_LE(mesh_quality(load_body(path, options)).longest_edge_m, 0.001 / 8.0 * 1.001);
  std::filesystem::remove(path);
}

TEST(NarrowFacets, NeedlesAreRefusedBeforeTheyAreMeshedAndFansAreNot) {
  const auto needle = [](double width) {
    SurfaceMesh s = kBox;
    const Eigen::RowVector3d low = s.vertices_m.colwise().minCoeff(), size = s.vertices_m.colwise().maxCoeff() - low;
    for (Eigen::Index v = 0; v < s.vertices_m.rows(); ++v)
      for (int a = 0; a < 3; ++a) s.vertices_m(v, a) = (s.vertices_m(v, a) - low[a]) / size[a] * (a < 2 ? width : 1.0);
    return s;
  };
  const double n = mesh::detail::elements_along_narrow_facets(needle(1e-3));
  EXPECT_GE(n, 4e3);  // four long faces of two triangles
  EXPECT_LE(n, 2e4);
  expect_input_error([&] { mesh_surface(needle(1e-6), {}, "needle.off"); }, {"needle.off", "narrow", "elements"});

  constexpr int kCorners = 1000;  // a thin disc whose flat sides are fans about their middles
  SurfaceMesh disc;
  disc.vertices_m.resize(2 * kCorners + 2, 3);
  disc.triangles.resize(4 * kCorners, 3);
  const double pi = std::acos(-1.0), height = 2.0 * pi / kCorners;
  for (int i = 0; i < kCorners; ++i)
    for (int top : {0, 1})
      disc.vertices_m.row(2 * i + top) << std::cos(2.0 * pi * i / kCorners), std::sin(2.0 * pi * i / kCorners),
          top * height;
  for (int top : {0, 1}) disc.vertices_m.row(2 * kCorners + top) << 0.0, 0.0, top * height;
  for (int i = 0; i < kCorners; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % kCorners);
    disc.triangles.row(4 * i) << a, b, b + 1;
    disc.triangles.row(4 * i + 1) << a, b + 1, a + 1;
    disc.triangles.row(4 * i + 2) << 2 * kCorners, b, a;
    disc.triangles.row(4 * i + 3) << 2 * kCorners + 1, a + 1, b + 1;
  }
  EXPECT_LE(mesh::detail::elements_along_narrow_facets(disc), 1e4);
}
