#include "reports/scenes/mode_scene.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkContourFilter.h>
#include <vtkDataArraySelection.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkDoubleArray.h>
#include <vtkFeatureEdges.h>
#include <vtkIdList.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkWarpVector.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "reports/scenes/vtk_capture.hpp"

namespace klang::reports::detail {
namespace {

using Eigen::Vector3d;

constexpr int kSupersampling = 3;
constexpr int kPictureWidth = 560;  // of the finished picture, before its empty border is cut off

std::string array_name(int mode) {
  std::string number = std::to_string(mode);
  number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
  return "mode_" + number;
}

Vector3d point_of(vtkPolyData* surface, vtkIdType i) {
  double p[3];
  surface->GetPoint(i, p);
  return {p[0], p[1], p[2]};
}

Vector3d vector_of(vtkDataArray* array, vtkIdType i) {
  double v[3];
  array->GetTuple(i, v);
  return {v[0], v[1], v[2]};
}

/// The largest slope |du|/|dx| along any edge of the surface's triangles.
double steepest(vtkPolyData* surface, vtkDataArray* displacement) {
  double slope = 0;
  vtkNew<vtkIdList> ids;
  vtkCellArray* cells = surface->GetPolys();
  cells->InitTraversal();
  while (cells->GetNextCell(ids)) {
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) {
      const vtkIdType a = ids->GetId(k), b = ids->GetId((k + 1) % ids->GetNumberOfIds());
      const double length = (point_of(surface, a) - point_of(surface, b)).norm();
      if (length > 0)
        slope = std::max(slope, (vector_of(displacement, a) - vector_of(displacement, b)).norm() / length);
    }
  }
  return slope;
}

/// Blue (inwards) over near white to red (outwards), or near white to violet for sizes.
vtkNew<vtkLookupTable> colours(double range, bool signed_values) {
  static constexpr std::array<std::array<double, 3>, 7> kSigned = {{{0.02, 0.30, 0.55},
                                                                    {0.22, 0.55, 0.78},
                                                                    {0.62, 0.78, 0.88},
                                                                    {0.86, 0.855, 0.84},
                                                                    {0.93, 0.72, 0.61},
                                                                    {0.86, 0.42, 0.33},
                                                                    {0.62, 0.07, 0.16}}};
  static constexpr std::array<std::array<double, 3>, 4> kSizes = {
      {{0.88, 0.875, 0.86}, {0.80, 0.74, 0.87}, {0.56, 0.44, 0.74}, {0.33, 0.15, 0.53}}};
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(256);
  const auto set = [&](const auto& stops) {
    for (int i = 0; i < 256; ++i) {
      const double at = i / 255.0 * static_cast<double>(stops.size() - 1);
      const auto k = std::min(static_cast<std::size_t>(at), stops.size() - 2);
      const double t = at - static_cast<double>(k);
      table->SetTableValue(i, (1 - t) * stops[k][0] + t * stops[k + 1][0], (1 - t) * stops[k][1] + t * stops[k + 1][1],
                           (1 - t) * stops[k][2] + t * stops[k + 1][2], 1.0);
    }
  };
  signed_values ? set(kSigned) : set(kSizes);
  table->SetTableRange(signed_values ? -range : 0.0, range);
  return table;
}

struct View {
  Vector3d towards_camera, up;
};

/// Long bodies lie across the picture, turned about their axis so that the motion shows; plates are seen from
/// above and to the side; other bodies stand upright (z up).
View view_of(vtkPolyData* surface, vtkDataArray* displacement) {
  const vtkIdType n = surface->GetNumberOfPoints();
  Vector3d mean = Vector3d::Zero();
  for (vtkIdType i = 0; i < n; ++i) mean += point_of(surface, i);
  mean /= static_cast<double>(n);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (vtkIdType i = 0; i < n; ++i) {
    const Vector3d d = point_of(surface, i) - mean;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  const Eigen::Vector3d size = axes.eigenvalues().cwiseMax(0).cwiseSqrt();  // smallest first
  Vector3d longest = axes.eigenvectors().col(2), middle = axes.eigenvectors().col(1),
           shortest = axes.eigenvectors().col(0);
  const auto pointing = [](Vector3d v) {  // one sign for the same body every time
    Eigen::Index k;
    v.cwiseAbs().maxCoeff(&k);
    return Vector3d(v[k] < 0 ? -v : v);
  };
  longest = pointing(longest);
  middle = pointing(middle);
  shortest = pointing(shortest);
  const bool flat = size[0] < 0.3 * size[1];
  if (size[2] > 2.5 * size[1] && !flat) {
    Eigen::Matrix3d motion = Eigen::Matrix3d::Zero();
    for (vtkIdType i = 0; i < n; ++i) {
      const Vector3d u = vector_of(displacement, i);
      motion += u * u.transpose();
    }
    View best{};
    double most = -1;
    for (int step = 0; step < 12; ++step) {
      const double angle = (40 + 15 * step) * 3.14159265358979323846 / 180;
      const Vector3d aside = std::cos(angle) * middle + std::sin(angle) * shortest;
      const Vector3d towards = (std::cos(0.45) * aside + std::sin(0.45) * longest).normalized();
      const double seen = motion.trace() - towards.dot(motion * towards);
      if (seen > most * (1 + 1e-3)) {
        most = seen;
        best = {towards, towards.cross(longest).normalized()};
      }
    }
    return best;
  }
  if (flat) {
    const Vector3d towards = (0.72 * shortest - 0.55 * middle + 0.42 * longest).normalized();
    return {towards, shortest};
  }
  return {Vector3d(0.55, -0.75, 0.52).normalized(), Vector3d::UnitZ()};
}

/// The mesh alone with the displacements of a mode as its vectors "u"; false where they cannot be had.
bool set_displacement(vtkUnstructuredGrid* grid, int mode, vtkUnstructuredGrid* bare) {
  vtkDataArray* vectors = grid->GetPointData()->GetArray(array_name(mode).c_str());
  if (!vectors || vectors->GetNumberOfComponents() != 3 || grid->GetNumberOfPoints() < 4) return false;
  bare->CopyStructure(grid);
  vtkNew<vtkDoubleArray> displacement;
  displacement->SetName("u");
  displacement->SetNumberOfComponents(3);
  displacement->SetNumberOfTuples(vectors->GetNumberOfTuples());
  for (vtkIdType i = 0; i < vectors->GetNumberOfTuples(); ++i) {
    const Vector3d u = vector_of(vectors, i);
    if (!u.allFinite()) return false;
    displacement->SetTuple3(i, u.x(), u.y(), u.z());
  }
  bare->GetPointData()->SetVectors(displacement);
  return true;
}

/// A body's surface with the motion of one mode.
struct MovedSurface {
  vtkPolyData* surface = nullptr;
  vtkDataArray* u = nullptr;
  double largest = 0, largest_normal = 0;  ///< of the displacement and of its part along the normal
  bool tangential = false;
  double bounds[6] = {};
  double diagonal = 0;
};

/// Also sets the surface's colours: the displacement along the normal, or its size where it lies within the surface.
std::optional<MovedSurface> moved_surface(vtkPolyData* surface) {
  MovedSurface moved;
  moved.surface = surface;
  moved.u = surface->GetPointData()->GetArray("u");
  vtkDataArray* normal = surface->GetPointData()->GetNormals();
  const vtkIdType n = surface->GetNumberOfPoints();
  if (n < 3 || !moved.u || !normal) return {};
  for (vtkIdType i = 0; i < n; ++i) {
    moved.largest = std::max(moved.largest, vector_of(moved.u, i).norm());
    moved.largest_normal = std::max(moved.largest_normal, std::abs(vector_of(moved.u, i).dot(vector_of(normal, i))));
  }
  if (!(moved.largest > 0)) return {};
  moved.tangential = moved.largest_normal < 0.03 * moved.largest;
  vtkNew<vtkDoubleArray> shade;
  shade->SetName("shade");
  shade->SetNumberOfTuples(n);
  for (vtkIdType i = 0; i < n; ++i) {
    const Vector3d u = vector_of(moved.u, i);
    shade->SetValue(i, moved.tangential ? u.norm() : u.dot(vector_of(normal, i)));
  }
  surface->GetPointData()->SetScalars(shade);
  surface->GetPointData()->SetActiveVectors("u");
  surface->GetBounds(moved.bounds);
  const double* b = moved.bounds;
  moved.diagonal = Vector3d(b[1] - b[0], b[3] - b[2], b[5] - b[4]).norm();
  return moved;
}

/// Clearly bent, never folded: at most a ninth of the size, and slopes of about a third.
double warp_scale(const MovedSurface& moved) {
  const double slope = steepest(moved.surface, moved.u);
  double scale = moved.diagonal / 9 / moved.largest;
  if (slope > 0) scale = std::min(scale, 0.36 / slope);
  if (moved.tangential) {  // straight paths would make a twisted tube look thicker
    const double* b = moved.bounds;
    scale = std::min(scale, 0.08 * std::min({b[1] - b[0], b[3] - b[2], b[5] - b[4]}) / moved.largest);
  }
  return scale;
}

void add_body(vtkRenderer* renderer, vtkAlgorithmOutput* bent, const MovedSurface& moved) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(bent);
  const auto table = colours(moved.tangential ? moved.largest : moved.largest_normal, !moved.tangential);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  mapper->InterpolateScalarsBeforeMappingOn();
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(2, 2);
  vtkNew<vtkActor> body;
  body->SetMapper(mapper);
  body->GetProperty()->SetInterpolationToPhong();
  body->GetProperty()->SetAmbient(0.22);
  body->GetProperty()->SetDiffuse(0.82);
  body->GetProperty()->SetSpecular(0.12);
  body->GetProperty()->SetSpecularPower(30);
  renderer->AddActor(body);
}

void add_lines(vtkRenderer* renderer, vtkAlgorithmOutput* lines, double grey, double width) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(lines);
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(grey, grey, grey);
  actor->GetProperty()->SetLineWidth(static_cast<float>(width * kSupersampling));
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetOpacity(1.0);
  renderer->AddActor(actor);
}

/// Looks at the body at rest and bent, a little room around. @return size of the picture [pixels]
Eigen::Vector2d aim_camera(vtkRenderer* renderer, const MovedSurface& moved, double scale) {
  const View view = view_of(moved.surface, moved.u);
  const Vector3d right = view.up.cross(view.towards_camera).normalized();
  const Vector3d up = view.towards_camera.cross(right).normalized();
  Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
  const auto cover = [&](const Vector3d& p) {
    const Eigen::Vector2d q(p.dot(right), p.dot(up));
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  };
  for (vtkIdType i = 0, n = moved.surface->GetNumberOfPoints(); i < n; ++i) {
    cover(point_of(moved.surface, i));
    cover(point_of(moved.surface, i) + scale * vector_of(moved.u, i));
  }
  const Eigen::Vector2d extent = 1.06 * (high - low).cwiseMax(1e-3 * moved.diagonal);
  const double largest_height = 0.62 * kPictureWidth;
  double width = kPictureWidth, height = kPictureWidth * extent.y() / extent.x();
  if (height > largest_height) {
    height = largest_height;
    width = height * extent.x() / extent.y();
  }
  const double* b = moved.bounds;
  const Vector3d centre =
      0.5 * (low.x() + high.x()) * right + 0.5 * (low.y() + high.y()) * up +
      view.towards_camera * view.towards_camera.dot(Vector3d(b[0] + b[1], b[2] + b[3], b[4] + b[5]) / 2);
  look(renderer, {centre, centre + 4 * moved.diagonal * view.towards_camera, extent.y() / 2, up});
  return {width, height};
}

std::optional<ModeImage> draw(vtkUnstructuredGrid* grid, int mode) {
  vtkNew<vtkUnstructuredGrid> bare;
  if (!set_displacement(grid, mode, bare)) return {};
  vtkNew<vtkDataSetSurfaceFilter> skin;
  skin->SetInputData(bare);
  skin->SetNonlinearSubdivisionLevel(grid->GetNumberOfCells() > 20000 ? 1 : 2);
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputConnection(skin->GetOutputPort());
  normals->SetFeatureAngle(40);
  normals->ConsistencyOn();
  normals->AutoOrientNormalsOn();
  normals->Update();
  const std::optional<MovedSurface> moved = moved_surface(normals->GetOutput());
  if (!moved) return {};
  const double scale = warp_scale(*moved);
  vtkNew<vtkWarpVector> warped;
  warped->SetInputData(moved->surface);
  warped->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "u");
  warped->SetScaleFactor(scale);
  warped->Update();
  vtkNew<vtkPolyDataNormals> bent_normals;  // for the light
  bent_normals->SetInputConnection(warped->GetOutputPort());
  bent_normals->SplittingOff();
  bent_normals->ConsistencyOff();
  bent_normals->Update();

  vtkNew<vtkRenderer> renderer;
  add_body(renderer, bent_normals->GetOutputPort(), *moved);
  vtkNew<vtkContourFilter> nodes;
  if (!moved->tangential) {
    nodes->SetInputConnection(bent_normals->GetOutputPort());
    nodes->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "shade");
    nodes->SetValue(0, 0.0);
    add_lines(renderer, nodes->GetOutputPort(), 0.10, 1.5);
  }
  vtkNew<vtkFeatureEdges> rest;  // the body at rest
  rest->SetInputConnection(skin->GetOutputPort());
  rest->BoundaryEdgesOff();
  rest->NonManifoldEdgesOff();
  rest->SetFeatureAngle(40);
  rest->ColoringOff();
  add_lines(renderer, rest->GetOutputPort(), 0.55, 1.0);

  const Eigen::Vector2d size = aim_camera(renderer, *moved, scale);
  const int columns = std::max(8, static_cast<int>(std::lround(size.x()))) * kSupersampling;
  const int rows = std::max(8, static_cast<int>(std::lround(size.y()))) * kSupersampling;
  const RgbaImage image = captured(renderer, columns, rows);
  if (image.pixels.empty()) return {};
  ModeImage result;
  result.tangential = moved->tangential;
  result.image = trimmed(reduced(image, kSupersampling), 2);
  return result;
}

}  // namespace

void draw_modes(const std::filesystem::path& modes_file, const std::vector<int>& mode_indices,
                const std::function<void(std::size_t, const std::optional<ModeImage>&)>& done) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(modes_file.c_str());
  reader->UpdateInformation();
  vtkDataArraySelection* arrays = reader->GetPointDataArraySelection();
  arrays->DisableAllArrays();
  for (const int mode : mode_indices) arrays->EnableArray(array_name(mode).c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  for (std::size_t i = 0; i < mode_indices.size(); ++i) done(i, grid ? draw(grid, mode_indices[i]) : std::nullopt);
}

}  // namespace klang::reports::detail
