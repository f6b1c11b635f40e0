#include "core/geometry/files/vtk_xml.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "core/foundation/base/output_file.hpp"
#include "tests/core/geometry/mesh/mesh_checks.hpp"
#include "tests/places.hpp"

using namespace klang;
using namespace klang::mesh;
using klang::mesh::test::expect_input_error;

namespace {

std::string brick(const std::string& encoding = "ascii") {
  return read_file(std::filesystem::path(klang::test::test_data()) / "mesh" / ("brick-" + encoding + ".vtu"));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

VtkXmlFile grid(const std::string& text) { return {text, "a.vtu", "UnstructuredGrid"}; }
void read_all(const VtkXmlFile& file) {
  file.points();
  file.cells();
  for (const VtkPlace place : {VtkPlace::kPointData, VtkPlace::kCellData, VtkPlace::kFieldData})
    for (const std::string& array : file.array_names(place)) file.find(place, array);
}
void expect_refused(const std::string& text, const std::vector<std::string>& parts) {
  expect_input_error([&] { read_all(grid(text)); }, parts);
}

/// A square of two triangles, cut by one piece into its points and cells.
std::string square(const std::string& cells, const std::string& more = {}) {
  return "<VTKFile type='PolyData' byte_order='LittleEndian'><PolyData><Piece NumberOfPoints='4' " + cells +
         "><Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>0 0 0 1 0 0 1 1 0 0 1 0</DataArray>"
         "</Points><Polys><DataArray type='Int32' Name='connectivity'>0 1 2 0 2 3</DataArray><DataArray type='Int32' "
         "Name='offsets'>3 6</DataArray></Polys>" +
         more + "</Piece></PolyData></VTKFile>";
}

}  // namespace

TEST(VtkXml, EveryEncodingHoldsTheSameBrick) {
  std::map<std::int64_t, VtkXmlFile> first;  // by number of points: linear and quadratic
  int n_compared = 0;
  for (const std::string encoding : {"ascii", "binary-zlib", "appended-raw", "appended-lz4", "appended-lzma"}) {
    SCOPED_TRACE(encoding);
    const VtkXmlFile other = grid(brick(encoding));
    const auto [same, is_new] = first.try_emplace(other.n_points(), grid(brick(encoding)));
    if (is_new) continue;
    ++n_compared;
    EXPECT_EQ(other.points(), same->second.points());
    EXPECT_EQ(other.cells().connectivity, same->second.cells().connectivity);
    EXPECT_EQ(other.cells().offsets, same->second.cells().offsets);
    EXPECT_EQ(other.cells().types, same->second.cells().types);
  }
  EXPECT_GE(n_compared, 3);
}

TEST(VtkXml, HeaderAndDataMayBeTwoBase64Streams) {
  const auto with = [](const std::string& data) {
    return "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><FieldData><DataArray type='UInt8' Name='a' "
           "format='binary'>" +
           data + "</DataArray></FieldData><Piece NumberOfPoints='0' NumberOfCells='0'/></UnstructuredGrid></VTKFile>";
  };
  const std::vector<std::int64_t> wanted{1, 2, 3, 4};
  EXPECT_EQ(grid(with("BAAAAAECAwQ=")).find(VtkPlace::kFieldData, "a")->integers, wanted);
  EXPECT_EQ(grid(with(" BAAAAA==\nAQIDBA== ")).find(VtkPlace::kFieldData, "a")->integers, wanted);
  expect_refused(with("BAAAAAEC"), {"array a", "too early"});
  expect_refused(with("BAAAAAE!AwQ="), {"array a", "base64"});
  expect_refused(with("/////wECAwQ="), {"array a", "length of the file"});
}

TEST(VtkXml, PiecesFollowEachOther) {
  const std::string piece =
      "<Piece NumberOfPoints='1' NumberOfCells='1'><PointData><DataArray type='Int8' Name='a'>7</DataArray></PointData>"
      "<Points><DataArray type='Float64' NumberOfComponents='3'>1 2 3</DataArray></Points><Cells><DataArray "
      "type='Int64' Name='connectivity'>0</DataArray><DataArray type='Int64' Name='offsets'>1</DataArray><DataArray "
      "type='UInt8' Name='types'>1</DataArray></Cells></Piece>";
  const VtkXmlFile two =
      grid("<VTKFile type='UnstructuredGrid'><UnstructuredGrid>" + piece + piece + "</UnstructuredGrid></VTKFile>");
  EXPECT_EQ(two.n_points(), 2);
  EXPECT_EQ(two.cells().connectivity, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(two.cells().offsets, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(two.find(VtkPlace::kPointData, "a")->integers, (std::vector<std::int64_t>{7, 7}));
}

TEST(VtkXml, CountsAndIndicesThatLieAreNamed) {
  expect_refused(replaced(brick(), "NumberOfPoints=\"9\"", "NumberOfPoints='1500000000'"), {"NumberOfPoints"});
  expect_refused(replaced(brick(), "NumberOfPoints=\"9\"", "NumberOfPoints=\"0\""), {"out of range"});
  expect_refused(replaced(brick(), "NumberOfPoints=\"9\"", "NumberOfPoints=\"-9\""), {"NumberOfPoints"});
  expect_refused(replaced(brick(), "NumberOfPoints=\"9\"", "NumberOfPoints=\"8\""), {"wrong number of values", "24"});
  expect_refused(replaced(brick(), "NumberOfCells=\"8\"", "NumberOfCells=\"9\""), {"offsets", "wrong number"});
  expect_refused(replaced(brick(), "0 1 3 7 0 5", "0 1 3 999999 0 5"), {"element 2", "out of range", "0 to 8"});
  expect_refused(replaced(brick(), "0 1 3 7 0 5", "0 1 3 -1 0 5"), {"element 2", "out of range"});
  expect_refused(replaced(brick(), "0 1 3 7 0 5", "0 1 3 0.5 0 5"), {"connectivity", "no integer", "0.5"});
  expect_refused(replaced(brick(), "<Points>", "<Point>"), {"is no XML"});
  expect_refused(replaced(brick(), "header_type=\"UInt32\"", "header_type=\"UInt16\""), {"header_type", "UInt16"});
  expect_refused(replaced(brick("appended-raw"), "header_type=\"UInt32\"", "header_type=\"UInt64\""), {"array "});
  expect_refused(replaced(brick("appended-raw"), "offset=\"0\"", "offset=\"99999999\""), {"offset"});
}

TEST(VtkXml, ElementsNestedDeepOrWithoutEndAreRefused) {
  std::string deep;
  for (int i = 0; i < 300000; ++i) deep += "<a>";
  expect_refused(replaced(brick(), "<PointData>", deep + "<PointData>"), {"a.vtu"});
  std::string many;
  for (int i = 0; i < 500000; ++i) many += "<a/>";
  expect_refused(replaced(brick(), "<PointData>", many + "<PointData>"), {"too many XML elements"});
  expect_refused(replaced(brick(), "<Cells>", "<Cells/><Cells>"), {"Cells is there twice"});
}

TEST(VtkXml, PolygonsKeepVtksOrderAndTypes) {
  const std::string vertex =
      "<Verts><DataArray type='Int32' Name='connectivity'>3</DataArray><DataArray type='Int32' Name='offsets'>1"
      "</DataArray></Verts>";
  const VtkXmlFile file(square("NumberOfVerts='1' NumberOfPolys='2'", vertex), "a.vtp", "PolyData");
  EXPECT_EQ(file.cells().types, (std::vector<int>{1, 5, 5}));
  EXPECT_EQ(file.cells().connectivity, (std::vector<std::int64_t>{3, 0, 1, 2, 0, 2, 3}));
  for (const std::string lie : {"NumberOfVerts='1000000000' NumberOfPolys='2'", "NumberOfPolys='1000000000'",
                                "NumberOfLines='5' NumberOfPolys='2'", "NumberOfStrips='1' NumberOfPolys='2'"})
    EXPECT_THROW(VtkXmlFile(square(lie), "a.vtp", "PolyData").cells(), InputError) << lie;
  EXPECT_THROW(VtkXmlFile(square("NumberOfPolys='2'"), "a.vtp", "UnstructuredGrid"), InputError);
}

TEST(VtkXml, AnyByteChangedIsReadOrRefused) {
  for (const std::string encoding : {"ascii", "binary-zlib", "appended-raw", "appended-lz4", "appended-lzma"}) {
    const std::string whole = brick(encoding);
    for (std::size_t i = 0; i < whole.size(); i += 3) {
      std::string text = whole;
      text[i] = static_cast<char>(text[i] ^ (1 << i % 8));
      try {
        read_all(grid(text));
      } catch (const InputError&) {
      }
    }
  }
}
