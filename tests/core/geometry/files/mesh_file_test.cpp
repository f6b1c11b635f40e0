#include "core/geometry/files/mesh_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>

#include "core/foundation/base/output_file.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "tests/core/geometry/mesh/mesh_checks.hpp"
#include "tests/places.hpp"

using namespace klang;
using namespace klang::mesh;
using klang::mesh::test::expect_conforming;
using klang::mesh::test::expect_input_error;

namespace {

std::filesystem::path data(const std::string& name) {
  return std::filesystem::path(klang::test::test_data()) / "mesh" / name;
}

/// The 1 x 2 x 3 brick of tests/data/mesh/make_fixtures.py.
void expect_brick(const TetMesh& mesh, int order, const std::string& base_set) {
  ASSERT_EQ(mesh.order(), order);
  EXPECT_EQ(mesh.n_elements(), 6);
  EXPECT_EQ(mesh.n_nodes(), order == 2 ? 27 : 8);  // the unused node is gone
  EXPECT_LE(std::abs(mesh_volume_m3(mesh) - 6.0), 1e-12);
  EXPECT_LE(std::abs(mesh_quality(mesh).surface_area_m2 - 22.0), 1e-11);
  EXPECT_LE(std::abs(mesh_quality(mesh).min_scaled_jacobian - 1.0), 1e-12) << "mid-nodes in a wrong order";
  expect_conforming(mesh);
  if (base_set.empty()) return;
  ASSERT_EQ(mesh.node_sets.count(base_set), 1U);
  EXPECT_EQ(mesh.node_sets.at(base_set).size(), order == 2 ? 9U : 4U);
  for (const int node : mesh.node_sets.at(base_set)) EXPECT_EQ(mesh.nodes_m(node, 2), 0.0);
}

std::string one_tet_msh(const std::string& nodes, const std::string& elements) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + nodes + "$EndNodes\n$Elements\n" + elements +
         "$EndElements\n";
}
const std::string kFourNodes = "4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";

TetMesh read_msh(const std::string& text) { return read_tet_mesh_bytes(text, ".msh", "a.msh"); }

TetMesh sample_mesh(int order) {
  ShapeMeshOptions options;
  options.order = order;
  return mesh_shape({"bowl", {{"outer_radius_m", 0.08}, {"wall_m", 0.003}, {"depth_m", 0.05}}, {}}, options);
}

}  // namespace

TEST(Gmsh, RemarksMayStandBeforeTheFormatAndBetweenSections) {
  std::string text = read_file(data("brick-22-p1.msh"));
  const TetMesh plain = read_tet_mesh_bytes(text, ".msh", "plain");
  const std::string remark = "$Comments\nmade by hand, $5\n$EndComments\n";
  text.insert(text.find("$Nodes"), remark);
  const TetMesh mesh = read_tet_mesh_bytes(remark + text, ".msh", "remarks");
  EXPECT_TRUE(mesh.nodes_m == plain.nodes_m);
  EXPECT_TRUE(mesh.elements == plain.elements);
  expect_input_error([&] { read_tet_mesh_bytes("$Comments\nno end\n", ".msh", "m"); }, {"does not end"});
}

TEST(Gmsh, EveryVersionAndEncodingGivesTheSameBrick) {
  for (const int order : {1, 2})
    for (const std::string version : {"22", "41"})
      for (const std::string encoding : {"", "-binary"}) {
        const std::string file = "brick-" + version + "-p" + std::to_string(order) + encoding + ".msh";
        SCOPED_TRACE(file);
        const TetMesh mesh = read_tet_mesh(data(file));
        expect_brick(mesh, order, "base");
        EXPECT_EQ(mesh.node_sets.size(), 1U);  // "body" names everything
      }
}

TEST(Vtu, EveryEncodingAndCompressionGivesTheSameBrick) {
  for (const auto& [file, order] : std::vector<std::pair<std::string, int>>{
           {"ascii", 1}, {"binary-zlib", 2}, {"appended-raw", 2}, {"appended-lzma", 1}, {"appended-lz4", 2}}) {
    SCOPED_TRACE(file);
    expect_brick(read_tet_mesh(data("brick-" + file + ".vtu")), order, "");
  }
}

TEST(TetgenFiles, BothOrdersAndFirstNumbersGiveTheSameBrick) {
  expect_brick(read_tet_mesh(data("brick-p1.node")), 1, "boundary_7");
  expect_brick(read_tet_mesh(data("brick-p2.ele")), 2, "boundary_7");
}

TEST(WriteTetMesh, EveryFormatReadsBackToTheLastBit) {
  const auto folder = std::filesystem::temp_directory_path() / ("klang-mesh-file-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  for (const int order : {1, 2})
    for (const auto& [name, format] :
         std::vector<std::pair<std::string, MeshFormat>>{{"a.vtu", MeshFormat::kFromExtension},
                                                         {"a.msh", MeshFormat::kFromExtension},
                                                         {"b.msh", MeshFormat::kGmsh22}}) {
      SCOPED_TRACE(name + std::to_string(order));
      const TetMesh mesh = sample_mesh(order);
      write_tet_mesh(folder / name, mesh, format);
      const TetMesh back = read_tet_mesh(folder / name);
      EXPECT_TRUE(back.nodes_m == mesh.nodes_m);
      EXPECT_TRUE(back.elements == mesh.elements);
      EXPECT_EQ(back.node_sets, mesh.node_sets);
    }
  expect_input_error([&] { write_tet_mesh(folder / "a.xyz", sample_mesh(1)); }, {".xyz", ".vtu"});
  std::filesystem::remove_all(folder);
}

TEST(ImportCheck, InvertedElementsAreTurnedRound) {
  const TetMesh mesh = read_msh(one_tet_msh(kFourNodes, "1\n1 4 2 0 1 1 3 2 4\n"));
  EXPECT_LE(std::abs(mesh_volume_m3(mesh) - 1.0 / 6.0), 1e-15);
  // Quadratic: the whole brick with two corners of every element exchanged, mid-nodes with them.
  TetMesh quadratic = to_quadratic(sample_mesh(1));
  const double volume = mesh_volume_m3(quadratic);
  for (int e = 0; e < quadratic.n_elements(); ++e) {
    const Eigen::Matrix<int, 1, 10> row = quadratic.elements.row(e);
    quadratic.elements.row(e) << row[0], row[1], row[3], row[2], row[4], row[8], row[7], row[6], row[5], row[9];
  }
  const auto path = std::filesystem::temp_directory_path() / ("klang-inverted-" + std::to_string(::getpid()) + ".vtu");
  write_tet_mesh(path, quadratic);
  EXPECT_LE(std::abs(mesh_volume_m3(read_tet_mesh(path)) / volume - 1.0), 1e-13);
  std::filesystem::remove(path);
}

TEST(ImportCheck, EachFaultIsOneErrorThatNamesTheElementOrNode) {
  const std::string good = "1\n1 4 2 0 1 1 2 3 4\n";
  EXPECT_EQ(read_msh(one_tet_msh(kFourNodes, good)).n_elements(), 1);
  expect_input_error([&] { read_msh(one_tet_msh("4\n1 0 0 0\n2 nan 0 0\n3 0 1 0\n4 0 0 1\n", good)); },
                     {"a.msh", "element 0", "node 1", "not finite"});
  expect_input_error([&] { read_msh(one_tet_msh(kFourNodes, "1\n1 4 2 0 1 1 2 3 9\n")); },
                     {"element 0", "9", "no node"});
  expect_input_error([&] { read_msh(one_tet_msh(kFourNodes, "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 3\n")); },
                     {"element 1", "repeats"});
  expect_input_error(
      [&] {
        read_msh(one_tet_msh("5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 0\n",
                             "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 5\n"));
      },
      {"element 1", "no volume"});
  expect_input_error(
      [&] { read_msh(one_tet_msh(kFourNodes, "3\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 4\n3 4 2 0 1 1 2 3 4\n")); },
      {"element 2", "third"});
  expect_input_error([&] { read_msh(one_tet_msh(kFourNodes, "1\n1 5 2 0 1 1 2 3 4 1 2 3 4\n")); },
                     {"not a tetrahedron", "type 5"});
  expect_input_error([&] { read_msh(one_tet_msh(kFourNodes, "1\n1 2 2 0 1 1 2 3\n")); }, {"no tetrahedra"});
}

TEST(ImportCheck, MidNodesThatFoldOrDisagreeAreNamed) {
  TetMesh mesh = to_quadratic(read_tet_mesh(data("brick-22-p1.msh")));
  mesh.node_sets.clear();
  const auto path = std::filesystem::temp_directory_path() / ("klang-folded-" + std::to_string(::getpid()) + ".msh");
  TetMesh folded = mesh;
  folded.nodes_m.row(folded.elements(3, 4)) =
      folded.nodes_m.row(folded.elements(3, 0)) * 0.95 + folded.nodes_m.row(folded.elements(3, 1)) * 0.05;
  write_tet_mesh(path, folded);
  expect_input_error([&] { read_tet_mesh(path); }, {"element", "folded"});
  TetMesh torn = mesh;
  torn.nodes_m.conservativeResize(mesh.n_nodes() + 1, 3);
  torn.nodes_m.row(mesh.n_nodes()) = mesh.nodes_m.row(mesh.elements(5, 7));
  torn.elements(5, 7) = mesh.n_nodes();
  write_tet_mesh(path, torn);
  expect_input_error([&] { read_tet_mesh(path); }, {"element 5", "another mid-node"});
  std::filesystem::remove(path);
}

TEST(MeshFile, TruncatedFilesAreInputErrorsAtEveryLength) {
  int n_cut = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data(""))) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".msh" && extension != ".vtu") continue;
    const std::string bytes = read_file(entry.path());
    SCOPED_TRACE(entry.path().filename().string());
    for (std::size_t length = 0; length + 14 < bytes.size(); length += 1 + bytes.size() / 150) {
      ++n_cut;
      EXPECT_THROW(read_tet_mesh_bytes(std::string_view(bytes).substr(0, length), extension, "cut"), InputError)
          << length;
    }
  }
  EXPECT_GE(n_cut, 1000);
  const std::string nodes = read_file(data("brick-p1.node")), elements = read_file(data("brick-p1.ele"));
  for (std::size_t length = 0; length + 2 < nodes.size(); length += 7)
    EXPECT_THROW(read_tetgen_bytes(std::string_view(nodes).substr(0, length), elements, "cut"), InputError) << length;
}

TEST(MeshFile, HugeCountsAreRefusedBeforeAnythingIsAllocated) {
  expect_input_error([&] { read_msh(one_tet_msh("2000000000\n1 0 0 0\n", "")); }, {"line 5", "node count", "2e+09"});
  expect_input_error([&] { read_msh(one_tet_msh(kFourNodes, "2147483647\n1 4 2 0 1 1 2 3 4\n")); }, {"element count"});
  expect_input_error([&] { read_msh("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 99999999999999\n"); },
                     {"block"});
  expect_input_error([&] { read_tetgen_bytes("2000000000 3 0 0\n0 0 0 0\n", "1 4 0\n", "a"); }, {"node count"});
  std::string vtu = read_file(data("brick-ascii.vtu"));
  vtu.replace(vtu.find("NumberOfPoints=\"9\""), 18, "NumberOfPoints=\"1999999999\"");
  expect_input_error([&] { read_tet_mesh_bytes(vtu, ".vtu", "a.vtu"); }, {"NumberOfPoints", "1999999999"});
}

TEST(MeshFile, ElementsOnOneSideOfAFaceAreRefused) {
  const std::string tet = "4 2 0 1 1 2 3 4\n";
  expect_input_error([&] { read_msh(one_tet_msh(kFourNodes, "2\n1 " + tet + "2 " + tet)); },
                     {"element 1", "same side", "element 0"});
  expect_input_error(  // the second reaches into the first
      [&] {
        read_msh(one_tet_msh("5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.1 0.1 0.5\n",
                             "2\n1 " + tet + "2 4 2 0 1 1 2 3 5\n"));
      },
      {"element 1", "same side"});
  EXPECT_EQ(read_msh(one_tet_msh("5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.1 0.1 -0.5\n",
                                 "2\n1 " + tet + "2 4 2 0 1 1 2 3 5\n"))
                .n_elements(),
            2);
}

TEST(MeshFile, WrongFilesAreNamed) {
  expect_input_error([&] { read_tet_mesh("/nowhere/a.msh"); }, {"/nowhere/a.msh"});
  expect_input_error([&] { read_tet_mesh_bytes("", ".msh", "a.msh"); }, {"empty"});
  expect_input_error([&] { read_msh("not a mesh"); }, {"line 1"});
  expect_input_error([&] { read_msh("$MeshFormat\n4.0 0 8\n"); }, {"version", "4.1"});
  expect_input_error([&] { read_tet_mesh_bytes("x", ".vtu", "a.vtu"); }, {"VTK XML"});
  expect_input_error([&] { read_tet_mesh_bytes("x", ".step", "a.step"); }, {".step", ".msh"});
}

TEST(LoadBody, TetrahedraComeInTheOrderAndUnitAskedFor) {
  LoadOptions options;
  options.unit_m = 0.001;
  const TetMesh quadratic = load_body(data("brick-22-p1.msh"), options);
  EXPECT_EQ(quadratic.order(), 2);
  EXPECT_LE(std::abs(mesh_volume_m3(quadratic) - 6e-9), 1e-20);
  EXPECT_EQ(quadratic.node_sets.at("base").size(), 9U);
  options.order = 1;
  EXPECT_EQ(load_body(data("brick-41-p2-binary.msh"), options).order(), 1);
  options.unit_m = 0.0;
  expect_input_error([&] { load_body(data("brick-22-p1.msh"), options); }, {"unit_m"});
}

TEST(LoadBody, FilesInMillimetresAndOfTwoBodiesAreWarnedOf) {
  const std::vector<std::string> large = body_warnings(load_body(data("block-in-mm.vtu")), 1.0, "--unit-m");
  ASSERT_EQ(large.size(), 1U);
  EXPECT_NE(large[0].find("100 m long"), std::string::npos) << large[0];
  EXPECT_NE(large[0].find("--unit-m 0.001"), std::string::npos) << large[0];
  const std::vector<std::string> two = body_warnings(load_body(data("two-blocks.vtu")), 1.0, "--unit-m");
  ASSERT_EQ(two.size(), 1U);
  EXPECT_NE(two[0].find("2 bodies"), std::string::npos) << two[0];
}
