#include "reports/scenes/frame_scene.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkXMLPolyDataReader.h>

#include <Eigen/Geometry>
#include <cmath>

#include "reports/scenes/vtk_capture.hpp"

namespace klang::reports::detail {
namespace {

using Eigen::Vector3d;

constexpr int kFrameSupersampling = 2, kFramePixels = 420, kFrameColours = 12;

/// Colours that are told apart, repeated over the bodies.
void add_bodies(vtkRenderer* renderer, vtkPolyData* data) {
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(kFrameColours);
  table->SetTableRange(0, kFrameColours - 1);
  for (int i = 0; i < kFrameColours; ++i) {
    const double hue = std::fmod(0.58 + 0.381966 * i, 1.0);  // golden section: neighbours differ
    double rgb[3];
    for (int c = 0; c < 3; ++c)
      rgb[c] = 0.55 + 0.27 * std::cos(2.0 * 3.141592653589793 * (hue - static_cast<double>(c) / 3.0));
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }
  vtkDataArray* bodies = data->GetCellData()->GetArray("body");
  for (vtkIdType i = 0; i < bodies->GetNumberOfTuples(); ++i)
    bodies->SetTuple1(i, std::fmod(bodies->GetTuple1(i), kFrameColours));
  data->GetCellData()->SetActiveScalars("body");
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(40);
  normals->ConsistencyOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(normals->GetOutputPort());
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  mapper->SetScalarModeToUseCellData();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetInterpolationToPhong();
  actor->GetProperty()->SetAmbient(0.3);
  actor->GetProperty()->SetDiffuse(0.75);
  renderer->AddActor(actor);
}

/// A thin sheet under everything, so that one sees where the floor is.
void add_ground(vtkRenderer* renderer, const Vector3d& low, const Vector3d& high) {
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(low.x(), low.y(), low.z());
  points->InsertNextPoint(high.x(), low.y(), low.z());
  points->InsertNextPoint(high.x(), high.y(), low.z());
  points->InsertNextPoint(low.x(), high.y(), low.z());
  vtkNew<vtkCellArray> cells;
  const vtkIdType corners[4] = {0, 1, 2, 3};
  cells->InsertNextCell(4, corners);
  vtkNew<vtkPolyData> sheet;
  sheet->SetPoints(points);
  sheet->SetPolys(cells);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(sheet);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.82, 0.82, 0.80);
  actor->GetProperty()->LightingOff();
  renderer->AddActor(actor);
}

std::optional<Drawing> draw_frame(const FramePictureRequest& request) {
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(request.file.c_str());
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  if (!data || data->GetNumberOfPoints() < 4 || !data->GetCellData()->GetArray("body")) return {};
  const Vector3d low(request.low_m[0], request.low_m[1], request.low_m[2]);
  const Vector3d high(request.high_m[0], request.high_m[1], request.high_m[2]);
  const double radius = 0.5 * (high - low).norm();
  if (!(radius > 0.0) || !std::isfinite(radius)) return {};
  vtkNew<vtkRenderer> renderer;
  add_ground(renderer, low, high);
  add_bodies(renderer, data);
  const Vector3d centre = 0.5 * (low + high);
  const Vector3d eye = centre + 5.0 * radius * Vector3d(0.45, -0.8, 0.4).normalized();
  look(renderer, {centre, eye, radius});
  const RgbaImage image = captured(renderer, kFramePixels * kFrameSupersampling, kFramePixels * kFrameSupersampling);
  if (image.pixels.empty()) return {};
  return Drawing{reduced(image, kFrameSupersampling), false, 0.0, 0.0};
}

}  // namespace

DrawnPictures render_frames(const std::vector<FramePictureRequest>& requests, Monitor& monitor) {
  const auto drawer = [&](const std::function<void(std::size_t, const std::optional<Drawing>&)>& done) {
    for (std::size_t i = 0; i < requests.size(); ++i) done(i, draw_frame(requests[i]));
  };
  return draw_in_own_process(requests.size(), drawer, "stills", "frames", monitor);
}

}  // namespace klang::reports::detail
