#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <cstdio>

#include "core/geometry/files/vtk_fields.hpp"
#include "core/physics/modal/modal_model.hpp"

namespace klang::modal {
namespace {

using mesh::add_integers;
using mesh::add_numbers;
using mesh::add_text;
using mesh::GridFile;
using mesh::write_grid;

constexpr int kFileVersion = 1;
constexpr int kLinearTet = 10;     // VTK_TETRA
constexpr int kQuadraticTet = 24;  // VTK_QUADRATIC_TETRA: the node order of mesh::TetMesh
constexpr const char* kNodeSetPrefix = "node_set:";

std::string mode_name(Eigen::Index k) {
  char name[32];
  std::snprintf(name, sizeof name, "mode_%04ld", static_cast<long>(k));
  return name;
}

mesh::TetMesh read_mesh(vtkUnstructuredGrid* grid, const GridFile& parts) {
  mesh::TetMesh mesh;
  auto* points = grid->GetPoints() == nullptr ? nullptr : vtkDoubleArray::SafeDownCast(grid->GetPoints()->GetData());
  if (points == nullptr || points->GetNumberOfComponents() != 3) parts.fail("points of double precision are missing");
  const vtkIdType n_nodes = points->GetNumberOfTuples();
  mesh.nodes_m = Eigen::Map<const mesh::Points>(points->GetPointer(0), n_nodes, 3);
  const vtkIdType n_elements = grid->GetNumberOfCells();
  const int type = n_elements > 0 ? grid->GetCellType(0) : 0;
  if (type != kLinearTet && type != kQuadraticTet) parts.fail("its cells are not tetrahedra");
  const int n_corners = type == kLinearTet ? 4 : 10;
  mesh.elements.resize(n_elements, n_corners);
  for (vtkIdType e = 0; e < n_elements; ++e) {
    vtkIdType n = 0;
    const vtkIdType* nodes = nullptr;
    grid->GetCellPoints(e, n, nodes);
    if (grid->GetCellType(e) != type || n != n_corners) parts.fail("cells of several kinds");
    for (int k = 0; k < n_corners; ++k) {
      if (nodes[k] < 0 || nodes[k] >= n_nodes) parts.fail("a cell names a point that is not there");
      mesh.elements(e, k) = static_cast<int>(nodes[k]);
    }
  }
  auto* fields = grid->GetFieldData();
  const std::string prefix = kNodeSetPrefix;
  for (int k = 0; k < fields->GetNumberOfArrays(); ++k) {
    auto* array = vtkIntArray::SafeDownCast(fields->GetAbstractArray(k));
    if (array == nullptr || array->GetName() == nullptr) continue;
    const std::string name = array->GetName();
    if (!name.starts_with(prefix)) continue;
    auto& set = mesh.node_sets[name.substr(prefix.size())];
    for (vtkIdType i = 0; i < array->GetNumberOfValues(); ++i) {
      const int node = array->GetValue(i);
      if (node < 0 || node >= n_nodes) parts.fail("a node set names a point that is not there");
      set.push_back(node);
    }
  }
  return mesh;
}

}  // namespace

void write_modal_model(const std::filesystem::path& path, const ModalModel& model, const std::string& provenance_json) {
  const Eigen::Index n_nodes = model.mesh.n_nodes();
  vtkNew<vtkUnstructuredGrid> grid;

  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(n_nodes);
  std::copy_n(model.mesh.nodes_m.data(), 3 * n_nodes, coordinates->GetPointer(0));
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  grid->SetPoints(points);

  vtkNew<vtkCellArray> cells;
  for (int e = 0; e < model.mesh.n_elements(); ++e) {
    cells->InsertNextCell(static_cast<int>(model.mesh.elements.cols()));
    for (int k = 0; k < model.mesh.elements.cols(); ++k) cells->InsertCellPoint(model.mesh.elements(e, k));
  }
  grid->SetCells(model.mesh.order() == 2 ? kQuadraticTet : kLinearTet, cells);

  for (Eigen::Index k = 0; k < model.n_modes(); ++k) {
    vtkNew<vtkDoubleArray> shape;
    shape->SetName(mode_name(k).c_str());
    shape->SetNumberOfComponents(3);
    shape->SetNumberOfTuples(n_nodes);
    std::copy_n(model.shapes.col(k).data(), 3 * n_nodes, shape->GetPointer(0));
    grid->GetPointData()->AddArray(shape);
  }

  auto* fields = grid->GetFieldData();
  add_integers(fields, "klang_modal_model", {kFileVersion});
  const Eigen::VectorXd frequency_hz = model.frequency_hz();
  add_numbers(fields, "frequencies_hz", frequency_hz.data(), frequency_hz.size());
  add_numbers(fields, "angular_frequency_rad_s", model.angular_frequency_rad_s.data(), model.n_modes());
  add_numbers(fields, "lame_lambda_pa", &model.material.lame_lambda_pa, 1);
  add_numbers(fields, "lame_mu_pa", &model.material.lame_mu_pa, 1);
  add_numbers(fields, "density_kg_m3", &model.material.density_kg_m3, 1);
  add_text(fields, "material_name", model.material.name);
  add_text(fields, "material_source", model.material.source);
  add_text(fields, "support", solid::to_text(model.support));
  add_text(fields, "provenance_json", provenance_json);
  for (const auto& [name, nodes] : model.mesh.node_sets) add_integers(fields, kNodeSetPrefix + name, nodes);

  write_grid(path, grid, "modal model");
}

ModalModel read_modal_model(const std::filesystem::path& path) {
  const GridFile parts(path, "modal model", "klang_modal_model", kFileVersion);
  vtkUnstructuredGrid* grid = parts.grid();

  ModalModel model;
  model.mesh = read_mesh(grid, parts);
  model.angular_frequency_rad_s = parts.numbers("angular_frequency_rad_s");
  model.shapes.resize(3 * model.mesh.n_nodes(), model.n_modes());
  for (Eigen::Index k = 0; k < model.n_modes(); ++k) {
    auto* shape = vtkDoubleArray::SafeDownCast(grid->GetPointData()->GetAbstractArray(mode_name(k).c_str()));
    if (shape == nullptr || shape->GetNumberOfComponents() != 3 || shape->GetNumberOfTuples() != model.mesh.n_nodes()) {
      parts.fail("array " + mode_name(k) + " is missing");
    }
    model.shapes.col(k) = Eigen::Map<const Eigen::VectorXd>(shape->GetPointer(0), model.shapes.rows());
  }
  model.material.lame_lambda_pa = parts.number("lame_lambda_pa");
  model.material.lame_mu_pa = parts.number("lame_mu_pa");
  model.material.density_kg_m3 = parts.number("density_kg_m3");
  model.material.name = parts.text("material_name");
  model.material.source = parts.text("material_source");
  solid::validate(model.material);
  model.support = solid::parse_support(parts.text("support"));
  return model;
}

}  // namespace klang::modal
