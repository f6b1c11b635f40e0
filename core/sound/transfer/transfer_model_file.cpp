#include "core/sound/transfer/transfer_model_file.hpp"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/files/vtk_fields.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::acoustics {
namespace {

using mesh::add_integers;
using mesh::add_numbers;
using mesh::add_text;
using mesh::GridFile;

constexpr int kFileVersion = 1;
constexpr const char* kVersionField = "klang_transfer_model";
constexpr const char* kWhat = "transfer model";
constexpr int kVertex = 1;  // VTK_VERTEX
constexpr int kHighestOrder = 200;

// The point arrays, once for writing and once for reading.
struct NumberColumn {
  const char* name;
  double& (*of)(ModeTransfer&);
};
constexpr NumberColumn kNumbers[] = {
    {"frequency_hz", [](ModeTransfer& t) -> double& { return t.frequency_hz; }},
    {"wavenumber_per_m", [](ModeTransfer& t) -> double& { return t.multipole.wavenumber_per_m; }},
    {"radiated_power_w", [](ModeTransfer& t) -> double& { return t.radiated_power_w; }},
    {"decay_radiation_per_s", [](ModeTransfer& t) -> double& { return t.decay_radiation_per_s; }},
    {"kept_power_fraction", [](ModeTransfer& t) -> double& { return t.kept_power_fraction; }}};
struct IntegerColumn {
  const char* name;
  int& (*of)(ModeTransfer&);
};
constexpr IntegerColumn kIntegers[] = {{"mode", [](ModeTransfer& t) -> int& { return t.mode; }},
                                       {"order", [](ModeTransfer& t) -> int& { return t.multipole.order; }},
                                       {"n_bem_elements", [](ModeTransfer& t) -> int& { return t.n_bem_elements; }}};

}  // namespace

void write_transfer_model(const std::filesystem::path& path, const TransferModel& model,
                          const std::string& provenance_json) {
  std::vector<ModeTransfer> modes = model.modes;
  const auto n_modes = static_cast<vtkIdType>(modes.size());
  vtkNew<vtkDoubleArray> centres;
  centres->SetNumberOfComponents(3);
  centres->SetNumberOfTuples(n_modes);
  vtkNew<vtkCellArray> cells;
  std::vector<double> coefficients, residuals;
  std::vector<int> has_residual;
  for (vtkIdType i = 0; i < n_modes; ++i) {
    const ModeTransfer& mode = modes[static_cast<std::size_t>(i)];
    KLANG_CHECK(mode.multipole.coefficients_pa.size() == basis_size(mode.multipole.order),
                "coefficients of a multipole");
    centres->SetTypedTuple(i, mode.multipole.centre_m.data());
    cells->InsertNextCell(1, &i);
    for (const auto& c : mode.multipole.coefficients_pa) coefficients.insert(coefficients.end(), {c.real(), c.imag()});
    has_residual.push_back(mode.residual ? 1 : 0);
    residuals.push_back(mode.residual.value_or(0.0));
  }
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkPoints> points;
  points->SetData(centres);
  grid->SetPoints(points);
  grid->SetCells(kVertex, cells);
  for (const NumberColumn& c : kNumbers) {
    std::vector<double> values;
    for (ModeTransfer& mode : modes) values.push_back(c.of(mode));
    add_numbers(grid->GetPointData(), c.name, values.data(), n_modes);
  }
  for (const IntegerColumn& c : kIntegers) {
    std::vector<int> values;
    for (ModeTransfer& mode : modes) values.push_back(c.of(mode));
    add_integers(grid->GetPointData(), c.name, values);
  }
  add_integers(grid->GetPointData(), "has_residual", has_residual);
  add_numbers(grid->GetPointData(), "residual", residuals.data(), n_modes);

  auto* fields = grid->GetFieldData();
  add_integers(fields, kVersionField, {kFileVersion});
  add_numbers(fields, "coefficients_pa", coefficients.data(), static_cast<Eigen::Index>(coefficients.size()));
  add_numbers(fields, "density_kg_m3", &model.medium.density_kg_m3, 1);
  add_numbers(fields, "sound_speed_m_s", &model.medium.sound_speed_m_s, 1);
  add_text(fields, "provenance_json", provenance_json);
  mesh::write_grid(path, grid, kWhat);
}

TransferModel read_transfer_model(const std::filesystem::path& path) {
  return read_transfer_model_bytes(read_file(path), path.string());
}

TransferModel read_transfer_model_bytes(std::string bytes, const std::string& name) {
  const GridFile file(std::move(bytes), name, kWhat, kVersionField, kFileVersion);
  TransferModel model;
  model.medium.density_kg_m3 = file.number("density_kg_m3");
  model.medium.sound_speed_m_s = file.number("sound_speed_m_s");
  model.medium.validate();
  const mesh::Points centres = file.file().points();
  const auto n_modes = static_cast<std::size_t>(centres.rows());
  model.modes.resize(n_modes);
  if (n_modes > 0) {
    for (std::size_t i = 0; i < n_modes; ++i)
      model.modes[i].multipole.centre_m = centres.row(static_cast<Eigen::Index>(i)).transpose();
    for (const NumberColumn& c : kNumbers) {
      const std::vector<double> values = file.point_numbers(c.name);
      for (std::size_t i = 0; i < n_modes; ++i) c.of(model.modes[i]) = values[i];
    }
    for (const IntegerColumn& c : kIntegers) {
      const std::vector<int> values = file.point_integers(c.name);
      for (std::size_t i = 0; i < n_modes; ++i) c.of(model.modes[i]) = values[i];
    }
    const std::vector<int> has_residual = file.point_integers("has_residual");
    const std::vector<double> residual = file.point_numbers("residual");
    for (std::size_t i = 0; i < n_modes; ++i)
      if (has_residual[i] != 0) model.modes[i].residual = residual[i];
  }
  const Eigen::VectorXd coefficients = file.numbers("coefficients_pa");
  if (!coefficients.allFinite()) file.fail("a coefficient is not finite");
  Eigen::Index at = 0;
  for (ModeTransfer& mode : model.modes) {
    Multipole& multipole = mode.multipole;
    if (multipole.order < 0 || multipole.order > kHighestOrder) file.fail("an order is not within 0 to 200");
    const Eigen::Index n = basis_size(multipole.order);
    if (at + 2 * n > coefficients.size()) file.fail("coefficients are missing");
    multipole.coefficients_pa.resize(n);
    for (Eigen::Index i = 0; i < n; ++i, at += 2)
      multipole.coefficients_pa[i] = {coefficients[at], coefficients[at + 1]};
    if (!multipole.centre_m.allFinite() || !std::isfinite(mode.frequency_hz) || !(multipole.wavenumber_per_m > 0.0) ||
        !std::isfinite(multipole.wavenumber_per_m)) {
      file.fail("a centre, frequency or wavenumber is not finite and positive");
    }
  }
  if (at != coefficients.size()) file.fail("there are more coefficients than the orders say");
  return model;
}

std::string read_transfer_provenance(const std::filesystem::path& path) {
  return GridFile(path, kWhat, kVersionField, kFileVersion).text("provenance_json");
}

void check_belongs(const TransferModel& transfer, const modal::ModalModel& model, const std::string& place) {
  const Eigen::VectorXd frequency_hz = model.frequency_hz();
  for (const ModeTransfer& mode : transfer.modes) {
    if (mode.mode < 0 || mode.mode >= model.n_modes()) {
      throw InputError(place, "is the transfer of another model: it has a mode " + std::to_string(mode.mode), {},
                       "0 to " + std::to_string(model.n_modes() - 1));
    }
    const double expected = frequency_hz[mode.mode];
    if (!(std::abs(mode.frequency_hz - expected) <= 1e-6 * expected)) {
      throw InputError(place, "is the transfer of another model: frequency of mode " + std::to_string(mode.mode),
                       to_text(mode.frequency_hz) + " Hz", to_text(expected) + " Hz");
    }
  }
}

}  // namespace klang::acoustics
