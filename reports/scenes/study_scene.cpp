#include "reports/scenes/study_scene.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkXMLPolyDataReader.h>

#include <Eigen/Geometry>
#include <cmath>

#include "reports/scenes/field_files.hpp"
#include "reports/scenes/vtk_capture.hpp"

namespace klang::reports::detail {
namespace {

using Eigen::Vector3d;

constexpr int kSupersampling = 2;
constexpr int kPictureSize = 420;

void add_axis(vtkRenderer* renderer, const Vector3d& from, const Vector3d& to) {
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(from.x(), from.y(), from.z());
  points->InsertNextPoint(to.x(), to.y(), to.z());
  vtkNew<vtkCellArray> cells;
  const vtkIdType ends[2] = {0, 1};
  cells->InsertNextCell(2, ends);
  vtkNew<vtkPolyData> line;
  line->SetPoints(points);
  line->SetLines(cells);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(line);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.45, 0.45, 0.45);
  actor->GetProperty()->SetLineWidth(1.2F * kSupersampling);
  actor->GetProperty()->LightingOff();
  renderer->AddActor(actor);
}

}  // namespace

std::optional<FieldImage> draw_field(const std::filesystem::path& file, FieldKind kind) {
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  vtkDataArray* values = data && data->GetPointData() ? data->GetPointData()->GetArray(0) : nullptr;
  if (!values || values->GetNumberOfComponents() != 1 || data->GetNumberOfPoints() < 4) return {};
  data->GetPointData()->SetActiveScalars(values->GetName());
  FieldImage result;
  double range[2];
  values->GetRange(range);
  if (!std::isfinite(range[0]) || !std::isfinite(range[1])) return {};
  const bool balloon = kind == FieldKind::kBalloon;
  result.low = balloon ? -kBalloonRange_db : 0.0;
  result.high = balloon ? 0.0 : (range[1] > 0 ? range[1] : 1.0);

  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(40);
  normals->ConsistencyOff();
  if (balloon) normals->SplittingOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(normals->GetOutputPort());
  const auto table = heat_table(result.low, result.high);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  mapper->InterpolateScalarsBeforeMappingOn();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetInterpolationToPhong();
  actor->GetProperty()->SetAmbient(0.35);
  actor->GetProperty()->SetDiffuse(0.75);
  actor->GetProperty()->SetSpecular(0.05);
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);

  double bounds[6];
  data->GetBounds(bounds);
  const Vector3d low(bounds[0], bounds[2], bounds[4]), high(bounds[1], bounds[3], bounds[5]);
  Vector3d centre = 0.5 * (low + high);
  double radius = 0.5 * (high - low).norm();
  if (!(radius > 0)) return {};
  if (balloon) {
    // All balloons on one scale around the source, with the axes of the plane below and straight up.
    centre.setZero(), radius = 1.25;
    const double reach = 1.15;
    add_axis(renderer, Vector3d(-reach, 0, 0), Vector3d(reach, 0, 0));
    add_axis(renderer, Vector3d(0, -reach, 0), Vector3d(0, reach, 0));
    add_axis(renderer, Vector3d(0, 0, -reach), Vector3d(0, 0, reach));
  } else {
    double farthest = 0;  // of a ball the diagonal of its box would leave a wide border
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
      double p[3];
      data->GetPoint(i, p);
      farthest = std::max(farthest, (Vector3d(p[0], p[1], p[2]) - centre).norm());
    }
    radius = 1.03 * farthest;
  }
  const Vector3d towards = Vector3d(0.55, -0.75, 0.42).normalized();
  const Vector3d eye = centre + 5 * radius * towards;
  look(renderer, {centre, eye, radius});
  const RgbaImage image = captured(renderer, kPictureSize * kSupersampling, kPictureSize * kSupersampling);
  if (image.pixels.empty()) return {};
  result.image = trimmed(reduced(image, kSupersampling), 2);
  return result;
}

}  // namespace klang::reports::detail
