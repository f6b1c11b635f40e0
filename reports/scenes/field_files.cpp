#include "reports/scenes/field_files.hpp"

#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPolyDataWriter.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::reports {
namespace {

template <class Writer, class Data>
void write_vtk(const std::filesystem::path& path, Data* data) {
  write_file_with(path, [&](const std::filesystem::path& temporary) {
    vtkNew<Writer> writer;
    writer->SetFileName(temporary.c_str());
    writer->SetInputData(data);
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    if (writer->Write() != 1) throw InputError(path.string(), "cannot be written");
  });
}

vtkNew<vtkDoubleArray> array_of(const std::string& name, vtkIdType n) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name.c_str());
  array->SetNumberOfTuples(n);
  return array;
}

void add_triangle(vtkCellArray* cells, vtkIdType a, vtkIdType b, vtkIdType c) {
  const vtkIdType corners[3] = {a, b, c};
  cells->InsertNextCell(3, corners);
}

void write_surface(const validate::SurfaceField& field, const std::filesystem::path& path) {
  KLANG_CHECK(field.values.size() == field.vertices_m.rows() && field.triangles.cols() == 3, "a value per vertex");
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> cells;
  const auto values = array_of(field.quantity, field.values.size());
  for (Eigen::Index i = 0; i < field.vertices_m.rows(); ++i) {
    points->InsertNextPoint(field.vertices_m(i, 0), field.vertices_m(i, 1), field.vertices_m(i, 2));
    values->SetValue(i, field.values[i]);
  }
  for (Eigen::Index t = 0; t < field.triangles.rows(); ++t)
    add_triangle(cells, field.triangles(t, 0), field.triangles(t, 1), field.triangles(t, 2));
  data->SetPoints(points);
  data->SetPolys(cells);
  data->GetPointData()->SetScalars(values);
  write_vtk<vtkXMLPolyDataWriter>(path, data.Get());
}

void write_slice(const validate::SliceField& field, const std::filesystem::path& path) {
  const auto columns = static_cast<int>(field.values.cols()), rows = static_cast<int>(field.values.rows());
  KLANG_CHECK(columns > 1 && rows > 1, "a slice has an area");
  const Eigen::Vector3d u = field.side_u_m.normalized(), v = field.side_v_m.normalized(), w = u.cross(v);
  vtkNew<vtkImageData> image;
  image->SetDimensions(columns, rows, 1);
  image->SetSpacing(field.side_u_m.norm() / (columns - 1), field.side_v_m.norm() / (rows - 1), 1.0);
  image->SetOrigin(field.corner_m.data());
  image->SetDirectionMatrix(u.x(), v.x(), w.x(), u.y(), v.y(), w.y(), u.z(), v.z(), w.z());
  const auto values = array_of(field.quantity, static_cast<vtkIdType>(columns) * rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      values->SetValue(static_cast<vtkIdType>(row) * columns + column, field.values(row, column));
  }
  image->GetPointData()->SetScalars(values);
  write_vtk<vtkXMLImageDataWriter>(path, image.Get());
}

void write_balloon(const validate::BalloonField& field, const std::filesystem::path& path) {
  const Eigen::Index n_polar = field.magnitude.rows() - 1, n_azimuth = field.magnitude.cols();
  KLANG_CHECK(n_polar >= 2 && n_azimuth >= 3, "a balloon has directions");
  const double loudest = field.magnitude.maxCoeff();
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> cells;
  const vtkIdType n = (n_polar + 1) * n_azimuth;
  const auto level = array_of("level_db", n), magnitude = array_of("magnitude", n);
  for (Eigen::Index i = 0; i <= n_polar; ++i) {
    for (Eigen::Index k = 0; k < n_azimuth; ++k) {
      const double theta = kPi * static_cast<double>(i) / static_cast<double>(n_polar),
                   phi = 2.0 * kPi * static_cast<double>(k) / static_cast<double>(n_azimuth);
      const double db = std::max(20.0 * std::log10(field.magnitude(i, k) / loudest), -10.0 * kBalloonRange_db);
      const double radius = std::max(0.0, 1.0 + db / kBalloonRange_db);
      points->InsertNextPoint(radius * std::sin(theta) * std::cos(phi), radius * std::sin(theta) * std::sin(phi),
                              radius * std::cos(theta));
      level->SetValue(i * n_azimuth + k, db);
      magnitude->SetValue(i * n_azimuth + k, field.magnitude(i, k));
      if (i == n_polar) continue;
      const vtkIdType next = (k + 1) % n_azimuth;
      add_triangle(cells, i * n_azimuth + k, (i + 1) * n_azimuth + k, (i + 1) * n_azimuth + next);
      add_triangle(cells, i * n_azimuth + k, (i + 1) * n_azimuth + next, i * n_azimuth + next);
    }
  }
  data->SetPoints(points);
  data->SetPolys(cells);
  data->GetPointData()->SetScalars(level);
  data->GetPointData()->AddArray(magnitude);
  write_vtk<vtkXMLPolyDataWriter>(path, data.Get());
}

/// VTK prints what it has to complain about unless somebody listens.
class Silence : public vtkCommand {
 public:
  static Silence* New() { return new Silence; }  // NOLINT: VTK counts references
  void Execute(vtkObject*, unsigned long, void*) override {}
};

}  // namespace

void write_fields(const validate::Fields& fields, const std::filesystem::path& folder) {
  for (const auto& field : fields.surfaces) write_surface(field, folder / (field.name + ".vtp"));
  for (const auto& field : fields.slices) write_slice(field, folder / (field.name + ".vti"));
  for (const auto& field : fields.balloons) write_balloon(field, folder / (field.name + ".vtp"));
}

std::optional<validate::SliceField> read_slice(const std::filesystem::path& path) {
  vtkNew<vtkXMLImageDataReader> reader;
  vtkNew<Silence> silence;
  for (const auto event : {vtkCommand::ErrorEvent, vtkCommand::WarningEvent}) {
    reader->AddObserver(event, silence);
    reader->GetExecutive()->AddObserver(event, silence);
  }
  reader->SetReaderErrorObserver(silence);
  reader->SetParserErrorObserver(silence);
  reader->SetFileName(path.c_str());
  if (reader->CanReadFile(path.c_str()) == 0) return {};
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  auto* values = image ? vtkDoubleArray::SafeDownCast(image->GetPointData()->GetArray(0)) : nullptr;
  int size[3] = {0, 0, 0};
  if (image) image->GetDimensions(size);
  if (!values || size[0] < 2 || size[1] < 2 || size[2] != 1 || size[0] > 8192 || size[1] > 8192 ||
      values->GetNumberOfTuples() != static_cast<vtkIdType>(size[0]) * size[1])
    return {};
  validate::SliceField field;
  const char* name = values->GetName();
  field.quantity = name ? name : "";
  const vtkMatrix3x3* turn = image->GetDirectionMatrix();
  const double *origin = image->GetOrigin(), *spacing = image->GetSpacing();
  for (int axis = 0; axis < 3; ++axis) {
    field.corner_m[axis] = origin[axis];
    field.side_u_m[axis] = turn->GetElement(axis, 0) * spacing[0] * (size[0] - 1);
    field.side_v_m[axis] = turn->GetElement(axis, 1) * spacing[1] * (size[1] - 1);
  }
  field.values.resize(size[1], size[0]);
  for (int row = 0; row < size[1]; ++row) {
    for (int column = 0; column < size[0]; ++column)
      field.values(row, column) = values->GetValue(static_cast<vtkIdType>(row) * size[0] + column);
  }
  return field;
}

}  // namespace klang::reports
