#include <vtkCellType.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/detail/mesh_formats.hpp"
#include "core/geometry/files/vtk_xml.hpp"

namespace klang::mesh::detail {
namespace {

constexpr std::string_view kSetPrefix = "node_set:";

/// Vertices, lines and faces, which are left out; what else is no tetrahedron is refused.
bool is_no_solid(int type) {
  static constexpr int kTypes[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  21, 22,
                                   23, 28, 30, 34, 35, 36, 68, 69, 70, 75, 76, 77};
  return std::find(std::begin(kTypes), std::end(kTypes), type) != std::end(kTypes);
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <class T>
std::string data_array(const std::string& name, const char* type, int n_components, const std::vector<T>& values) {
  std::string bytes;
  const std::uint64_t n_bytes = values.size() * sizeof(T);
  bytes.append(reinterpret_cast<const char*>(&n_bytes), sizeof n_bytes);
  if (n_bytes > 0) bytes.append(reinterpret_cast<const char*>(values.data()), n_bytes);
  return "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(n_components) + "\" format=\"binary\">" + base64(bytes) + "</DataArray>\n";
}

std::string xml_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

}  // namespace

TetMesh read_vtu(std::string_view bytes, const std::string& name) {
  const VtkXmlFile file(std::string(bytes), name, "UnstructuredGrid");
  TetMesh mesh;
  mesh.nodes_m = file.points();
  const VtkCells cells = file.cells();
  int columns = 0;
  std::vector<std::array<int, 10>> rows;
  for (std::size_t cell = 0; cell < cells.types.size(); ++cell) {
    const int type = cells.types[cell];
    const std::string element = "element " + std::to_string(cell);
    if (type != VTK_TETRA && type != VTK_QUADRATIC_TETRA) {
      if (is_no_solid(type)) continue;
      throw InputError(name, element + " is a solid that is not a tetrahedron", "VTK cell type " + std::to_string(type),
                       "types 10 and 24");
    }
    const std::int64_t begin = cells.begin(cell), n_corners = cells.offsets[cell] - begin;
    const int n = type == VTK_TETRA ? 4 : 10;
    if (n_corners != n)
      throw InputError(name, element + " has a wrong number of nodes", std::to_string(n_corners), std::to_string(n));
    if (columns != 0 && columns != n) throw InputError(name, element + ": linear and quadratic tetrahedra are mixed");
    columns = n;
    std::array<int, 10> row{};
    for (int c = 0; c < n; ++c) row[c] = static_cast<int>(cells.connectivity[static_cast<std::size_t>(begin + c)]);
    rows.push_back(row);
  }
  mesh.elements.resize(static_cast<Eigen::Index>(rows.size()), columns == 10 ? 10 : 4);
  for (std::size_t e = 0; e < rows.size(); ++e)
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) mesh.elements(static_cast<Eigen::Index>(e), c) = rows[e][c];
  for (const std::string& array_name : file.array_names(VtkPlace::kPointData)) {
    if (!array_name.starts_with(kSetPrefix)) continue;
    const std::optional<VtkArray> array = file.find(VtkPlace::kPointData, array_name);
    if (!array) continue;
    std::vector<int>& nodes = mesh.node_sets[array_name.substr(kSetPrefix.size())];
    const auto step = static_cast<std::size_t>(array->n_components);
    for (std::size_t i = 0; i * step < array->size(); ++i)
      if (array->number(i * step) != 0.0) nodes.push_back(static_cast<int>(i));
  }
  return mesh;
}

std::string vtu_text(const TetMesh& mesh) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
      std::to_string(mesh.n_nodes()) + "\" NumberOfCells=\"" + std::to_string(mesh.n_elements()) + "\">\n<PointData>\n";
  for (const auto& [set, nodes] : mesh.node_sets) {
    std::vector<std::uint8_t> in_set(mesh.n_nodes(), 0);
    for (const int node : nodes) in_set[node] = 1;
    text += data_array(std::string(kSetPrefix) + xml_text(set), "UInt8", 1, in_set);
  }
  text += "</PointData>\n<Points>\n" +
          data_array("points_m", "Float64", 3,
                     std::vector<double>(mesh.nodes_m.data(), mesh.nodes_m.data() + mesh.nodes_m.size()));
  const std::int64_t n_columns = mesh.elements.cols();
  std::vector<std::int64_t> offsets;
  for (std::int64_t e = 1; e <= mesh.n_elements(); ++e) offsets.push_back(e * n_columns);
  text += "</Points>\n<Cells>\n" +
          data_array("connectivity", "Int64", 1,
                     std::vector<std::int64_t>(mesh.elements.data(), mesh.elements.data() + mesh.elements.size())) +
          data_array("offsets", "Int64", 1, offsets) +
          data_array("types", "UInt8", 1,
                     std::vector<std::uint8_t>(mesh.n_elements(), n_columns == 10 ? VTK_QUADRATIC_TETRA : VTK_TETRA));
  return text + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace klang::mesh::detail
