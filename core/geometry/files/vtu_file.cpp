#include <vtkCell.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cstdint>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/detail/mesh_formats.hpp"
#include "core/geometry/files/vtk_fields.hpp"

namespace klang::mesh::detail {
namespace {

constexpr std::string_view kSetPrefix = "node_set:";

/// Keeps the first line that VTK would print.
class FirstMessage : public vtkCommand {
 public:
  static FirstMessage* New() { return new FirstMessage; }
  void Execute(vtkObject*, unsigned long, void* data) override {
    if (text.empty()) text = data != nullptr ? static_cast<const char*>(data) : "error";
  }
  std::string text;
};

void read_with_vtk(std::string_view bytes, const std::string& name, vtkUnstructuredGrid* grid) {
  if (bytes.substr(0, 4096).find("<VTKFile") == std::string_view::npos)
    throw InputError(name, "not a VTK XML file", "", "<VTKFile");
  if (bytes.substr(0, 4096).find("UnstructuredGrid") == std::string_view::npos)
    throw InputError(name, "not an unstructured grid", "", "VTKFile type UnstructuredGrid");
  if (bytes.find("</VTKFile>") == std::string_view::npos)
    throw InputError(name, "the file is truncated", "", "</VTKFile> at its end");
  check_promises(bytes, name);
  vtkNew<FirstMessage> message;
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->AddObserver(vtkCommand::ErrorEvent, message);
  reader->AddObserver(vtkCommand::WarningEvent, message);
  reader->SetReaderErrorObserver(message);
  reader->SetParserErrorObserver(message);
  reader->SetReadFromInputString(1);
  reader->SetInputString(std::string(bytes));
  try {
    reader->Update();
  } catch (const std::exception& error) {
    throw InputError(name, "the VTK reader failed", error.what());
  }
  if (!message->text.empty()) {
    // "ERROR: In file.cxx, line 1\nvtkClass (0x...): text": the last part is for people.
    const std::size_t at = message->text.find("): ");
    std::string text = at == std::string::npos ? message->text : message->text.substr(at + 3);
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    throw InputError(name, "the VTK reader refused it", text.substr(0, 200));
  }
  grid->ShallowCopy(reader->GetOutput());
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
  vtkNew<vtkUnstructuredGrid> grid;
  read_with_vtk(bytes, name, grid);
  TetMesh mesh;
  mesh.nodes_m.resize(grid->GetNumberOfPoints(), 3);
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    double x[3];
    grid->GetPoint(i, x);
    for (int a = 0; a < 3; ++a) mesh.nodes_m(i, a) = x[a];
  }
  int columns = 0;
  std::vector<std::array<int, 10>> rows;
  vtkNew<vtkIdList> ids;
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell) {
    const int type = grid->GetCellType(cell);
    const std::string element = "element " + std::to_string(cell);
    if (type != VTK_TETRA && type != VTK_QUADRATIC_TETRA) {
      vtkCell* other = grid->GetCell(cell);
      if (other == nullptr || other->GetCellDimension() == 3)
        throw InputError(name, element + " is a solid that is not a tetrahedron",
                         "VTK cell type " + std::to_string(type), "types 10 and 24");
      continue;
    }
    grid->GetCellPoints(cell, ids);
    const int n = type == VTK_TETRA ? 4 : 10;
    if (ids->GetNumberOfIds() != n)
      throw InputError(name, element + " has a wrong number of nodes", std::to_string(ids->GetNumberOfIds()),
                       std::to_string(n));
    if (columns != 0 && columns != n) throw InputError(name, element + ": linear and quadratic tetrahedra are mixed");
    columns = n;
    std::array<int, 10> row{};
    for (int c = 0; c < n; ++c) {
      const vtkIdType id = ids->GetId(c);
      if (id < 0 || id >= grid->GetNumberOfPoints())
        throw InputError(name, element + ": node out of range", std::to_string(id),
                         "0 to " + std::to_string(grid->GetNumberOfPoints() - 1));
      row[c] = static_cast<int>(id);
    }
    rows.push_back(row);
  }
  mesh.elements.resize(static_cast<Eigen::Index>(rows.size()), columns == 10 ? 10 : 4);
  for (std::size_t e = 0; e < rows.size(); ++e)
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) mesh.elements(static_cast<Eigen::Index>(e), c) = rows[e][c];
  vtkPointData* data = grid->GetPointData();
  for (int a = 0; a < data->GetNumberOfArrays(); ++a) {
    vtkDataArray* array = data->GetArray(a);
    if (array == nullptr || array->GetName() == nullptr || array->GetNumberOfTuples() != grid->GetNumberOfPoints())
      continue;
    const std::string_view array_name = array->GetName();
    if (!array_name.starts_with(kSetPrefix)) continue;
    std::vector<int>& nodes = mesh.node_sets[std::string(array_name.substr(kSetPrefix.size()))];
    for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
      if (array->GetComponent(i, 0) != 0.0) nodes.push_back(static_cast<int>(i));
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
