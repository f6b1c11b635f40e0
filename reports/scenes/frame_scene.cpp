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
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

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

/// What is looked at.
struct Box {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = Vector3d::Constant(-HUGE_VAL);
  void add(const Vector3d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  Vector3d centre() const { return 0.5 * (low + high); }
};

struct Seen {
  Box box;
  double area_sq_m = 0.0, away_m = 0.0;
};

/// Of all bodies but those farthest from the middle that make up a twentieth of the surface.
Box bodies_box(vtkPolyData* data) {
  std::map<double, Seen> by_body;
  Vector3d sum = Vector3d::Zero();
  double area_sq_m = 0.0;
  vtkDataArray* bodies = data->GetCellData()->GetArray("body");
  for (vtkIdType i = 0; i < data->GetNumberOfCells(); ++i) {
    const vtkIdType* corners = nullptr;
    vtkIdType n = 0;
    data->GetCellPoints(i, n, corners);
    Seen& seen = by_body[bodies->GetTuple1(i)];
    Vector3d first = Vector3d::Zero(), before = Vector3d::Zero(), cross = Vector3d::Zero();
    for (vtkIdType k = 0; k < n; ++k) {
      const Vector3d point(data->GetPoint(corners[k]));
      if (k == 0) first = point;
      cross += (before - first).cross(point - first) * (k > 1 ? 0.5 : 0.0);
      before = point;
      seen.box.add(point);
    }
    seen.area_sq_m += cross.norm();
    area_sq_m += cross.norm();
    sum += cross.norm() * first;
  }
  std::vector<Seen*> order;
  for (auto& [number, seen] : by_body) {
    seen.away_m = (seen.box.centre() - sum / area_sq_m).norm();
    order.push_back(&seen);
  }
  std::stable_sort(order.begin(), order.end(), [](const Seen* x, const Seen* y) { return x->away_m < y->away_m; });
  Box box;
  double shown_sq_m = 0.0;
  for (const Seen* seen : order) {
    if (shown_sq_m > 0.95 * area_sq_m) break;
    box.add(seen->box.low);
    box.add(seen->box.high);
    shown_sq_m += seen->area_sq_m;
  }
  return box;
}

void add_flat(vtkRenderer* renderer, vtkPolyData* data, double grey) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(grey, grey, grey);
  actor->GetProperty()->SetLineWidth(kFrameSupersampling);
  actor->GetProperty()->LightingOff();
  renderer->AddActor(actor);
}

/// 1, 2 or 5 times a power of ten, not below.
double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double times : {1.0, 2.0, 5.0})
    if (times * power >= length * (1 - 1e-9)) return times * power;
  return 10.0 * power;
}

/// A sheet with lines, and on it the shadows of what is above. Each lies a hair above the one before.
void add_floor(vtkRenderer* renderer, vtkPolyData* data, const Vector3d& under, double reach, double line_every) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> sheet_cells, lines;
  const double hair = 2e-4 * reach, x = under.x(), y = under.y(), z = under.z();
  const auto point = [&](double px, double py, double pz) { return points->InsertNextPoint(px, py, pz); };
  const vtkIdType corners[4] = {point(x - reach, y - reach, z - hair), point(x + reach, y - reach, z - hair),
                                point(x + reach, y + reach, z - hair), point(x - reach, y + reach, z - hair)};
  sheet_cells->InsertNextCell(4, corners);
  const auto line = [&](const Vector3d& from, const Vector3d& to) {
    const vtkIdType ends[2] = {point(from.x(), from.y(), z), point(to.x(), to.y(), z)};
    lines->InsertNextCell(2, ends);
  };
  for (double at = line_every * std::ceil((x - reach) / line_every); at < x + reach; at += line_every)
    line({at, y - reach, z}, {at, y + reach, z});
  for (double at = line_every * std::ceil((y - reach) / line_every); at < y + reach; at += line_every)
    line({x - reach, at, z}, {x + reach, at, z});
  vtkNew<vtkPolyData> sheet, ruling, shadow;
  sheet->SetPoints(points);
  sheet->SetPolys(sheet_cells);
  ruling->SetPoints(points);
  ruling->SetLines(lines);
  shadow->DeepCopy(data);
  for (vtkIdType i = 0; i < shadow->GetNumberOfPoints(); ++i) {
    double place[3];
    shadow->GetPoint(i, place);
    place[2] = z + hair;
    shadow->GetPoints()->SetPoint(i, place);
  }
  add_flat(renderer, sheet, 0.90);
  add_flat(renderer, ruling, 0.78);
  add_flat(renderer, shadow, 0.66);
}

std::optional<Drawing> draw_frame(const FramePictureRequest& request) {
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(request.file.c_str());
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  if (!data || data->GetNumberOfPoints() < 4 || !data->GetCellData()->GetArray("body")) return {};
  Box box = bodies_box(data);
  // What is about to touch the floor is shown with it.
  if (box.low.z() - request.floor_m < (box.high - box.low).norm()) box.low.z() = std::min(box.low.z(), request.floor_m);
  const Vector3d towards = Vector3d(0.45, -0.8, 0.5).normalized(),
                 right = towards.cross(-Vector3d::UnitZ()).normalized(), up = towards.cross(right);
  double half = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d arm = box.high - box.centre();
    for (int i = 0; i < 3; ++i)
      if ((corner >> i & 1) != 0) arm[i] = -arm[i];
    half = std::max({half, std::abs(arm.dot(right)), std::abs(arm.dot(up))});
  }
  half *= 1.2;
  if (!(half > 0.0) || !std::isfinite(half)) return {};
  const double height = std::max(box.centre().z() - request.floor_m, 0.0);
  const Vector3d sight =
      box.centre() - height / towards.z() * towards;  // where the middle of the picture meets the floor
  const double line_every_m = round_length(0.4 * half);
  vtkNew<vtkRenderer> renderer;
  add_floor(renderer, data, {sight.x(), sight.y(), request.floor_m}, 4.0 * half, line_every_m);
  add_bodies(renderer, data);
  look(renderer, {box.centre(), box.centre() + 8.0 * half * towards, half});
  const RgbaImage image = captured(renderer, kFramePixels * kFrameSupersampling, kFramePixels * kFrameSupersampling);
  if (image.pixels.empty()) return {};
  return Drawing{reduced(image, kFrameSupersampling), false, 0.0, line_every_m};
}

}  // namespace

DrawnPictures render_frames(const std::vector<FramePictureRequest>& requests, Monitor& monitor) {
  const auto drawer = [&](const std::function<void(std::size_t, const std::optional<Drawing>&)>& done) {
    for (std::size_t i = 0; i < requests.size(); ++i) done(i, draw_frame(requests[i]));
  };
  return draw_in_own_process(requests.size(), drawer, "stills", "frames", monitor);
}

}  // namespace klang::reports::detail
