#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <cstdio>
#include <optional>

#include "core/foundation/base/output_file.hpp"
#include "core/geometry/files/vtk_fields.hpp"
#include "core/geometry/mesh/import_check.hpp"
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
constexpr double kHighestRadS = 1e9;
constexpr double kLargestShape = 1e12;  // of a mass-normalised mode [1/sqrt(kg)]: that of a body of 1e-24 kg
constexpr const char* kNodeSetPrefix = "node_set:";

std::string mode_name(Eigen::Index k) {
  char name[32];
  std::snprintf(name, sizeof name, "mode_%04ld", static_cast<long>(k));
  return name;
}

mesh::TetMesh read_mesh(const GridFile& parts) {
  const mesh::VtkXmlFile& file = parts.file();
  mesh::TetMesh mesh;
  mesh.nodes_m = file.points();
  if (!mesh.nodes_m.allFinite()) parts.fail("a point is not finite");
  const Eigen::Index n_nodes = mesh.nodes_m.rows();
  const mesh::VtkCells cells = file.cells();
  const int type = cells.types.empty() ? 0 : cells.types[0];
  if (type != kLinearTet && type != kQuadraticTet) parts.fail("its cells are not tetrahedra");
  const int n_corners = type == kLinearTet ? 4 : 10;
  mesh.elements.resize(static_cast<Eigen::Index>(cells.types.size()), n_corners);
  for (std::size_t e = 0; e < cells.types.size(); ++e) {
    if (cells.types[e] != type || cells.offsets[e] - cells.begin(e) != n_corners) parts.fail("cells of several kinds");
    for (int k = 0; k < n_corners; ++k)
      mesh.elements(static_cast<Eigen::Index>(e), k) =
          static_cast<int>(cells.connectivity[static_cast<std::size_t>(cells.begin(e) + k)]);
  }
  const std::string prefix = kNodeSetPrefix;
  for (const std::string& name : file.array_names(mesh::VtkPlace::kFieldData)) {
    if (!name.starts_with(prefix)) continue;
    auto& set = mesh.node_sets[name.substr(prefix.size())];
    for (const int node : parts.integers(name)) {
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

ModalModel read_modal_model_bytes(std::string bytes, const std::string& name) {
  const GridFile parts(std::move(bytes), name, "modal model", "klang_modal_model", kFileVersion);
  ModalModel model;
  model.mesh = read_mesh(parts);
  const mesh::TetMesh checked = mesh::checked_import(model.mesh, name);
  if (checked.n_nodes() != model.mesh.n_nodes() || checked.elements != model.mesh.elements)
    parts.fail("an element is turned inside out, or a point belongs to none");
  model.angular_frequency_rad_s = parts.numbers("angular_frequency_rad_s");
  if (!model.angular_frequency_rad_s.allFinite() || !(model.angular_frequency_rad_s.array() >= 0.0).all() ||
      !(model.angular_frequency_rad_s.array() <= kHighestRadS).all())
    parts.fail("a frequency is not within 0 to 1e9 rad/s");
  if (model.n_modes() > static_cast<Eigen::Index>(parts.file().array_names(mesh::VtkPlace::kPointData).size()))
    parts.fail("there are more frequencies than mode shapes");
  model.shapes.resize(3 * model.mesh.n_nodes(), model.n_modes());
  for (Eigen::Index k = 0; k < model.n_modes(); ++k) {
    const std::vector<double> shape = parts.point_numbers(mode_name(k), 3);
    if (static_cast<Eigen::Index>(shape.size()) != model.shapes.rows())
      parts.fail("array " + mode_name(k) + " is short");
    model.shapes.col(k) = Eigen::Map<const Eigen::VectorXd>(shape.data(), model.shapes.rows());
    if (!model.shapes.col(k).allFinite() || !(model.shapes.col(k).cwiseAbs().maxCoeff() <= kLargestShape))
      parts.fail("array " + mode_name(k) + " has a value that no mode shape has");
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

ModalModel read_modal_model(const std::filesystem::path& path) {
  return read_modal_model_bytes(read_file(path), path.string());
}

}  // namespace klang::modal
