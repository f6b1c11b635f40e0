#include "core/physics/fracture/quasistatic/stress_file.hpp"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <algorithm>

#include "core/geometry/files/vtk_fields.hpp"

namespace klang::fracture {
namespace {

constexpr int kFileVersion = 1;
constexpr int kLinearTet = 10;     // VTK_TETRA
constexpr int kQuadraticTet = 24;  // VTK_QUADRATIC_TETRA: the node order of mesh::TetMesh

/// Values interleaved; n of n_components.
void add_array(vtkFieldData* data, const char* name, int n_components, const double* values, Eigen::Index n) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(n_components);
  array->SetNumberOfTuples(n);
  std::copy_n(values, n_components * n, array->GetPointer(0));
  if (n_components == 6) {
    constexpr const char* kNames[6] = {"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
    for (int c = 0; c < 6; ++c) array->SetComponentName(c, kNames[c]);
  }
  data->AddArray(array);
}

}  // namespace

void write_stress_file(const std::filesystem::path& path, const mesh::TetMesh& mesh, const BodyStress& stress,
                       const std::string& provenance_json) {
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(mesh.n_nodes());
  std::copy_n(mesh.nodes_m.data(), mesh.nodes_m.size(), coordinates->GetPointer(0));
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  grid->SetPoints(points);
  vtkNew<vtkCellArray> cells;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    cells->InsertNextCell(static_cast<int>(mesh.elements.cols()));
    for (int k = 0; k < mesh.elements.cols(); ++k) cells->InsertCellPoint(mesh.elements(e, k));
  }
  grid->SetCells(mesh.order() == 2 ? kQuadraticTet : kLinearTet, cells);

  add_array(grid->GetPointData(), "displacement_m", 3, stress.displacement_m.data(), mesh.n_nodes());
  add_array(grid->GetPointData(), "force_n", 3, stress.nodal_force_n.data(), mesh.n_nodes());
  const StressField& field = stress.field;
  const Eigen::Index n = mesh.n_elements();
  Eigen::Matrix3Xd principal(3, n);
  Eigen::VectorXd largest(n);
  for (int e = 0; e < n; ++e) {
    principal.col(e) = principal_stresses_pa(field.stress_pa.col(e));
    largest[e] = principal_stresses_pa(field.corner(e, 0))[0];
    for (int c = 1; c < field.n_corners(); ++c)
      largest[e] = std::max(largest[e], principal_stresses_pa(field.corner(e, c))[0]);
  }
  add_array(grid->GetCellData(), "stress_pa", 6, field.stress_pa.data(), n);
  add_array(grid->GetCellData(), "principal_stress_pa", 3, principal.data(), n);
  add_array(grid->GetCellData(), "max_principal_stress_pa", 1, largest.data(), n);
  add_array(grid->GetCellData(), "energy_density_j_m3", 1, field.energy_density_j_m3.data(), n);
  mesh::add_integers(grid->GetFieldData(), "klang_stress_field", {kFileVersion});
  mesh::add_text(grid->GetFieldData(), "provenance_json", provenance_json);
  mesh::write_grid(path, grid, "stress field");
}

}  // namespace klang::fracture
