#include "reports/scenes/liquid_pictures.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
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

constexpr int kPictureSize = 300, kSupersampling = 2, kBallRings = 8, kBallSectors = 12;

vtkNew<vtkActor> actor_of(vtkPolyData* data, bool smooth) {
  vtkNew<vtkPolyDataMapper> mapper;
  if (smooth) {
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(data);
    normals->SetFeatureAngle(60);
    normals->ConsistencyOff();
    mapper->SetInputConnection(normals->GetOutputPort());
  } else {
    mapper->SetInputData(data);
  }
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  return actor;
}

/// The faces of some regions.
vtkNew<vtkPolyData> part_of(vtkPolyData* data, vtkDataArray* region, bool solids) {
  vtkNew<vtkCellArray> cells;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    const double value = region->GetComponent(c, 0);
    if (solids ? value < 1.5 : value > 0.5) continue;
    vtkIdType n = 0;
    const vtkIdType* corners = nullptr;
    data->GetCellPoints(c, n, corners);
    if (n == 3) cells->InsertNextCell(3, corners);
  }
  vtkNew<vtkPolyData> part;
  part->SetPoints(data->GetPoints());
  part->SetPolys(cells);
  return part;
}

void add_box(vtkRenderer* renderer, const Vector3d& size) {
  vtkNew<vtkPoints> points;
  for (int c = 0; c < 8; ++c)
    points->InsertNextPoint((c & 1) != 0 ? size.x() : 0.0, (c & 2) != 0 ? size.y() : 0.0,
                            (c & 4) != 0 ? size.z() : 0.0);
  vtkNew<vtkCellArray> lines;
  for (int c = 0; c < 8; ++c)
    for (int axis = 0; axis < 3; ++axis)
      if ((c & (1 << axis)) == 0) {
        const vtkIdType ends[2] = {c, c | (1 << axis)};
        lines->InsertNextCell(2, ends);
      }
  vtkNew<vtkPolyData> box;
  box->SetPoints(points);
  box->SetLines(lines);
  const auto actor = actor_of(box, false);
  actor->GetProperty()->SetColor(0.55, 0.55, 0.55);
  actor->GetProperty()->SetLineWidth(1.0F * kSupersampling);
  actor->GetProperty()->LightingOff();
  renderer->AddActor(actor);
}

void add_bubble(vtkRenderer* renderer, const DrawnBubble& bubble, double least_radius) {
  const double r = std::max(bubble.radius_m, least_radius);
  vtkNew<vtkPoints> points;
  for (int ring = 0; ring <= kBallRings; ++ring)
    for (int sector = 0; sector < kBallSectors; ++sector) {
      const double polar = M_PI * ring / kBallRings, turn = 2.0 * M_PI * sector / kBallSectors;
      points->InsertNextPoint(bubble.position_m[0] + r * std::sin(polar) * std::cos(turn),
                              bubble.position_m[1] + r * std::sin(polar) * std::sin(turn),
                              bubble.position_m[2] + r * std::cos(polar));
    }
  vtkNew<vtkCellArray> quads;
  for (int ring = 0; ring < kBallRings; ++ring)
    for (int sector = 0; sector < kBallSectors; ++sector) {
      const vtkIdType a = ring * kBallSectors + sector, b = ring * kBallSectors + (sector + 1) % kBallSectors;
      const vtkIdType corners[4] = {a, a + kBallSectors, b + kBallSectors, b};
      quads->InsertNextCell(4, corners);
    }
  vtkNew<vtkPolyData> ball;
  ball->SetPoints(points);
  ball->SetPolys(quads);
  const auto actor = actor_of(ball, false);
  const auto& colour = heat_palette()[static_cast<std::size_t>(60 + 160 * std::clamp(bubble.colour, 0.0, 1.0))];
  actor->GetProperty()->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
  actor->GetProperty()->SetAmbient(0.6);
  renderer->AddActor(actor);
}

std::optional<Drawing> draw_liquid(const LiquidPictureRequest& request) {
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(request.file.c_str());
  reader->Update();
  vtkPolyData* const data = reader->GetOutput();
  vtkDataArray* const region = data && data->GetCellData() ? data->GetCellData()->GetArray("region") : nullptr;
  if (region == nullptr || data->GetNumberOfCells() == 0) return std::nullopt;
  data->BuildCells();
  const Vector3d size(request.box_m[0], request.box_m[1], request.box_m[2]);
  vtkNew<vtkRenderer> renderer;
  add_box(renderer, size);
  const auto solids = part_of(data, region, true), surface = part_of(data, region, false);
  if (solids->GetNumberOfCells() > 0) {
    const auto actor = actor_of(solids, true);
    actor->GetProperty()->SetColor(0.62, 0.58, 0.52);
    renderer->AddActor(actor);
  }
  for (const DrawnBubble& bubble : request.bubbles) add_bubble(renderer, bubble, 0.004 * size.norm());
  const auto actor = actor_of(surface, true);
  actor->GetProperty()->SetColor(0.27, 0.53, 0.78);
  actor->GetProperty()->SetOpacity(0.62);
  actor->GetProperty()->SetSpecular(0.4);
  actor->GetProperty()->SetSpecularPower(30);
  renderer->AddActor(actor);
  const Vector3d centre = 0.5 * size, eye = centre + 5.0 * size.norm() * Vector3d(0.45, -0.8, 0.4).normalized();
  look(renderer, {centre, eye, 0.5 * size.norm()});
  const RgbaImage image = captured(renderer, kPictureSize * kSupersampling, kPictureSize * kSupersampling);
  if (image.pixels.empty()) return std::nullopt;
  return Drawing{trimmed(reduced(image, kSupersampling), 2), false, 0.0, 0.0};
}

}  // namespace

DrawnPictures render_liquid(const std::vector<LiquidPictureRequest>& requests, Monitor& monitor) {
  const auto drawer = [&](const std::function<void(std::size_t, const std::optional<Drawing>&)>& done) {
    for (std::size_t i = 0; i < requests.size(); ++i) done(i, draw_liquid(requests[i]));
  };
  return draw_in_own_process(requests.size(), drawer, "pictures", "frames", monitor);
}

}  // namespace klang::reports::detail
